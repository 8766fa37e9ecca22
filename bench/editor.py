"""Map builder: main-thread time of the browser for one step of dragging a corner on a map of 10,000 vertices.

Prints `editor_drag_ms_10000`. A corner of one of 200 parcels is dragged, snapping on, a step about every 50 ms; the
figure is CPU time of the page's main thread per step: scripts, style, layout and what MapLibre does for the picture.
The naive way, in the same page: the corner being dragged stays in the map's one source, set anew with each step.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from typing import Any

from playwright.sync_api import Page, sync_playwright

from tests.components.editor_page import EditorPage, crowd
from tests.components.map_server import MapServer
from tests.conftest import BROWSER_FLAGS, SOFTWARE_GL
from tests.find_browser import find_browser

NAME = "editor_drag_ms_10000"
PARCELS, CORNERS = 200, 50
STEPS = 60
PERIOD_MS = 50
MEDIAN_OF = 3
CONDITIONS = f"{PARCELS} parcels with {CORNERS} corners each; Chromium, WebGL in software, 1280x800, snapping on"

OURS = """([steps, period]) => new Promise((done) => {
  const canvas = document.querySelector('.maplibregl-canvas');
  const at = editor.project(editor.bench.draft.get('parcel-00000069').geometry.coordinates[0][0]);
  const send = (kind, i) => canvas.dispatchEvent(new PointerEvent(kind, {
    bubbles: true, pointerId: 1, pointerType: 'mouse', button: 0, buttons: 1,
    clientX: at[0] + 20 * Math.sin(i / 5) + 12, clientY: at[1] + 20 * Math.cos(i / 5) - 20 }));
  canvas.dispatchEvent(new PointerEvent('pointerdown', {
    bubbles: true, pointerId: 1, pointerType: 'mouse', button: 0, clientX: at[0], clientY: at[1] }));
  let i = 0;
  const timer = setInterval(() => {
    i += 1;
    send('pointermove', i);
    if (i < steps) return;
    clearInterval(timer);
    window.dispatchEvent(new PointerEvent('pointercancel', { pointerId: 1 }));
    setTimeout(done, 300);
  }, period);
})"""

NAIVE = OURS.replace(
    "let i = 0;",
    """let i = 0;
  const { bench } = editor;
  const { show } = Object.getPrototypeOf(bench);
  bench.show = function (id, live) {
    show.call(bench, id, live);
    const features = bench.draft.features.map((feature) => (feature.id === id && live ? live : feature));
    bench.surface.engine.setFarm({ type: 'FeatureCollection', features });
  };""",
    1,
)


def _per_step(page: Page, script: str) -> float:
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")

    def spent() -> float:
        metrics = session.send("Performance.getMetrics")["metrics"]
        return 1000 * next(float(metric["value"]) for metric in metrics if metric["name"] == "ThreadTime")

    runs = []
    for _ in range(MEDIAN_OF):
        before = spent()
        page.evaluate(script, [STEPS, PERIOD_MS])
        runs.append((spent() - before) / STEPS)
    session.detach()
    return sorted(runs)[len(runs) // 2]


def measure() -> dict[str, Any]:
    """Return the figure."""
    server = MapServer()
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=find_browser(), args=[*BROWSER_FLAGS, *SOFTWARE_GL])
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            surface = EditorPage(page, server)
            surface.open(crowd(PARCELS, CORNERS))
            surface.call("editor.select(['parcel-00000069']); editor.fit(['parcel-00000069'])")
            surface.settle()
            page.evaluate(OURS, [10, PERIOD_MS])  # warm: compiled code
            ours = _per_step(page, OURS)
            assert surface.heard("change") == []  # each drag was given up: the next begins at the same corner
            naive = _per_step(page, NAIVE)
            browser.close()
    finally:
        server.close()
    return {
        "name": NAME,
        "value": round(ours, 2),
        "unit": "ms",
        "naive": round(naive, 2),
        "ratio": round(naive / ours, 1) if ours else None,
        "conditions": f"{CONDITIONS}; naive: the one source set anew each step",
    }


def run(wanted: str | None = None) -> Iterator[dict[str, Any]]:
    """Yield the figure if it is asked for."""
    if wanted in (None, NAME):
        yield measure()


def main() -> int:
    """Print the figure as a JSON line."""
    for figure in run():
        print(json.dumps(figure), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

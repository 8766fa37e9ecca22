"""Fleet screen: main-thread time of the browser for one update of all robots, beside markers and rows of plain DOM.

Prints ``map_update_ms_1000`` and ``map_update_ms_5000``: the whole screen with map, list, figures and the live lane,
every robot reporting twice a second. The value is what the robots add to the same page with one robot, whose clocks,
ages and STOP button run on as well; ``page_ms`` is all that the page takes in the time of one update. CPU time of the
page's main thread and not elapsed time, so that a busy machine does not change it; in a browser that no test driver
listens to. The naive way adds one DOM marker and one DOM row a robot to the same page, brought up to date with the
same data; what the screen itself takes is subtracted.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

from bench.bare_browser import BareBrowser
from tests.conftest import BROWSER_FLAGS, SOFTWARE_GL

COUNTS = (1000, 5000)
RATE_HZ, SECONDS, MEDIAN_OF = 2, 8, 5
CONDITIONS = "Chromium, WebGL in software, 1280x800, 2 reports/s of every robot, whole fleet screen, live lane included"

NAIVE = """(async () => {
  const { engine: { map }, options } = document.querySelector('.f-map .hl-map').hlMap;
  const { Marker } = await import(`${options.vendorUrl}/maplibre-gl.mjs`);
  const table = document.body.appendChild(document.createElement('div'));
  table.style.cssText = 'position:fixed;left:0;top:80px;width:300px;height:400px;overflow:auto;background:white';
  const held = new Map();
  const write = (id, robot, place) => {
    let one = held.get(id);
    if (!one) {
      const element = document.createElement('div');
      element.style.cssText = 'width:20px;height:20px;background:black';
      const marker = new Marker({ element }).setLngLat([place.lon, place.lat]).addTo(map);
      one = { marker, row: table.appendChild(document.createElement('div')) };
      held.set(id, one);
    }
    one.marker.setLngLat([place.lon, place.lat]);
    one.marker.setRotation(place.heading_deg);
    one.row.textContent = `${robot.name} ${robot.task} ${robot.rtt_ms} ms ${(headland.age(robot.t) ?? 0).toFixed(1)} s`;
  };
  headland.on('poses', (state) => {
    const robots = headland.state('fleet')?.robots ?? {};
    for (const [id, place] of Object.entries(state.robots)) if (robots[id]) write(id, robots[id], place);
  });
})()"""


def _per_update(page: BareBrowser) -> float:
    runs = []
    for _ in range(MEDIAN_OF):
        before = page.thread_ms()
        time.sleep(SECONDS)
        runs.append((page.thread_ms() - before) / (SECONDS * RATE_HZ))
    return sorted(runs)[MEDIAN_OF // 2]


def _fleet_page(count: int, *, has_naive: bool) -> tuple[float, float | None, int]:
    """Return ms an update of the fleet screen, of the naive one beside it, and how many rows the list has."""
    stage = subprocess.Popen(
        [sys.executable, "-m", "tests.hmi.pages.stage", "--crowd", str(count)], stdout=subprocess.PIPE, text=True
    )
    assert stage.stdout is not None
    try:
        url = stage.stdout.readline().strip()
        with BareBrowser((*BROWSER_FLAGS, *SOFTWARE_GL), (1280, 800)) as page:
            page.open(f"{url}/fleet", ("stage", "operator"))
            page.wait_for(f"document.querySelector('[data-testid=map]')?.dataset.robots === '{count}'")
            time.sleep(8)  # warm: compiled code, the map's list of robots complete
            ours = _per_update(page)
            rows = int(page.evaluate("document.querySelectorAll('hl-fleet [data-testid^=fleet-row-]').length"))
            if not has_naive:
                return ours, None, rows
            page.evaluate(NAIVE)
            time.sleep(6)
            return ours, max(0.0, _per_update(page) - ours), rows
    finally:
        stage.terminate()
        stage.wait(10)


def measure(count: int, one_robot_ms: float) -> dict[str, Any]:
    """Return the figure for ``count`` robots."""
    page_ms, naive, rows = _fleet_page(count, has_naive=True)
    assert naive is not None
    value = max(0.0, page_ms - one_robot_ms)
    return {
        "name": f"map_update_ms_{count}",
        "value": round(value, 2),
        "unit": "ms",
        "naive": round(naive, 2),
        "ratio": round(naive / value, 1) if value else None,
        "page_ms": round(page_ms, 2),
        "page_ms_one_robot": round(one_robot_ms, 2),
        "conditions": f"{count} robots; {CONDITIONS}; {rows} rows in the page; naive: one DOM marker and row a robot",
    }


def run(wanted: str | None = None) -> Iterator[dict[str, Any]]:
    """Yield the figures, or the one called ``wanted``."""
    one_robot_ms, _, _ = _fleet_page(1, has_naive=False)
    for count in COUNTS:
        if wanted in (None, f"map_update_ms_{count}"):
            yield measure(count, one_robot_ms)


def main() -> int:
    """Print the figures as JSON lines."""
    wanted = sys.argv[1] if len(sys.argv) > 1 else None
    for figure in run(wanted):
        print(json.dumps(figure), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

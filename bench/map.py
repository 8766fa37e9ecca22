"""Map: main-thread time of the browser for one update of all robots, beside one DOM marker per robot.

Prints `map_update_ms_1000` and `map_update_ms_5000`. Both ways run in the same page on the same MapLibre, ten updates
a second; the figure is CPU time of the page's main thread per update: scripts, style, layout and what MapLibre does
for the picture. CPU time and not elapsed time, so that a busy machine does not change it.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from typing import Any

from playwright.sync_api import Page, sync_playwright

from tests.components import map_field
from tests.components.map_server import MapServer
from tests.conftest import BROWSER_FLAGS, SOFTWARE_GL
from tests.find_browser import find_browser

COUNTS = (1000, 5000)
UPDATES = 60
PERIOD_MS = 100  # ten updates a second
MEDIAN_OF = 3
STEPS = 8  # different places, over and over
CONDITIONS = "Chromium, WebGL in software, 1280x800, 10 updates/s, all robots move each time"

SETUP = """(count) => {
  const robots = {};
  const places = {};
  for (let i = 0; i < count; i += 1) {
    const family = ['weeder', 'planter', 'uav'][i % 3];
    robots[`r-${i}`] = { name: `Robot ${i}`, family, mode: 'auto' };
    places[`r-${i}`] = { t: headland.now(), ...place(i, 0) };
  }
  lane.put('fleet', { robots });
  lane.put('poses', { robots: places });
  function place(i, step) {
    const side = Math.ceil(Math.sqrt(count));
    const turn = step / 10 + i;
    const lon = 4.252 + 0.014 * ((i % side) / side) + 2e-5 * Math.cos(turn);
    const lat = 51.7845 + 0.007 * (Math.floor(i / side) / side) + 1e-5 * Math.sin(turn);
    return { lon, lat, heading_deg: (i * 37 + step * 5) % 360 };
  }
  window.count = count;
  // positions are laid beforehand: only the map is measured, not this script
  window.steps = Array.from({ length: STEPS }, (_, step) => Array.from({ length: count }, (_, i) => place(i, step)));
}""".replace("STEPS", str(STEPS))

OURS = """([updates, period]) => new Promise((done) => {
  let step = 0;
  const timer = setInterval(() => {
    step += 1;
    lane.pass(period);
    const t = headland.now();
    const places = steps[step % steps.length];
    const robots = {};
    for (let i = 0; i < count; i += 1) { places[i].t = t; robots[`r-${i}`] = places[i]; }
    lane.put('poses', { robots });
    if (step >= updates) { clearInterval(timer); setTimeout(done, 300); }
  }, period);
})"""

NAIVE_SETUP = """async (count) => {
  const { Marker } = await import('/static/vendor/maplibre/maplibre-gl.mjs');
  window.markers = [];
  for (let i = 0; i < count; i += 1) {
    const { lon, lat } = steps[0][i];
    const element = document.createElement('div');
    element.style.width = element.style.height = '20px';
    element.style.background = 'black';
    markers.push(new Marker({ element }).setLngLat([lon, lat]).addTo(map.engine.map));
  }
}"""

NAIVE = """([updates, period]) => new Promise((done) => {
  let step = 0;
  const next = () => {
    step += 1;
    markers.forEach((marker, i) => {
      const { lon, lat, heading_deg } = steps[step % steps.length][i];
      marker.setLngLat([lon, lat]);
      marker.setRotation(heading_deg);
    });
    if (step >= updates) setTimeout(done, 300);
    else setTimeout(next, period);
  };
  next();
})"""


def _busy_ms(page: Page, script: str, updates: int) -> float:
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")

    def spent() -> float:
        metrics = session.send("Performance.getMetrics")["metrics"]
        return 1000 * next(float(metric["value"]) for metric in metrics if metric["name"] == "ThreadTime")

    before = spent()
    page.evaluate(script, [updates, PERIOD_MS])
    after = spent()
    session.detach()
    return after - before


def _per_update(page: Page, script: str, updates: int) -> float:
    runs = sorted(_busy_ms(page, script, updates) for _ in range(MEDIAN_OF))
    return runs[len(runs) // 2] / updates


def measure(count: int) -> dict[str, Any]:
    """Return the figure for ``count`` robots."""
    server = MapServer()
    server.json("/api/v1/features", map_field.farm())
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=find_browser(), args=[*BROWSER_FLAGS, *SOFTWARE_GL])
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.goto(server.page("/bench", mode="fleet"))
            page.wait_for_function("window.isStarted")
            page.evaluate(SETUP, count)
            page.wait_for_function(f"document.getElementById('map').dataset.robots === '{count}'")
            page.evaluate(OURS, [count // 50, 20])  # warm: compiled code, list of robots complete
            ours = _per_update(page, OURS, UPDATES)
            page.evaluate(NAIVE_SETUP, count)
            page.wait_for_timeout(1000)
            naive = _per_update(page, NAIVE, UPDATES // 3)
            browser.close()
    finally:
        server.close()
    return {
        "name": f"map_update_ms_{count}",
        "value": round(ours, 2),
        "unit": "ms",
        "naive": round(naive, 2),
        "ratio": round(naive / ours, 1) if ours else None,
        "conditions": f"{count} robots; {CONDITIONS}; naive: one DOM marker a robot",
    }


def run(wanted: str | None = None) -> Iterator[dict[str, Any]]:
    """Yield the figures, or the one called ``wanted``."""
    for count in COUNTS:
        if wanted in (None, f"map_update_ms_{count}"):
            yield measure(count)


def main() -> int:
    """Print the figures as JSON lines."""
    wanted = sys.argv[1] if len(sys.argv) > 1 else None
    for figure in run(wanted):
        print(json.dumps(figure), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

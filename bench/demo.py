"""The demo as a person meets it: start, delay from robot to screen, CPU of the console, bytes of a page.

``screen_delay``: from the robot making a value (its wall clock, in the message) to the browser's text having changed,
over broker, console and live lane; one machine, so one clock. ``console_*_cpu``: CPU time of the console's process.
The naive way beside the delay is a page that asks every 0.25 s, which is what the published system shows (250 ms).
"""

from __future__ import annotations

import bisect
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
from playwright.sync_api import Browser, Page, sync_playwright

from bench.heard import Heard
from tests.conftest import BROWSER_FLAGS
from tests.e2e.installation import Installation
from tests.e2e.person import Person
from tests.find_browser import find_browser

ROBOT, HOOK = "weeder-01", "value-cross-track"
WATCHED_S, CPU_S = 20.0, 20.0
SETTLED_S = 20.0  # the demo's past is written and geometry loaded in the first seconds: that is no idle console
PAGES = 5
NAIVE_PERIOD_MS = 250
READY = """() => document.querySelector('[data-testid=stop]')?.dataset.state === 'ready'
  && document.querySelector('[data-testid=value-speed]')?.dataset.value"""
WATCH = """([hook, period]) => {
  const seen = (window.seen = []), polled = (window.polled = []);
  const node = () => document.querySelector(`[data-testid=${hook}]`);
  const now = () => performance.timeOrigin + performance.now();
  let last, lastPolled;
  new MutationObserver(() => {
    const value = node()?.dataset.value;
    if (value !== last) seen.push([(last = value), now()]);
  }).observe(document.body, { subtree: true, attributes: true, attributeFilter: ['data-value'] });
  setInterval(() => {
    const value = node()?.dataset.value;
    if (value !== lastPolled) polled.push([(lastPolled = value), now()]);
  }, period);
}"""


def run() -> Iterator[dict[str, Any]]:
    """Start the whole demo three times for its start, then measure everything else with three robots."""
    yield _start()
    yield _with_cloud()
    with tempfile.TemporaryDirectory() as folder:
        Installation.start(Path(folder) / "data").end()
        running = Installation.start(Path(folder) / "data")
        try:
            with sync_playwright() as playwright:
                path = find_browser()
                options: dict[str, Any] = {"executable_path": path} if path else {}
                flags = [*BROWSER_FLAGS, "--disable-gpu"]
                browser = playwright.chromium.launch(args=flags, **options)
                try:
                    yield from _measure(browser, running)
                finally:
                    browser.close()
                # as `map_engine = "auto"` draws it where WebGL is in software, which keeps the page waiting
                browser = playwright.chromium.launch(args=[*flags, "--disable-webgl"], **options)
                try:
                    yield from _delay(browser, running)
                finally:
                    browser.close()
        finally:
            running.end()


def _start() -> dict[str, Any]:
    """Return how long `make demo` takes with all 24 robots and a filled data folder, the better of two."""
    with tempfile.TemporaryDirectory() as folder:
        times = []
        for _ in range(3):
            running = Installation.start(Path(folder) / "data", fleet="full", has_media=True, has_cameras=True)
            times.append(running.ready_s)
            running.end()
    return _figure("demo_ready_s", min(times[1:]), "s", f"24 robots, second start; the first {times[0]:.1f} s")


def _with_cloud() -> dict[str, Any]:
    """Return what the console takes while it tells a context broker of three robots, sensors and a planner service."""
    with tempfile.TemporaryDirectory() as folder:
        running = Installation.start(Path(folder) / "data", has_cloud=True, has_planner=True)
        try:
            time.sleep(SETTLED_S)
            idle = _cpu_pct(running)
        finally:
            running.end()
    conditions = "three robots at 10 Hz, no page open, context broker, planner service and forecast; first start"
    return _figure("console_idle_cloud_cpu_pct", idle, "% of a core", conditions)


def _measure(browser: Browser, running: Installation) -> Iterator[dict[str, Any]]:
    time.sleep(SETTLED_S)
    idle = _cpu_pct(running)
    conditions = "three robots at 10 Hz, no page open, 20 s after the start"
    yield _figure("console_idle_cpu_pct", idle, "% of a core", conditions)
    yield from _bytes(browser, running)
    yield from _pages(browser, running, idle)


def _bytes(browser: Browser, running: Installation) -> Iterator[dict[str, Any]]:
    _open(browser, running).context.close()  # assets are compressed for the first browser, better ones follow beside
    time.sleep(5)
    page = _come(browser, running)
    for name in ("page_cold_kb", "page_warm_kb"):
        until_ready, whole, took_s, others = _weigh(page, running.url)
        conditions = f"until STOP is ready and tiles show; with the map {whole} kB; {took_s:.2f} s; {others} foreign"
        yield _figure(name, until_ready, "kB", conditions)
    page.context.close()


def _weigh(page: Page, url: str) -> tuple[float, float, float, int]:
    """Return kB until ready, kB with the map, seconds until ready, requests that left the origin."""
    session = page.context.new_cdp_session(page)
    session.send("Network.enable")
    sizes: list[int] = []
    asked: list[str] = []
    session.on("Network.loadingFinished", lambda event: sizes.append(event["encodedDataLength"]))
    session.on("Network.requestWillBeSent", lambda event: asked.append(event["request"]["url"]))
    begun_s = time.monotonic()
    page.goto(f"{url}/operate/{ROBOT}", wait_until="commit")
    page.wait_for_function(READY)
    took_s, until_ready = time.monotonic() - begun_s, sum(sizes)
    page.wait_for_timeout(6000)
    session.detach()
    others = [one for one in asked if not one.startswith((url, "data:", "blob:"))]
    return until_ready / 1000, round(sum(sizes) / 1000, 1), took_s, len(others)


def _pages(browser: Browser, running: Installation, idle_pct: float) -> Iterator[dict[str, Any]]:
    people = [_open(browser, running) for _ in range(PAGES)]
    time.sleep(3)
    busy_pct = _cpu_pct(running)
    for someone in people:
        someone.context.close()
    points = (busy_pct - idle_pct) / PAGES
    yield _figure("console_page_cpu_points", points, "% of a core", f"{PAGES} Operate pages: {busy_pct:.1f} %")


def _delay(browser: Browser, running: Installation) -> Iterator[dict[str, Any]]:
    first = _come(browser, running)
    someone = Person("operator", first.context, running)
    page = someone.page
    first.close()
    someone.open("/missions")
    someone.hook("mission-row-trial-strip").click()
    someone.hook("plan-send").click()
    someone.sees("mission-row-trial-strip", "sent|accepted", within_s=30)
    someone.operate(ROBOT)
    someone.slide("mission-start")
    someone.sees("robot-mode", "auto", within_s=20)
    page.wait_for_timeout(5000)
    with Heard(running.health()["parts"]["broker"]["url"], ROBOT) as heard:
        page.evaluate(WATCH, [HOOK, NAIVE_PERIOD_MS])
        page.wait_for_timeout(WATCHED_S * 1000)
        seen, polled = page.evaluate("[window.seen, window.polled]")
    page.context.close()
    ours, naive = _delays(heard.values, seen), _delays(heard.values, polled)
    for name, share in (("screen_delay_p50_ms", 50), ("screen_delay_p99_ms", 99)):
        figure = _figure(name, _percentile(ours, share), "ms", f"{len(ours)} values in {WATCHED_S:.0f} s, headless")
        slow = _percentile(naive, share)
        yield {**figure, "naive": slow, "ratio": round(slow / max(figure["value"], 0.1), 1)}


def _delays(made: list[tuple[float, float]], seen: list[list[Any]]) -> list[float]:
    """Return for each change on the screen how many ms before the newest message with that value was made."""
    made = sorted((wall_ms, value) for value, wall_ms in made)
    times = [wall_ms for wall_ms, _ in made]
    delays = []
    for text, at_ms in seen[1:]:
        newest = bisect.bisect_right(times, at_ms)
        same = [w for w, value in made[max(0, newest - 20) : newest] if abs(value - float(text)) < 1e-9]
        if same:
            delays.append(at_ms - same[-1])
    return delays


def _percentile(values: list[float], share: int) -> float:
    if len(values) < 2:
        raise RuntimeError("no value of the robot was recognised on the screen")
    return round(statistics.quantiles(values, n=100, method="inclusive")[share - 1], 1)


def _cpu_pct(running: Installation) -> float:
    console = psutil.Process(running.pid("console"))
    before, begun_s = sum(console.cpu_times()[:2]), time.monotonic()
    time.sleep(CPU_S)
    return float(100 * (sum(console.cpu_times()[:2]) - before) / (time.monotonic() - begun_s))


def _come(browser: Browser, running: Installation) -> Page:
    context = browser.new_context(viewport={"width": 1280, "height": 800}, has_touch=True, base_url=running.url)
    body = {"name": "operator", "password": "operator"}
    assert context.request.post("/api/v1/session", data=body).ok
    return context.new_page()


def _open(browser: Browser, running: Installation) -> Page:
    page = _come(browser, running)
    page.goto(f"/operate/{ROBOT}")
    page.wait_for_function(READY)
    return page


def _figure(name: str, value: float, unit: str, conditions: str) -> dict[str, Any]:
    value = round(value, 2)
    return {"name": name, "value": value, "unit": unit, "naive": None, "ratio": None, "conditions": conditions}

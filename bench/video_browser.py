"""Cameras as a person sees them: a real browser in front of the demo, times read from its page.

- ``video_seen_cold_ms``: from the tap that opens the small picture on Operate to the first picture, the first of all:
  no worker ran yet, and the page has not loaded the camera's script.
- ``video_seen_ms``: the same once the drawing process is there; the camera was let go of before. Median.
- ``video_fallback_ms``: from that tap until the page says *Single pictures* where UDP is closed.
- ``video_stall_ms``: from the kill of the camera process to the grey picture that says frozen.
- ``video_freed_ms``: from the end of the page until the server counts nobody who looks. The longest of some.
- ``video_true_delay_ms``: camera to screen as the time code in the pixels tells, median; beside it what the page says.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, sync_playwright

from tests.conftest import BROWSER_FLAGS
from tests.e2e.caller import Caller
from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for
from tests.e2e.test_cameras import NO_UDP, READ_CODE, ROBOT
from tests.find_browser import find_browser

ROUNDS, CODES = 5, 25
LET_GO_S = 7.0  # nobody looked for 5 s: its worker ended
SETTLED_S = 15.0  # the demo's first seconds are not what a person meets
LIMIT_MS = 20_000
TAP = """(wanted) => new Promise((done) => {
  const began = performance.now();
  document.querySelector('[data-testid=pip-toggle]').click();
  const look = () => {
    const state = document.querySelector('[data-testid=pip]')?.dataset.state;
    if (wanted.includes(state)) done(performance.now() - began);
    else requestAnimationFrame(look);
  };
  look();
})"""
WHEN_FROZEN = """() => new Promise((done) => {
  const look = () => document.querySelector('[data-testid=pip]').dataset.state === 'frozen'
    ? done(performance.timeOrigin + performance.now()) : setTimeout(look, 10);
  look();
})"""


def run() -> Iterator[dict[str, Any]]:
    """Yield the figures."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        running = Installation.start(Path(folder) / "data", has_cameras=True)
        path = find_browser()
        options: dict[str, Any] = {"executable_path": path} if path else {}
        flags = [*BROWSER_FLAGS, "--disable-gpu", "--disable-webgl"]
        browser = playwright.chromium.launch(args=flags, **options)
        try:
            time.sleep(SETTLED_S)
            yield from _measure(browser, running)
        finally:
            browser.close()
            running.end()


def _measure(browser: Browser, running: Installation) -> Iterator[dict[str, Any]]:
    with _operator(browser, running) as someone, _watching(running) as count:
        page = _operate(someone)
        yield _figure(
            "video_seen_cold_ms", _tapped(page), "tap to first picture, the first since the start of the demo"
        )
        seen = []
        for _ in range(ROUNDS):
            someone.hook("pip-toggle").click()
            wait_for(lambda: count() == 0, within_s=5, what="nobody looks")
            time.sleep(LET_GO_S)
            seen.append(_tapped(page))
        yield _figure(
            "video_seen_ms", statistics.median(seen), f"the same with the demo's drawing process there: {_told(seen)}"
        )
        someone.sees("pip", "live")
        yield _delay(page)
        yield _stall(page, running)
        someone.hook("pip-toggle").click()  # from here on others look
        yield _fallback(browser, running)
        yield _freed(browser, running, count)


@contextlib.contextmanager
def _operator(browser: Browser, running: Installation, script: str = "") -> Iterator[Person]:
    context = browser.new_context(viewport={"width": 1280, "height": 800}, base_url=running.url, has_touch=True)
    if script:
        context.add_init_script(script)
    try:
        someone = Person("operator", context, running)
        someone.come_in()
        yield someone
    finally:
        context.close()


@contextlib.contextmanager
def _watching(running: Installation) -> Iterator[Any]:
    caller = Caller(running.url, "viewer")
    try:
        yield lambda: sum(one["viewers"] for one in caller.get(f"/cameras?robot={ROBOT}")["cameras"])
    finally:
        caller.close()


def _operate(someone: Person) -> Page:
    someone.operate(ROBOT)
    someone.hook("pip-toggle").wait_for()
    time.sleep(2.0)
    return someone.page


def _tapped(page: Page, wanted: tuple[str, ...] = ("live", "stills")) -> float:
    page.set_default_timeout(LIMIT_MS)
    return float(page.evaluate(TAP, list(wanted)))


def _delay(page: Page) -> dict[str, Any]:
    found: list[dict[str, float]] = []
    while len(found) < CODES:
        if read := page.evaluate(READ_CODE):
            found.append(read)
        page.wait_for_timeout(70)
    shown = statistics.median(one["shownMs"] for one in found)
    conditions = f"time code read from the pixels, 15 pictures/s; the page says {shown:.0f} ms"
    return _figure("video_true_delay_ms", statistics.median(one["trueMs"] for one in found), conditions)


def _stall(page: Page, running: Installation) -> dict[str, Any]:
    pid, killed_ms = running.pid("cameras"), time.time() * 1000
    os.kill(pid, signal.SIGKILL)
    return _figure("video_stall_ms", page.evaluate(WHEN_FROZEN) - killed_ms, "camera process killed to frozen overlay")


def _fallback(browser: Browser, running: Installation) -> dict[str, Any]:
    with _operator(browser, running, NO_UDP) as someone:
        page = _operate(someone)
        _tapped(page)  # the camera gives pictures: what is measured is the way, not the camera
        someone.hook("pip-toggle").click()
        return _figure("video_fallback_ms", _tapped(page, ("stills",)), "UDP closed: tap to *Single pictures*")


def _freed(browser: Browser, running: Installation, count: Any) -> dict[str, Any]:
    took = []
    for _ in range(ROUNDS):
        with _operator(browser, running) as someone:
            page = _operate(someone)
            _tapped(page)
            someone.sees("pip", "live")
            page.close()
            took.append(1000 * wait_for(lambda: count() == 0, within_s=10, what="the server lets go"))
    return _figure("video_freed_ms", max(took), f"page closed to nobody counted, the longest of {_told(took)}")


def _told(values: list[float]) -> str:
    return ", ".join(f"{one:.0f}" for one in values)


def _figure(name: str, value: float, conditions: str) -> dict[str, Any]:
    return {"name": name, "value": round(value), "unit": "ms", "naive": None, "ratio": None, "conditions": conditions}


if __name__ == "__main__":
    for one in run():
        print(json.dumps(one), flush=True)

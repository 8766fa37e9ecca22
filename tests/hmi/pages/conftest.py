"""The stage in its own process, and people who look at it."""

from __future__ import annotations

import json
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Page

from hmi.pages.bundle import STATIC

ARRIVAL_S = 15.0
SIZES = {"landscape": (1280, 800), "portrait": (800, 1280), "desk": (1920, 1080)}
TABLETS = ["landscape", *(pytest.param(size, marks=pytest.mark.long) for size in ("portrait", "desk"))]


ICONS = (STATIC / "icons" / "icons.txt").read_text("utf-8").split()
ICONS_SHOWN = "[...document.querySelectorAll('.h-i')].map((sign) => sign.textContent)"


class Theatre:
    """The running stage, seen from a test."""

    def __init__(self, url: str) -> None:
        self.url = url

    def play(self, scene: str, **changes: Any) -> None:
        """Show a scene, with changes to it."""
        self._post(f"/stage/{scene}", {})
        if changes:
            self._post("/stage-set", changes)

    def play_map(self, **wish: Any) -> None:
        """Set the farm map; ``anew=True`` begins with the published one."""
        self._post("/stage-map", wish)

    def machine(self, **wish: Any) -> None:
        """Show the planter's inside with changes, see ``MachineStage``; ``off=True`` takes it away."""
        self._post("/stage-machine", wish)

    def alarms(self, **wish: Any) -> None:
        """Set alarms: ``put={id: changes}``, ``drop=[ids]``, ``tell=[events]``; see ``AlarmStage``."""
        self._post("/stage-alarms", wish)

    def planter(self, **wish: Any) -> None:
        """Set what the planter does: ``anew``, ``active=[[state, age_s]]``, ``last``, ``has_chart``, ``is_silent``."""
        self._post("/stage-super", wish)

    def cameras(self, **wish: Any) -> None:
        """Set cameras, see ``CameraStage``; ``anew=True`` begins anew."""
        self._post("/stage-cameras", wish)

    def heard_cameras(self) -> dict[str, Any]:
        """Return what pages watch now, and what was asked of cameras."""
        with urllib.request.urlopen(f"{self.url}/stage-cameras") as reply:
            answer: dict[str, Any] = json.loads(reply.read())
            return answer

    def sensors(self, **wish: Any) -> None:
        """Set field stations, see ``SensorStage``; ``anew=True`` begins anew."""
        self._post("/stage-sensors", wish)

    def heard_sensors(self) -> dict[str, Any]:
        """Return how often stations were asked for, and what people changed."""
        with urllib.request.urlopen(f"{self.url}/stage-sensors") as reply:
            answer: dict[str, Any] = json.loads(reply.read())
            return answer

    def heard_map(self) -> dict[str, Any]:
        """Return what reached the farm map, and what it is now."""
        with urllib.request.urlopen(f"{self.url}/stage-map") as reply:
            answer: dict[str, Any] = json.loads(reply.read())
            return answer

    def heard(self) -> dict[str, Any]:
        """Return what reached the console since the scene began."""
        with urllib.request.urlopen(f"{self.url}/stage-heard") as reply:
            answer: dict[str, Any] = json.loads(reply.read())
            return answer

    def orders(self, part: str) -> list[dict[str, Any]]:
        """Return the orders whose path contains ``part``."""
        return [order for order in self.heard()["orders"] if part in order["path"]]

    def until_heard(self, fits: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """Return what reached the console as soon as it fits, and fail when it does not.

        ``wait_for_function`` cannot wait for it: it takes any promise that is kept for an answer.
        """
        end_s = time.monotonic() + ARRIVAL_S
        while not fits(heard := self.heard()):
            assert time.monotonic() < end_s, f"the newest of it: {heard['drives'][-5:]} {heard['orders'][-2:]}"
            time.sleep(0.02)
        return heard

    def until_drives(self, fits: Callable[[list[dict[str, float]]], bool]) -> None:
        """Wait until at least one setpoint came and all that came fit."""
        self.until_heard(lambda heard: bool(heard["drives"]) and fits(heard["drives"]))

    def until_orders(self, part: str, count: int = 1) -> list[dict[str, Any]]:
        """Return the orders whose path contains ``part`` when there are as many; a click is heard a moment later."""
        end_s = time.monotonic() + ARRIVAL_S
        while len(found := self.orders(part)) < count and time.monotonic() < end_s:
            time.sleep(0.02)
        return found

    def _post(self, path: str, body: dict[str, Any]) -> None:
        request = urllib.request.Request(f"{self.url}{path}", json.dumps(body).encode(), method="POST")
        request.add_header("content-type", "application/json")
        urllib.request.urlopen(request).close()


@pytest.fixture(scope="session")
def theatre() -> Iterator[Theatre]:
    """One stage for all tests of screens."""
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.hmi.pages.stage"], stdout=subprocess.PIPE, text=True, bufsize=1
    )
    assert process.stdout is not None
    line = process.stdout.readline().strip()
    assert line.startswith("http://127.0.0.1:"), "the stage did not start"
    yield Theatre(line)
    process.terminate()
    process.wait(timeout=10)
    process.stdout.close()


@pytest.fixture(scope="session")
def tablets(plain_browser: Browser, theatre: Theatre) -> Iterator[dict[str, BrowserContext]]:
    """Browsers by size that stay open for all tests: what they fetched and compiled once, they keep."""
    kept: dict[str, BrowserContext] = {}
    yield kept
    for context in kept.values():
        context.close()


def take(browser: Browser, size: str, url: str) -> BrowserContext:
    """Return a new browser of a size."""
    width, height = SIZES[size]
    return browser.new_context(viewport={"width": width, "height": height}, has_touch=size != "desk", base_url=url)


@pytest.fixture
def look(plain_browser: Browser, theatre: Theatre, tablets: dict[str, BrowserContext]) -> Iterator[Callable[..., Page]]:
    """Give a page: ``look("/fleet", role="operator", size="portrait")``; script errors fail the test.

    ``may_break`` is for tests that break the page themselves. ``is_new`` is for those that change the browser itself;
    another one of the same size in the same test is always new.
    """
    new: list[BrowserContext] = []
    pages: dict[str, Page] = {}
    problems: list[str] = []

    def open_page(
        path: str = "/operate/weeder-07",
        *,
        role: str = "operator",
        size: str = "landscape",
        may_break: bool = False,
        is_new: bool = False,
    ) -> Page:
        if is_new or size in pages:
            new.append(take(plain_browser, size, theatre.url))
            page = new[-1].new_page()
        else:
            if size not in tablets:
                tablets[size] = take(plain_browser, size, theatre.url)
            page = pages[size] = tablets[size].new_page()
            page.context.clear_cookies()
            page.goto("/stage-heard")  # any answer of this origin: its stores are emptied
            page.evaluate("localStorage.clear(), sessionStorage.clear()")
        if role:
            page.context.add_cookies([{"name": "stage", "value": role, "url": theatre.url}])
        if not may_break:
            page.on("pageerror", lambda error: problems.append(str(error)))
        page.goto(path)
        return page

    yield open_page
    opened = [*pages.values(), *(page for context in new for page in context.pages)]
    for page in [page for page in opened if not page.is_closed()]:
        problems.extend(f"no icon {name}" for name in page.evaluate(ICONS_SHOWN) if name not in ICONS)
        page.close()
    for context in new:
        context.close()
    assert problems == []

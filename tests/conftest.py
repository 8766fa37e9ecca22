"""What all tests share: the browser."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import Phase, settings
from hypothesis.internal.conjecture import providers
from playwright.sync_api import Browser, BrowserType, expect

from tests.find_browser import find_browser

# `make test` draws the same examples each time, `make test-long` new ones: what fails there is then kept as a test.
# No explain phase: it traces every line and makes minutes out of a planner's second.
_PHASES = (Phase.explicit, Phase.reuse, Phase.generate, Phase.target, Phase.shrink)
settings.register_profile("same", derandomize=True, deadline=None, phases=_PHASES)
settings.register_profile("new", deadline=None, phases=_PHASES, print_blob=True)
if os.environ.get("HEADLAND_LONG"):
    settings.load_profile("new")
else:
    settings.load_profile("same")
    # Hypothesis also draws constants out of whatever modules are loaded by then: other ones in each worker and run.
    providers._get_local_constants = lambda: providers._local_constants

expect.set_options(timeout=15_000)  # a busy machine is late, not wrong

BROWSER_FLAGS = (
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
SOFTWARE_GL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@pytest.fixture(scope="session")
def browser_type_launch_args(browser_type_launch_args: dict[str, Any]) -> dict[str, Any]:
    """Use the system's Chromium where there is one, with WebGL in software."""
    path = find_browser()
    found = {"executable_path": path} if path else {}
    return {**browser_type_launch_args, **found, "args": [*BROWSER_FLAGS, *SOFTWARE_GL]}


@pytest.fixture(scope="session")
def plain_browser(browser_type: BrowserType, browser_type_launch_args: dict[str, Any]) -> Iterator[Browser]:
    """A browser without WebGL: the map draws on its canvas, which leaves the processor to the screens."""
    flags = [flag for flag in browser_type_launch_args.get("args", []) if "gl" not in flag.split("=")[0]]
    browser = browser_type.launch(**{**browser_type_launch_args, "args": [*flags, "--disable-gpu", "--disable-webgl"]})
    yield browser
    browser.close()


# what drives an app with its database over HTTP, or other processes: not for the inner loop
_WHOLE_APPS = re.compile(
    r"tests/(contract|e2e|faults|interop)/|tests/hmi/(api|app|cameras|cloud|demo|media|pictures|planning_service|queue"
    r"|security|sensors)/|/(forecast|context_broker)/|test_(lane|records|second_try)"
    r"|tests/hmi/(?!planning|domain)\w+/test_\w*rest\w*\.py"  # REST; what is left of a mission is a rule
)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Let the inner loop not even read what it leaves out."""
    if "not slow" not in config.getoption("markexpr"):
        return None
    place = f"{collection_path.as_posix()}/" if collection_path.is_dir() else collection_path.as_posix()
    return True if _WHOLE_APPS.search(place) else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark whole apps as ``slow``, and whatever asks for a page as ``browser``.

    The two runs of ``make test`` must not mix: the browser's driver runs an event loop in the main thread, in which no
    asyncio test can start its own.
    """
    for item in items:
        if {"page", "browser", "plain_browser", "playwright"} & set(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.browser)
        if _WHOLE_APPS.search(item.path.as_posix()):
            item.add_marker(pytest.mark.slow)

"""What all tests share: the browser."""

from __future__ import annotations

from typing import Any

import pytest

from tests.find_browser import find_browser

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

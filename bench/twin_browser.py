"""The twin as a person sees it: a real browser, drawn in software, in front of the demo.

- ``twin_reconnect_ms``: from the moment the page knows that the line to the picture was cut until the picture is
  connected again, without a touch and without the page in focus. The longest of some.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from playwright.sync_api import Page, sync_playwright

from tests.conftest import BROWSER_FLAGS, SOFTWARE_GL
from tests.e2e.cuttable import CuttableLine
from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for
from tests.e2e.test_twin import FIRST_PICTURE_S, RECONNECT_WATCH, ROBOT, media_is_there
from tests.find_browser import find_browser

ROUNDS = 10
REST_S = 1.5  # between two cuts: the page has to have drawn again


def run() -> Iterator[dict[str, Any]]:
    """Yield the figure."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        running = Installation.start(Path(folder) / "data", has_media=True)
        path = find_browser()
        options: dict[str, Any] = {"executable_path": path} if path else {}
        browser = playwright.chromium.launch(args=[*BROWSER_FLAGS, *SOFTWARE_GL], **options)
        try:
            media_is_there(running)
            with CuttableLine(urlsplit(running.url).port or 0) as line:
                context = browser.new_context(viewport={"width": 1280, "height": 800}, base_url=line.url)
                yield _figure(_cut(line, Person("viewer", context, running)))
        finally:
            browser.close()
            running.end()


def _cut(line: CuttableLine, someone: Person) -> list[float]:
    someone.come_in()
    someone.open(f"{line.url}/twin/{ROBOT}")
    someone.sees("twin", "live", within_s=FIRST_PICTURE_S)
    page: Page = someone.page
    page.evaluate(RECONNECT_WATCH)
    took = []
    for _ in range(ROUNDS):
        line.cut(b"GET /viser?")
        wait_for(lambda: page.evaluate("window.backAfterMs.length"), within_s=30, what="the picture is back")
        took.append(float(page.evaluate("window.backAfterMs.pop()")))
        time.sleep(REST_S)
    return took


def _figure(took: list[float]) -> dict[str, Any]:
    conditions = f"line cut, drawn in software at 1280x800, the longest of {', '.join(f'{one:.0f}' for one in took)}"
    return {
        "name": "twin_reconnect_ms",
        "value": round(max(took)),
        "unit": "ms",
        "naive": None,
        "ratio": None,
        "conditions": conditions,
    }


if __name__ == "__main__":
    for one in run():
        print(json.dumps(one), flush=True)

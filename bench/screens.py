"""``make screens``: every screen in sizes and themes, from a running demo, into ``docs/screens``."""

from __future__ import annotations

import io
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, sync_playwright

from tests.conftest import BROWSER_FLAGS, SOFTWARE_GL
from tests.e2e.installation import ROOT, Installation
from tests.e2e.person import Person
from tests.find_browser import find_browser

OUT = ROOT / "docs" / "screens"
SIZES = {"landscape": (1280, 800), "portrait": (800, 1280), "desk": (1920, 1080)}
THEMES = ("day", "night", "sunlight")
ROBOT, MISSION, ROW = "weeder-02", "trial-strip-rows", 3  # half done
SCREENS = {
    "operate": f"/operate/{ROBOT}",
    "fleet": "/fleet",
    "maps": "/maps",
    "missions": "/missions",
    "alarms": "/alarms",
}
ADMIN_SCREENS = {"admin": "/admin"}
COLOURS = 96  # flat surfaces and text lose nothing visible, files shrink to a third
SETTLE_MS = 2500


def main() -> int:
    """Write the pictures; return an exit code."""
    OUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        running = Installation.start(Path(folder) / "data", fleet="full")
        try:
            path = find_browser()
            options: dict[str, Any] = {"executable_path": path} if path else {}
            browser = playwright.chromium.launch(args=[*BROWSER_FLAGS, *SOFTWARE_GL], **options)
            for name in [*_signed_out(browser, running), *_screens(browser, running)]:
                print(name)
            browser.close()
        finally:
            running.end()
    return 0


def _signed_out(browser: Browser, running: Installation) -> Iterator[str]:
    someone = _come(browser, running, "operator", "landscape")
    someone.page.goto("/login")
    yield _shoot(someone, "login-landscape-day")
    someone.context.close()


def _screens(browser: Browser, running: Installation) -> Iterator[str]:
    martha = _come(browser, running, "operator", "landscape")
    martha.sign_in()
    _start_mission(martha, running)
    yield from _all_looks(martha, SCREENS)
    yield from _situations(martha, running)
    martha.context.close()
    yield from _map_builder(browser, running)
    jonas = _come(browser, running, "admin", "landscape")
    jonas.sign_in()
    yield from _all_looks(jonas, ADMIN_SCREENS)
    jonas.context.close()


def _map_builder(browser: Browser, running: Installation) -> Iterator[str]:
    """Show a field being edited: for ``docs/maps.md``."""
    pieter = _come(browser, running, "planner", "landscape")
    pieter.sign_in()
    page = pieter.page
    page.evaluate("localStorage.setItem('headland.theme', 'day')")
    page.goto("/maps")
    pieter.hook("editor-edit").click()
    pieter.sees("maps", "draft")
    pieter.hook("feature-row-polder-17").click()
    yield _shoot(pieter, "maps-edit-landscape-day")
    pieter.hook("feature-reshape").click()
    pieter.hook("reshape-inset").click()
    pieter.hook("reshape-value").fill("15")
    page.wait_for_function("document.querySelector('[data-testid=reshape-effect]').textContent.includes(' to ')")
    yield _shoot(pieter, "maps-reshape-landscape-day")
    pieter.hook("reshape-close").click()
    pieter.hook("feature-crop").fill("Spinach")
    pieter.hook("feature-crop").press("Enter")
    page.wait_for_function("document.querySelectorAll('[data-testid=editor-changes] [data-state=saved]').length === 1")
    pieter.hook("editor-publish").click()
    pieter.hook("publish-note").fill("Spinach after sugar beet")
    pieter.hook("publish-go").click()
    pieter.sees("maps", "published")
    pieter.hook("feature-history").click()
    pieter.hook("history").get_by_text("Crop: Sugar beet to Spinach").wait_for()
    yield _shoot(pieter, "maps-history-landscape-day")
    pieter.context.close()


def _all_looks(someone: Person, screens: dict[str, str]) -> Iterator[str]:
    for size, (width, height) in SIZES.items():
        someone.page.set_viewport_size({"width": width, "height": height})
        for theme in THEMES:
            someone.page.evaluate(f"localStorage.setItem('headland.theme', '{theme}')")
            for screen, path in screens.items():
                someone.page.goto(path)
                yield _shoot(someone, f"{screen}-{size}-{theme}")


def _start_mission(martha: Person, running: Installation) -> None:
    martha.page.goto("/missions")
    martha.hook(f"mission-row-{MISSION}").click()
    martha.hook("plan-send").click()
    martha.sees(f"mission-row-{MISSION}", "sent|accepted", within_s=30)
    martha.operate(ROBOT)
    running.simulator("POST", "/_world", {"speed": 20})
    martha.slide("mission-start")
    martha.page.wait_for_function(
        f"() => Number(document.querySelector('[data-testid=value-row]')?.dataset.value) >= {ROW}", timeout=300_000
    )
    running.simulator("POST", "/_world", {"speed": 1})


def _situations(martha: Person, running: Installation) -> Iterator[str]:
    width, height = SIZES["landscape"]
    martha.page.set_viewport_size({"width": width, "height": height})
    martha.page.evaluate("localStorage.setItem('headland.theme', 'day')")
    martha.page.goto(f"/operate/{ROBOT}")
    running.fault(ROBOT, "silence", http=True, deaf=True)
    martha.sees("link-banner", "robot-lost", within_s=10)
    yield _shoot(martha, "operate-no-link")
    martha.press_stop()
    martha.sees("stop", "not-confirmed", within_s=10)
    yield _shoot(martha, "operate-stop-not-confirmed")
    running.mend(ROBOT)
    martha.sees("stop", "standstill", within_s=20)
    yield _shoot(martha, "operate-stop-latched")


def _come(browser: Browser, running: Installation, name: str, size: str) -> Person:
    width, height = SIZES[size]
    context = browser.new_context(
        viewport={"width": width, "height": height}, has_touch=size != "desk", base_url=running.url
    )
    return Person(name, context, running)


def _shoot(someone: Person, name: str) -> str:
    someone.page.wait_for_timeout(SETTLE_MS)
    picture = Image.open(io.BytesIO(someone.page.screenshot()))
    flat = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    flat.save(OUT / f"{name}.png", optimize=True)
    return f"{name}.png"


if __name__ == "__main__":
    sys.exit(main())

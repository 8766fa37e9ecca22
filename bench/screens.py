"""``make screens``: every screen in sizes and themes, from a running demo, into ``docs/screens``.

``python -m bench.screens twin supervisor`` takes the screens named and nothing else.
"""

from __future__ import annotations

import io
import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, expect, sync_playwright

from tests.conftest import BROWSER_FLAGS, SOFTWARE_GL
from tests.e2e.installation import ROOT, Installation
from tests.e2e.person import Person
from tests.e2e.test_farmer import send_mission
from tests.find_browser import find_browser

OUT = ROOT / "docs" / "screens"
SIZES = {"landscape": (1280, 800), "portrait": (800, 1280), "desk": (1920, 1080)}
THEMES = ("day", "night", "sunlight")
ROBOT, MISSION = "weeder-01", "trial-strip"
ROWS_DONE = 5  # of the working robot that Operate shows
COLOURS = 96  # beside those of signs: flat surfaces and text lose nothing visible, files shrink to a third
COLOURS_OF_PICTURES = 220  # with fewer, a wall of cameras has steps in it
SETTLE_MS, SETTLE_TWIN_MS = 1500, 8000  # the ground of another theme is drawn in software first
Prepare = Callable[[Person], None]


def _as_it_opens(someone: Person) -> None:
    """Leave the screen as it opens; a map comes a little later."""
    someone.page.wait_for_function(
        "!document.querySelector('.hl-map') || window.headlandMap?.state()?.frame > 2", timeout=60_000
    )


def main() -> int:
    """Write the pictures; return an exit code."""
    OUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        running = Installation.start(Path(folder) / "data", fleet="full", has_media=True, has_cameras=True)
        try:
            path = find_browser()
            options: dict[str, Any] = {"executable_path": path} if path else {}
            browser = playwright.chromium.launch(args=[*BROWSER_FLAGS, *SOFTWARE_GL], **options)
            for part in PARTS if len(sys.argv) == 1 else (_screens,):
                for name in part(browser, running):
                    print(name, flush=True)
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
    for name, (who, path, prepare) in SCREENS.items():
        if len(sys.argv) > 1 and name not in sys.argv:
            continue
        for sizes in (("landscape", "portrait"), ("desk",)) if name in WIDE else (tuple(SIZES),):
            someone = _come(browser, running, who, sizes[0])
            someone.sign_in()
            someone.open(path if path != WORKING else f"/operate/{_working(someone)}")
            prepare(someone)
            yield from _all_looks(someone, name, sizes)
            someone.context.close()


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


def _all_looks(someone: Person, name: str, sizes: tuple[str, ...]) -> Iterator[str]:
    """Shoot a screen as it stands in each size and theme; nothing of it is opened anew."""
    for size in sizes:
        width, height = SIZES[size]
        someone.page.set_viewport_size({"width": width, "height": height})
        for theme in THEMES:
            while (before := someone.state("theme")) != theme:
                someone.hook("theme").click()
                expect(someone.hook("theme")).not_to_have_attribute("data-state", str(before))
            yield _shoot(someone, f"{name}-{size}-{theme}")


def _working(someone: Person) -> str:
    """Wait for a weeder that is well under way; return its id."""
    for _ in range(120):
        robots = someone.context.request.get("/api/v1/robots").json()["robots"]
        for robot in robots:
            mission = robot.get("mission") or {}
            if robot["id"].startswith("weeder") and mission.get("status") == "running" and mission["row"] >= ROWS_DONE:
                return str(robot["id"])
        someone.page.wait_for_timeout(1000)
    raise RuntimeError("no weeder of the demo got to work within two minutes")


def _plan(someone: Person) -> None:
    someone.hook("mission-plan").click()
    someone.hook("plan-preview").click()
    someone.hook("plan-compare-spiral").locator("xpath=self::*[@data-state!='planning']").wait_for(timeout=120_000)


def _queue(someone: Person) -> None:
    for mission in (MISSION, "trial-strip-rows"):
        someone.hook(f"mission-row-{mission}").click()
        someone.hook("mission-add-to-queue").click()
        someone.hook("queue-add").get_by_role("button", name="Add to queue").click()
        someone.hook("queue-add").wait_for(state="detached")
    someone.hook("missions-tab-queue").click()


def _alarms(someone: Person) -> None:
    rows = someone.page.locator("[data-testid^=alarm-row-]")
    rows.first.wait_for(timeout=120_000)
    rows.first.click()


def _situations(browser: Browser, running: Installation) -> Iterator[str]:
    """Show what a farmer meets on one robot, in the order in which she meets it."""
    martha = _come(browser, running, "operator", "landscape")
    martha.sign_in()
    send_mission(martha)
    martha.operate(ROBOT)
    martha.hook("mission-checks").click()
    yield _shoot(martha, "operate-checks")
    martha.hook("start-sheet").get_by_role("button", name="Close").click()
    martha.slide("mission-start")
    martha.page.wait_for_function(
        "() => Number(document.querySelector('[data-testid=value-row]')?.dataset.value) >= 1", timeout=300_000
    )
    martha.press("mission-pause")
    martha.sees("robot-mode", "paused")
    martha.hook("mission-change").click()
    martha.sees("rest-said", "ready", within_s=60)
    yield _shoot(martha, "operate-change-the-rest")
    martha.hook("rest-sheet").get_by_role("button", name="Keep it as it is").click()
    running.fault(ROBOT, "silence", http=True, deaf=True)
    martha.sees("link-banner", "robot-lost", within_s=10)
    yield _shoot(martha, "operate-no-link")
    martha.press_stop()
    martha.sees("stop", "not-confirmed", within_s=10)
    yield _shoot(martha, "operate-stop-not-confirmed")
    running.mend(ROBOT)
    martha.sees("stop", "standstill", within_s=20)
    yield _shoot(martha, "operate-stop-latched")
    martha.context.close()


def _come(browser: Browser, running: Installation, name: str, size: str) -> Person:
    width, height = SIZES[size]
    context = browser.new_context(
        viewport={"width": width, "height": height}, has_touch=size != "desk", base_url=running.url
    )
    return Person(name, context, running)


def _shoot(someone: Person, name: str) -> str:
    someone.page.wait_for_timeout(SETTLE_TWIN_MS if name.startswith("twin") else SETTLE_MS)
    picture = Image.open(io.BytesIO(someone.page.screenshot())).convert("RGB")
    flat = with_palette(picture, COLOURS_OF_PICTURES if name.startswith("cameras") else COLOURS)
    flat.save(OUT / f"{name}.png", optimize=True)
    return f"{name}.png"


def with_palette(picture: Image.Image, colours: int) -> Image.Image:
    """Return a picture of ``colours`` colours and those of signs beside them: alarms and STOP, each as it is.

    A palette made from areas alone gives the few pixels of an orange triangle the yellow of a diamond.
    """
    pixels = np.asarray(picture)
    found = [sign for sign in signs() if (pixels == sign).all(axis=2).any()]
    flat = picture.quantize(colours, dither=Image.Dither.NONE)
    palette = (flat.getpalette() or [])[: 3 * colours]
    places = np.array(flat)
    for number, sign in enumerate(found, len(palette) // 3):
        places[(pixels == sign).all(axis=2)] = number
    kept = Image.fromarray(places, "P")
    kept.putpalette([*palette, *(part for sign in found for part in sign)])
    return kept


def signs() -> list[tuple[int, int, int]]:
    """Return the colours of priorities and of STOP in all themes, as red, green, blue."""
    text = (ROOT / "static" / "css" / "tokens.css").read_text("utf-8")
    named = set(re.findall(r"--hl-(?:p[1-4]|stop-[\w-]+): #([0-9a-f]{6});", text))
    return [(int(one[:2], 16), int(one[2:4], 16), int(one[4:], 16)) for one in sorted(named)]


def _twin(someone: Person) -> None:
    someone.sees("twin", "live", within_s=90)
    someone.page.wait_for_timeout(15_000)  # the model and its surroundings come after the first picture


def _cameras(someone: Person) -> None:
    shown = ", ".join(f"[data-testid^='camera-'][data-state='{state}']" for state in ("live", "stills"))
    someone.page.locator(shown).first.wait_for(timeout=60_000)
    someone.page.wait_for_timeout(8_000)  # each camera's worker starts when it is first looked at


def _sensors(someone: Person) -> None:
    someone.sees("sensor-weather-01", "fresh", within_s=120)
    someone.page.locator(".sn-chart:not([data-points='0'])").wait_for(timeout=120_000)
    someone.page.wait_for_function("window.headlandMap?.state()?.frame > 2", timeout=60_000)


WORKING = "a weeder at work"
WIDE = ("supervisor", "twin")
"""Screens that a mouse on a desk shows otherwise than a finger does."""
SCREENS: dict[str, tuple[str, str, Prepare]] = {
    "fleet": ("supervisor", "/fleet", _as_it_opens),
    "alarms": ("supervisor", "/alarms", _alarms),
    "operate": ("operator", WORKING, _as_it_opens),
    "cameras": ("operator", "/cameras", _cameras),
    "maps": ("planner", "/maps", _as_it_opens),
    "missions": ("operator", "/missions", _as_it_opens),
    "plan": ("planner", "/missions", _plan),
    "queue": ("planner", "/missions", _queue),
    "supervisor": ("admin", "/supervisor/planter-01", _as_it_opens),
    "twin": ("admin", "/twin/planter-03", _twin),
    "sensors": ("planner", "/sensors", _sensors),
    "admin": ("admin", "/admin", _as_it_opens),
}
"""Screen to who opens it, where, and what they do there before it is shown."""
PARTS = (_signed_out, _screens, _map_builder, _situations)


if __name__ == "__main__":
    sys.exit(main())

"""Ground drawn with a finger on the rest of a mission that stands."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence

import pytest
from playwright.sync_api import expect

from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for
from tests.e2e.test_farmer import send_mission

pytestmark = pytest.mark.browser
Come = Callable[..., Person]
ROBOT = "weeder-01"


def touch(someone: Person, places: Sequence[tuple[float, float]]) -> None:
    """Draw a line with a finger."""
    hand = someone.context.new_cdp_session(someone.page)
    for number, (x, y) in enumerate(places):
        kind = "touchMove" if number else "touchStart"
        hand.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
    hand.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def circle(someone: Person, across: float, down: float, radius_px: float) -> list[tuple[float, float]]:
    """Return places around a point of the map, given as shares of its picture."""
    box = someone.box("rest-map")
    x, y = box["x"] + across * box["width"], box["y"] + down * box["height"]
    turns = [2 * math.pi * k / 24 for k in range(25)]
    return [(x + radius_px * math.cos(turn), y + radius_px * math.sin(turn)) for turn in turns]


@pytest.mark.long
@pytest.mark.parametrize("size", ["landscape", "portrait"])
def test_an_area_and_an_obstacle_drawn_by_finger_change_the_rest(person: Come, calm: Installation, size: str) -> None:
    calm.simulator("POST", "/_world", {"speed": 10})
    martha = person("operator", size=size)
    send_mission(martha)
    martha.operate(ROBOT)
    martha.slide("mission-start")
    expect(martha.hook("value-row")).to_have_attribute("data-value", re.compile("^[1-9]"), timeout=90_000)
    martha.press("mission-pause")
    martha.sees("robot-mode", "paused")
    wait_for(lambda: calm.world(ROBOT)["standstill"], within_s=5, what="paused robot stands")

    martha.hook("mission-change").click()
    martha.sees("rest-said", "ready|same", within_s=60)
    for number, (button, down) in enumerate((("rest-draw-area", 0.55), ("rest-draw-obstacle", 0.35))):
        martha.hook(button).click()
        touch(martha, circle(martha, 0.5, down, 22))
        expect(martha.hook(f"rest-area-{number}")).to_be_visible()
        martha.sees("rest-said", "ready", within_s=60)
    assert martha.covers_of_stop() == []
    martha.hook("rest-area-remove-1").click()
    expect(martha.hook("rest-area-1")).to_have_count(0)
    martha.sees("rest-said", "ready", within_s=60)
    martha.hook("rest-send").click()
    expect(martha.hook("rest-sheet")).to_have_count(0, timeout=20_000)
    martha.press("mission-abort")
    martha.slide("mission-abort")

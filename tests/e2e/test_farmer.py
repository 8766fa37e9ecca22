"""A farmer at the edge of her field, with a tablet: the whole job, by touch."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for
from tests.e2e.test_control import hold_forward

pytestmark = pytest.mark.browser
Come = Callable[..., Person]
ROBOT, MISSION = "weeder-01", "trial-strip"


def send_mission(someone: Person, mission: str = MISSION) -> None:
    """Choose a stored mission on its screen and send it; sending moves nothing."""
    someone.open("/missions")
    someone.hook(f"mission-row-{mission}").click()
    send, fresh = someone.hook("plan-send"), someone.hook("mission-fresh")
    expect(send.or_(fresh)).to_be_visible()
    if send.count():
        send.click()
    else:  # it was interrupted before: the whole mission again is held, not tapped
        fresh.click()
        someone.hold("mission-fresh")
        someone.sees(f"mission-row-{mission}", "sent|accepted", within_s=20)
        someone.let_go()
    someone.sees(f"mission-row-{mission}", "sent|accepted", within_s=20)


@pytest.mark.parametrize(
    ("size", "has_webgl"),
    [
        ("landscape", False),
        pytest.param("landscape", True, marks=pytest.mark.long),  # drawn in software it takes twice as long
        pytest.param("portrait", False, marks=pytest.mark.long),
    ],
)
def test_a_farmer_weeds_pauses_drives_by_hand_and_stops(
    person: Come, calm: Installation, size: str, *, has_webgl: bool
) -> None:
    calm.simulator("POST", "/_world", {"speed": 10})
    martha = person("operator", size=size, by_form=True, has_webgl=has_webgl)
    send_mission(martha)
    assert calm.world(ROBOT)["standstill"]

    martha.operate(ROBOT)
    martha.slide_into("mission-start", "auto")
    expect(martha.hook("value-row")).to_have_attribute("data-value", re.compile("^[1-9]"), timeout=60_000)
    assert calm.world(ROBOT)["speed_mps"] != 0
    assert not calm.world(ROBOT)["standstill"]

    martha.press("mission-pause")
    martha.sees("robot-mode", "paused")
    wait_for(lambda: calm.world(ROBOT)["standstill"], within_s=5, what="paused robot stands")
    martha.slide_into("mission-resume", "auto")

    martha.press("mission-pause")
    martha.sees("robot-mode", "paused")
    martha.order("drive-open", into="manual")
    hold_forward(martha, calm)
    assert not calm.world(ROBOT)["laser_on"]
    martha.let_go()
    wait_for(lambda: calm.world(ROBOT)["standstill"], within_s=2, what="it stops when the finger lifts")

    martha.press_stop()
    martha.sees("stop", "standstill")
    assert calm.world(ROBOT)["latched"]


@pytest.mark.long
def test_sending_a_mission_does_not_move_the_robot(person: Come, calm: Installation) -> None:
    martha = person("operator")
    before = calm.world(ROBOT)
    send_mission(martha)
    martha.operate(ROBOT)
    martha.sees("mission-start", "idle")
    assert calm.world(ROBOT)["distance_m"] == before["distance_m"]


def test_reset_and_resume_are_two_slides_and_the_first_moves_nothing(person: Come, calm: Installation) -> None:
    martha = person("operator")
    martha.operate(ROBOT)
    martha.press_stop()
    martha.sees("stop", "standstill")
    martha.page.get_by_role("button", name="Test").click()
    before = calm.world(ROBOT)
    martha.slide("stop-reset")
    martha.sees("stop", "ready", within_s=10)
    assert not calm.world(ROBOT)["latched"]
    assert calm.world(ROBOT)["distance_m"] == before["distance_m"]
    assert calm.world(ROBOT)["standstill"]

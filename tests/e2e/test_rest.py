"""A mission that is changed, interrupted and taken up again: every row is treated once."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.e2e.caller import Caller
from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for
from tests.e2e.test_farmer import send_mission

pytestmark = pytest.mark.browser
Come = Callable[..., Person]
ROBOT, MISSION = "weeder-01", "trial-strip"
LEFT_OUT = (3, 4)
NEAR_M = 1.5  # a crash forgets what the robot did since it last wrote: one second, at twice the speed


def pieces(caller: Caller) -> list[dict[str, int]]:
    found: list[dict[str, int]] = caller.get(f"/missions/{MISSION}/rest")["pieces"]
    return found


def treated_rows(caller: Caller, since: int) -> dict[int, float]:
    """Return the length treated in each row since the newest mission was loaded, from the robot's events."""
    events = caller.get(f"/events?robot={ROBOT}&kind=treatment&limit=200")["events"]
    found: dict[int, float] = {}
    for event in events[: len(events) - since]:
        if event["data"].get("mission_id") == MISSION and event["data"]["row"]:  # 0 is the headland
            found[event["data"]["row"]] = found.get(event["data"]["row"], 0.0) + event["data"]["length_m"]
    return found


def is_at_row(caller: Caller, row: int) -> bool:
    """Say whether the robot works in a row; one that does not work at all will never come there."""
    robot = next(one for one in caller.get("/robots")["robots"] if one["id"] == ROBOT)
    assert robot["mode"] == "auto", f"{robot['mode']}: {robot['why']}"
    return bool(robot["mission"]["row"] == row)


@pytest.mark.long
@pytest.mark.timeout(400)
def test_pause_replan_continue_reboot_resume_later_and_every_row_is_treated_once(
    person: Come, calm: Installation
) -> None:
    caller = Caller(calm.url, "supervisor")
    before = len(caller.get(f"/events?robot={ROBOT}&kind=treatment&limit=200")["events"])
    calm.simulator("POST", "/_world", {"speed": 10})
    martha = person("operator")
    send_mission(martha)
    martha.operate(ROBOT)
    martha.slide("mission-start")
    expect(martha.hook("value-row")).to_have_attribute("data-value", re.compile("^[1-9]"), timeout=90_000)
    martha.press("mission-pause")
    martha.sees("robot-mode", "paused")
    wait_for(lambda: calm.world(ROBOT)["standstill"], within_s=5, what="paused robot stands")

    martha.hook("mission-change").click()
    expect(martha.hook("rest-said")).to_have_text("Nothing changed yet.", timeout=60_000)
    expect(martha.hook("rest-send")).to_be_disabled()
    for piece in pieces(caller):
        if piece["row"] in LEFT_OUT:
            martha.hook(f"rest-piece-{piece['number']}").click()
    martha.sees("rest-said", "ready", within_s=60)
    expect(martha.hook("rest-sheet")).to_contain_text("Left out: Row 3, Row 4")
    martha.hook("rest-send").click()
    expect(martha.hook("rest-sheet")).to_have_count(0, timeout=20_000)

    martha.slide("mission-resume")
    martha.sees("robot-mode", "auto")
    wait_for(lambda: is_at_row(caller, 2), within_s=90, what="it works in the second row")
    calm.simulator("POST", "/_world", {"speed": 2})
    martha.page.wait_for_timeout(1500)  # what it did in haste is written by then
    calm.fault(ROBOT, "crash", reboot_after_s=3)
    martha.sees("robot-mode", "paused", within_s=30)
    go_on(martha)
    martha.sees("robot-mode", "auto", within_s=20)
    martha.press("mission-abort")
    martha.slide("mission-abort")
    resume_later(martha)
    calm.simulator("POST", "/_world", {"speed": 10})
    wait_for(lambda: caller.get(f"/missions/{MISSION}")["status"] == "done", within_s=150, what="the mission is done")
    rows = treated_rows(caller, before)
    assert set(rows) == {1, 2}
    assert rows[1] == pytest.approx(rows[2], abs=NEAR_M)
    log = [entry["why"] for entry in caller.get(f"/missions/{MISSION}")["log"]]
    assert any("Row 3, Row 4 left out" in why for why in log)
    assert any("Taken up again" in why for why in log)
    caller.close()


def go_on(martha: Person) -> None:
    """Continue where it stands, or resume later if it rolled too far while its computer was dead."""
    resume, later = martha.hook("mission-resume"), martha.hook("mission-later")
    expect(resume.or_(later)).to_be_visible(timeout=20_000)
    if resume.count():
        martha.slide("mission-resume")
    else:
        resume_later(martha)


def resume_later(martha: Person) -> None:
    """Plan the way back, send it, and slide."""
    martha.hook("mission-later").click()
    martha.sees("rest-said", "ready", within_s=60)
    martha.hook("rest-send").click()
    expect(martha.hook("rest-sheet")).to_have_count(0, timeout=20_000)
    martha.slide("mission-resume")
    martha.sees("robot-mode", "auto", within_s=20)

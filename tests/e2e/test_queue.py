"""A queue that works by itself: filled and armed by hand, ended by STOP."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from playwright.sync_api import expect

from tests.e2e.caller import Caller
from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for

pytestmark = pytest.mark.browser
Come = Callable[..., Person]
ROBOT, MISSION = "weeder-01", "trial-strip"


@pytest.fixture
def boss(calm: Installation) -> Iterator[Caller]:
    """An admin who lets the robot run unattended for this story, and leaves an empty queue behind."""
    caller = Caller(calm.url, "admin")
    change(caller, f"/robots/{ROBOT}", {"is_unattended_allowed": True})
    yield caller
    caller.post("/queue/disarm", {}).raise_for_status()
    calm.calm()
    for entry in caller.get("/queue")["entries"]:
        caller.delete(f"/queue/entries/{entry['id']}")
    change(caller, f"/robots/{ROBOT}", {"is_unattended_allowed": False})
    caller.close()


def change(caller: Caller, path: str, body: dict[str, Any]) -> None:
    """Send a PATCH."""
    caller.patch(path, body).raise_for_status()


def unattended_copy(caller: Caller, name: str) -> str:
    """Return a fresh mission that may run without a person."""
    wait_for(lambda: any(m["id"] == MISSION for m in caller.get("/missions")["missions"]), within_s=60, what="demo")
    made = caller.post(f"/missions/{MISSION}/copy", {"name": name}).json()["id"]
    change(caller, f"/missions/{made}", {"is_supervised": False})
    return str(made)


def put_into_queue(someone: Person, mission: str) -> None:
    """Add a mission on its screen, to be started by the queue."""
    someone.hook(f"mission-row-{mission}").click()
    someone.hook("mission-add-to-queue").click()
    someone.hook("queue-unattended").check()
    someone.page.get_by_role("button", name="Add to queue").last.click()
    expect(someone.hook("queue-add")).to_have_count(0)


@pytest.mark.long
def test_a_queue_runs_two_missions_and_stop_ends_it(person: Come, calm: Installation, boss: Caller) -> None:
    first, second = unattended_copy(boss, "Night 1"), unattended_copy(boss, "Night 2")
    calm.simulator("POST", "/_world", {"speed": 20})
    martha = person("operator")
    martha.open("/missions")
    put_into_queue(martha, first)
    put_into_queue(martha, second)

    # a story before this one may have left a mission on the robot; what a person sent the queue does not replace
    boss.post(f"/robots/{ROBOT}/mission", {"mission_id": first}).raise_for_status()
    martha.hook("missions-tab-queue").click()
    expect(martha.hook(f"queue-reason-{ROBOT}")).to_contain_text("Not armed", timeout=20_000)
    assert calm.world(ROBOT)["standstill"]
    martha.hook("queue-arm-open").click()
    martha.slide("queue-arm")
    martha.sees(f"queue-armed-{ROBOT}", "armed")

    def status(mission: str) -> str:
        return str(boss.get(f"/missions/{mission}")["status"])

    wait_for(lambda: status(first) == "running", within_s=20, what="the first mission starts by itself")
    owner = boss.get(f"/robots/{ROBOT}")["lease"]["owner"]["name"]
    assert re.match(r"Queue, armed by .+ until (\w+ \d+ \w+ )?\d\d:\d\d", owner)  # with the day, late in the evening
    wait_for(lambda: status(first) == "done", within_s=90, what="the first mission ends")
    wait_for(lambda: status(second) == "running", within_s=20, what="the second follows by itself")

    martha.press_stop()
    martha.sees("stop", "standstill")
    expect(martha.hook("queue-frozen")).to_be_visible()
    martha.sees(f"queue-armed-{ROBOT}", "off")
    assert calm.world(ROBOT)["latched"]
    assert martha.covers_of_stop() == []

    martha.page.get_by_role("button", name="Area is clear").click()
    martha.slide("queue-release")
    expect(martha.hook("queue-frozen")).to_have_count(0)
    martha.sees(f"queue-armed-{ROBOT}", "off")
    assert calm.world(ROBOT)["standstill"]


@pytest.mark.long
def test_a_mission_nobody_started_is_taken_off_the_robot_in_the_queue_and_on_operate(
    person: Come, calm: Installation, boss: Caller
) -> None:
    waiting, sent = unattended_copy(boss, "After the strip"), unattended_copy(boss, "Sent by hand")
    boss.post(f"/robots/{ROBOT}/mission", {"mission_id": sent}).raise_for_status()
    boss.post("/queue/entries", {"mission_id": waiting}).raise_for_status()
    martha = person("operator")
    martha.open("/missions")
    martha.hook("missions-tab-queue").click()
    martha.hook(f"queue-take-off-{ROBOT}").click(timeout=20_000)
    expect(martha.hook(f"queue-take-off-{ROBOT}")).to_have_count(0, timeout=20_000)
    wait_for(lambda: held(boss) == waiting, within_s=30, what="the queue sends its own")

    # sent once more it is wanted again, and the card on Operate offers the same
    boss.post(f"/robots/{ROBOT}/mission", {"mission_id": sent}).raise_for_status()
    martha.operate(ROBOT)
    hold = martha.hook("mission-hold")
    expect(hold).to_contain_text("After the strip waits in the queue", timeout=30_000)
    hold.get_by_role("button").click()
    expect(hold).to_be_hidden(timeout=20_000)
    wait_for(lambda: held(boss) == waiting, within_s=30, what="the queue sends its own again")
    assert calm.world(ROBOT)["standstill"]


def held(caller: Caller) -> str:
    """Return the mission that lies on the robot."""
    return str((caller.get(f"/robots/{ROBOT}").get("mission") or {}).get("id"))

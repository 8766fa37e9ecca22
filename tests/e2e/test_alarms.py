"""Alarms over the running demo: a lost link is shown, heard, answered and goes; a shelved one comes back."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import expect

from tests.e2e.caller import Caller
from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for

pytestmark = pytest.mark.browser
Come = Callable[..., Person]
ROBOTS = ("weeder-01", "weeder-02", "weeder-03")  # one a story: an alarm that comes three times a minute is held


@pytest.fixture
def boss(calm: Installation) -> Iterator[Caller]:
    """A supervisor who leaves no alarm of this robot behind."""
    caller = Caller(calm.url, "supervisor")
    yield caller
    for robot in ROBOTS:
        calm.mend(robot)
    for alarm in lost(caller):
        for verb in ("unshelve", "acknowledge"):
            caller.post(f"/alarms/{alarm}/{verb}", {})
    wait_for(lambda: not lost(caller), within_s=15, what="the link alarms are normal again")
    caller.close()


def lost(caller: Caller) -> list[str]:
    """Return the ids of alarms about lost links."""
    return [str(alarm["id"]) for alarm in caller.get("/alarms")["alarms"] if alarm["code"] == "link-lost"]


def test_a_lost_link_is_an_alarm_until_somebody_saw_it_and_the_robot_is_back(
    person: Come, calm: Installation, boss: Caller
) -> None:
    robot, alarm = "weeder-01", "link-lost.weeder-01"
    martha = person("operator")
    martha.open("/alarms")
    martha.hook("alarm-silence").tap()  # the first touch unlocks the sound; silence ends with what comes
    calm.fault(robot, "silence", http=True)
    expect(martha.hook(f"alarm-row-{alarm}")).to_be_visible(timeout=15_000)
    martha.sees(f"alarm-row-{alarm}", "unacknowledged")
    expect(martha.hook("nav-alarms")).to_have_attribute("data-state", "unacknowledged")
    expect(martha.hook("alarm-sound")).to_have_attribute("data-value", re.compile("[12]"))
    expect(martha.hook("alarm-sound")).to_have_attribute("data-state", "silenced")
    martha.hook("alarm-sound-button").tap()
    martha.sees("alarm-sound", "on")

    martha.hook(f"alarm-ack-{alarm}").tap()
    martha.sees(f"alarm-row-{alarm}", "acknowledged")
    expect(martha.hook(f"alarm-row-{alarm}")).to_contain_text("Active, acknowledged")
    assert not calm.world(robot)["latched"]
    calm.mend(robot)
    expect(martha.hook(f"alarm-row-{alarm}")).to_have_count(0, timeout=20_000)
    assert martha.covers_of_stop() == []


@pytest.mark.long
def test_a_shelved_alarm_leaves_the_list_and_comes_back(person: Come, calm: Installation, boss: Caller) -> None:
    robot, alarm = "weeder-02", "link-lost.weeder-02"
    anna = person("supervisor", size="desk")
    calm.fault(robot, "silence", http=True)
    anna.open("/alarms")
    anna.hook(f"alarm-row-{alarm}").click()
    expect(anna.hook("alarm-steps")).to_contain_text("Look before you walk up to it")
    anna.hook(f"alarm-shelve-{alarm}").click()
    anna.page.get_by_role("radio", name="15 min").click()
    anna.hook("alarm-reason").fill("Radio is being mended")
    anna.hook("alarm-shelve-sheet").get_by_role("button", name="Shelve", exact=True).click()
    anna.page.mouse.move(5, 5)
    expect(anna.hook(f"alarm-row-{alarm}")).to_have_count(0)
    anna.hook("alarms-tab-shelved").click()
    expect(anna.hook(f"alarm-row-{alarm}")).to_contain_text("Shelved by")
    boss.post(f"/alarms/{alarm}/unshelve", {}).raise_for_status()
    anna.hook("alarms-tab-active").click()
    expect(anna.hook(f"alarm-row-{alarm}")).to_contain_text("not acknowledged")


@pytest.mark.long
@pytest.mark.timeout(240)
def test_a_shelf_ends_by_itself_and_the_alarm_is_new_again(person: Come, calm: Installation, boss: Caller) -> None:
    robot, alarm = "weeder-01", "link-lost.weeder-01"
    anna = person("supervisor")
    calm.fault(robot, "silence", http=True)
    anna.open("/alarms")
    anna.hook(f"alarm-row-{alarm}").click()
    anna.page.mouse.move(5, 5)  # a row stays while the pointer is on it
    boss.post(f"/alarms/{alarm}/acknowledge", {}).raise_for_status()
    boss.post(f"/alarms/{alarm}/shelve", {"minutes": 1, "reason": "Radio is being mended"}).raise_for_status()
    expect(anna.hook(f"alarm-row-{alarm}")).to_have_count(0)
    anna.hook("alarms-tab-shelved").click()
    expect(anna.hook(f"alarm-row-{alarm}")).to_contain_text("Shelved by")
    expect(anna.hook(f"alarm-row-{alarm}")).to_have_count(0, timeout=75_000)
    anna.hook("alarms-tab-active").click()
    anna.sees(f"alarm-row-{alarm}", "unacknowledged")  # though it was acknowledged before
    calm.mend(robot)
    anna.hook(f"alarm-ack-{alarm}").click()
    anna.page.mouse.move(5, 5)
    expect(anna.hook(f"alarm-row-{alarm}")).to_have_count(0, timeout=20_000)


@pytest.mark.long
def test_an_operator_answers_on_operate_without_leaving_the_robot(
    person: Come, calm: Installation, boss: Caller
) -> None:
    robot, alarm = "weeder-03", "link-lost.weeder-03"
    martha = person("operator", size="portrait")
    martha.operate(robot)
    calm.fault(robot, "silence", http=True)
    expect(martha.hook("alarm-strip")).to_have_attribute("data-value", alarm, timeout=15_000)
    martha.hook(f"strip-ack-{alarm}").tap()
    expect(martha.hook("alarm-strip")).to_be_hidden()
    assert martha.covers_of_stop() == []

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
ROBOT = "weeder-02"
ALARM = f"link-lost.{ROBOT}"


@pytest.fixture
def boss(calm: Installation) -> Iterator[Caller]:
    """A supervisor who leaves no alarm of this robot behind."""
    caller = Caller(calm.url, "supervisor")
    yield caller
    calm.mend(ROBOT)
    for alarm in caller.get(f"/alarms?robot={ROBOT}")["alarms"]:
        for verb in ("unshelve", "acknowledge"):
            caller.post(f"/alarms/{alarm['id']}/{verb}", {})
    wait_for(lambda: ALARM not in ids(caller), within_s=15, what="the link alarm is normal again")
    caller.close()


def ids(caller: Caller) -> set[str]:
    """Return the ids of all alarms that are not normal."""
    return {str(alarm["id"]) for alarm in caller.get("/alarms")["alarms"]}


def test_a_lost_link_is_an_alarm_until_somebody_saw_it_and_the_robot_is_back(
    person: Come, calm: Installation, boss: Caller
) -> None:
    martha = person("operator")
    martha.open("/alarms")
    martha.hook("alarm-silence").tap()  # the first touch unlocks the sound; silence ends with what comes
    calm.fault(ROBOT, "silence", http=True)
    expect(martha.hook(f"alarm-row-{ALARM}")).to_be_visible(timeout=15_000)
    martha.sees(f"alarm-row-{ALARM}", "unacknowledged")
    expect(martha.hook("nav-alarms")).to_have_attribute("data-state", "unacknowledged")
    expect(martha.hook("alarm-sound")).to_have_attribute("data-value", re.compile("[12]"))
    expect(martha.hook("alarm-sound")).to_have_attribute("data-state", "silenced")
    martha.hook("alarm-sound-button").tap()
    martha.sees("alarm-sound", "on")

    martha.hook(f"alarm-ack-{ALARM}").tap()
    martha.sees(f"alarm-row-{ALARM}", "acknowledged")
    expect(martha.hook(f"alarm-row-{ALARM}")).to_contain_text("Active, acknowledged")
    assert not calm.world(ROBOT)["latched"]
    calm.mend(ROBOT)
    expect(martha.hook(f"alarm-row-{ALARM}")).to_have_count(0, timeout=20_000)
    assert martha.covers_of_stop() == []


@pytest.mark.long
def test_a_shelved_alarm_leaves_the_list_and_comes_back(person: Come, calm: Installation, boss: Caller) -> None:
    anna = person("supervisor", size="desk")
    calm.fault(ROBOT, "silence", http=True)
    anna.open("/alarms")
    anna.hook(f"alarm-row-{ALARM}").click()
    expect(anna.hook("alarm-steps")).to_contain_text("Look before you walk up to it")
    anna.hook(f"alarm-shelve-{ALARM}").click()
    anna.page.get_by_role("radio", name="15 min").click()
    anna.hook("alarm-reason").fill("Radio is being mended")
    anna.hook("alarm-shelve-sheet").get_by_role("button", name="Shelve", exact=True).click()
    anna.page.mouse.move(5, 5)
    expect(anna.hook(f"alarm-row-{ALARM}")).to_have_count(0)
    anna.hook("alarms-tab-shelved").click()
    expect(anna.hook(f"alarm-row-{ALARM}")).to_contain_text("Shelved by")
    boss.post(f"/alarms/{ALARM}/unshelve", {}).raise_for_status()
    anna.hook("alarms-tab-active").click()
    expect(anna.hook(f"alarm-row-{ALARM}")).to_contain_text("not acknowledged")


@pytest.mark.long
def test_an_operator_answers_on_operate_without_leaving_the_robot(
    person: Come, calm: Installation, boss: Caller
) -> None:
    martha = person("operator", size="portrait")
    martha.operate(ROBOT)
    calm.fault(ROBOT, "silence", http=True)
    expect(martha.hook("alarm-strip")).to_have_attribute("data-value", ALARM, timeout=15_000)
    martha.hook(f"strip-ack-{ALARM}").tap()
    expect(martha.hook("alarm-strip")).to_be_hidden()
    assert martha.covers_of_stop() == []

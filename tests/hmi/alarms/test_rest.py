"""Alarms by REST: everybody reads, who may acknowledges and shelves, and each act is written down."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest

from hmi.api.alarms import AlarmRoutes, alarm_routes
from hmi.commands.alarm_desk import AlarmDesk
from hmi.domain.alarm.alarm import AlarmKey
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.conditions import Change, Turn
from hmi.domain.alarm.finding import Finding
from hmi.domain.role import Role
from hmi.store.alarms import AlarmStore
from tests.hmi.api.conftest import migrated as migrated
from tests.hmi.api.console import Console

LINK = "link-lost.weeder-01"
STOP = "stop-not-confirmed.weeder-01"


class AlarmConsole(Console):
    """A console with alarms and nothing that raises them by itself."""

    def _services(self) -> Any:
        services = super()._services()
        clock = self.field.clock
        self.alarms = AlarmStore(clock, catalogue())
        self.desk = AlarmDesk(
            self.alarms, self.audit, self.authorize, clock, lambda i: i.startswith("weeder"), lambda: clock.utc()
        )
        routes = alarm_routes(AlarmRoutes(self.alarms, self.desk, clock, lambda source: source.title()))
        object.__setattr__(services, "further", [routes])
        return services

    def turn(self, turn: Turn, code: str, text: str = "so") -> None:
        """Let a condition come or go."""
        self.alarms.apply([Change(turn, AlarmKey(code, "weeder-01"), Finding(code, text))])


@pytest.fixture
async def console(tmp_path: Path, migrated: Path) -> AsyncIterator[AlarmConsole]:
    """Return a console with one robot and a lost link."""
    console = AlarmConsole(tmp_path, migrated)
    await console.database.run(console.register)
    console.turn(Turn.COMES, "link-lost", "Nothing heard.")
    yield console
    await console.close()


async def test_a_viewer_reads_alarms_with_what_they_say_and_may_not_acknowledge(console: AlarmConsole) -> None:
    viewer = await console.browser(Role.VIEWER)
    listed = (await viewer.get("/alarms?state=active")).json()
    assert [one["id"] for one in listed["alarms"]] == [LINK]
    assert (
        listed["alarms"][0] | {"text": "Nothing heard.", "state": "unacknowledged", "priority": 2}
        == listed["alarms"][0]
    )
    refused = await viewer.post(f"/alarms/{LINK}/acknowledge")
    assert (refused.status_code, refused.json()["code"]) == (403, "not_allowed")
    assert console.alarms.get(LINK).alarm.seen_by == ""


async def test_only_what_is_critical_is_listed_with_what_to_do(console: AlarmConsole) -> None:
    console.turn(Turn.COMES, "moves-after-stop", "It is stopped and moves at 0.8 m/s.")
    viewer = await console.browser(Role.VIEWER)
    steps = {one["code"]: one["steps"] for one in (await viewer.get("/alarms?state=active")).json()["alarms"]}
    assert steps["link-lost"] == []
    assert steps["moves-after-stop"][0] == "Use the red button on the machine"


async def test_acknowledging_notes_who_and_resets_nothing(console: AlarmConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    answer = (await martha.post(f"/alarms/{LINK}/acknowledge")).json()
    assert (answer["state"], answer["seen_by"]) == ("acknowledged", "Martha Keller")
    assert (await martha.post(f"/alarms/{LINK}/acknowledge")).status_code == 200
    written = await console.written("alarm")
    assert [(w.actor, w.outcome, w.ref, w.robot_id) for w in written] == [
        ("Martha Keller", "acknowledged", LINK, "weeder-01")
    ]
    refused = await martha.post(f"/alarms/{LINK}/clear")
    assert (refused.status_code, refused.json()["code"]) == (409, "still_active")


async def test_what_came_and_went_unseen_is_cleared_with_one_tap(console: AlarmConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    console.turn(Turn.GOES, "link-lost")
    assert (await martha.post(f"/alarms/{LINK}/clear")).status_code == 200
    assert (await martha.get("/alarms")).json()["alarms"] == []


async def test_several_are_acknowledged_at_once_and_each_answers_for_itself(console: AlarmConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    answer = (await martha.post("/alarms/acknowledge", json={"ids": [LINK, "link-lost.weeder-99"]})).json()
    assert [(one["id"], one["code"]) for one in answer["results"]] == [
        (LINK, "ok"),
        ("link-lost.weeder-99", "not_found"),
    ]


async def test_shelving_needs_the_supervisor_a_reason_and_never_takes_priority_1(console: AlarmConsole) -> None:
    martha, anna = await console.browser(Role.OPERATOR), await console.browser(Role.SUPERVISOR)
    body = {"minutes": 15, "reason": "mast is being moved"}
    refused = await martha.post(f"/alarms/{LINK}/shelve", json=body)
    assert refused.json()["text"] == "Shelving needs the supervisor role."
    assert (await anna.post(f"/alarms/{LINK}/shelve", json={**body, "reason": " "})).json()["code"] == "no_reason"
    assert (await anna.post(f"/alarms/{LINK}/shelve", json={**body, "until_shift_end": True})).status_code == 422
    console.turn(Turn.COMES, "stop-not-confirmed")
    assert (await anna.post(f"/alarms/{STOP}/shelve", json=body)).json()["code"] == "critical"
    shelved = (await anna.post(f"/alarms/{LINK}/shelve", json=body)).json()
    assert (shelved["state"], shelved["shelf"]["by"]) == ("shelved", "Anna Ostermeier")
    assert [one["id"] for one in (await anna.get("/alarms?state=shelved")).json()["alarms"]] == [LINK]
    assert [one["id"] for one in (await anna.get("/alarms?state=active")).json()["alarms"]] == [STOP]
    assert (await anna.post(f"/alarms/{LINK}/unshelve")).json()["state"] == "unacknowledged"


async def test_an_alarm_that_is_not_there_is_said_so(console: AlarmConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    assert (await martha.post("/alarms/link-lost.weeder-99/acknowledge")).status_code == 404
    assert (await martha.post("/alarms/LINK%20LOST/acknowledge")).status_code == 422

"""What an admin sets of an alarm type: within bounds, with a reason, for priority 1 by two people, and at once."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import pytest

from hmi.api.alarm_limits import alarm_limits_routes
from hmi.commands.alarm_limits_desk import AlarmLimitsDesk, LimitsParts
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.conditions import Conditions, Turn
from hmi.domain.alarm.finding import Finding
from hmi.domain.alarm.priority import Priority
from hmi.domain.alarm.tuning import BadTuning, Tuning, shipped, tuned
from hmi.domain.role import Role
from hmi.store.alarm_settings import AlarmSettings
from hmi.store.errors import DatabaseUnavailable
from tests.hmi.api.conftest import migrated as migrated
from tests.hmi.api.console import PASSWORD, Console
from tests.hmi.commands.field import FARM

OFF_TRACK, FENCE = "/alarms/limits/off-track", "/alarms/limits/outside-fence"
WIDER = {"on_s": 2.0, "off_s": 3.0, "at": 0.3, "deadband": 0.1}
SLOWER = {"on_s": 2.0, "off_s": 2.0}


class LimitsConsole(Console):
    """A console whose supervision goes by types that an admin may set."""

    def _services(self) -> Any:
        services = super()._services()
        self.types = dict(catalogue())
        self.conditions = Conditions(self.types.__getitem__)
        self.limits = self.desk()
        object.__setattr__(services, "further", [alarm_limits_routes(self.limits)])
        return services

    def desk(self) -> AlarmLimitsDesk:
        """Return a desk as after a start; it goes by the catalogue until it is loaded."""
        self.types.clear()
        self.types.update(catalogue())
        kept = AlarmSettings(self.database, FARM)
        return AlarmLimitsDesk(
            LimitsParts(self.types, self.conditions.retune, kept, self.database, self.audit, self.authorize,
                        self.field.clock)
        )  # fmt: skip


@pytest.fixture
async def console(tmp_path: Path, migrated: Path) -> AsyncIterator[LimitsConsole]:
    """Return the console."""
    console = LimitsConsole(tmp_path, migrated)
    await console.database.run(console.register)
    yield console
    await console.close()


async def second_admin(console: LimitsConsole) -> httpx.AsyncClient:
    """Return the browser of another admin."""
    user = await console.accounts.create_user("Jonas Weber", Role.ADMIN, PASSWORD, by="test", user_id="jonas")
    return console.client(*await console.sessions.open(user, "tablet-2", "Tablet 2"))


def _of(answer: dict[str, Any], code: str) -> dict[str, Any]:
    return next(one for one in answer["types"] if one["code"] == code)


async def test_a_change_holds_at_once_is_written_down_and_is_there_after_a_restart(console: LimitsConsole) -> None:
    admin = await console.browser(Role.ADMIN)
    answer = await admin.put(OFF_TRACK, json={"values": WIDER, "reason": "Wide tyres on wet soil"})
    assert answer.status_code == 200
    row = _of(answer.json(), "off-track")
    assert (row["now"], row["changed"]["reason"]) == (WIDER, "Wide tyres on wet soil")
    (line,) = await console.written("alarm_limits")
    assert (line.outcome, line.ref, line.text, line.data["at"]) == (
        "changed",
        "off-track",
        "Wide tyres on wet soil",
        0.3,
    )
    await console.desk().load()
    assert shipped(console.types["off-track"]) == Tuning(**WIDER)
    back = await admin.put(OFF_TRACK, json={"values": None, "reason": "Dry again"})
    assert _of(back.json(), "off-track")["changed"] is None
    assert console.types["off-track"] == catalogue()["off-track"]


async def test_of_priority_1_nothing_changes_before_another_admin_agrees(console: LimitsConsole) -> None:
    first = await console.browser(Role.ADMIN)
    wish = {"values": SLOWER, "reason": "GNSS jumps at the wood"}
    assert _of((await first.put(FENCE, json=wish)).json(), "outside-fence")["asked"]["is_mine"]
    assert console.types["outside-fence"].on_s == 0.5
    alone = await first.post(f"{FENCE}/agree")
    assert (alone.status_code, alone.json()["code"]) == (409, "same_person")
    second = await second_admin(console)
    seen = _of((await second.get("/alarms/limits")).json(), "outside-fence")["asked"]
    assert (seen["is_mine"], seen["reason"]) == (False, "GNSS jumps at the wood")
    agreed = await second.post(f"{FENCE}/agree")
    assert agreed.status_code == 200
    assert console.types["outside-fence"].on_s == 2.0
    assert [one.outcome for one in await console.written("alarm_limits")] == ["asked", "changed"]
    assert (await second.post(f"{FENCE}/agree")).status_code == 409


async def test_what_was_asked_for_can_be_declined_and_outlives_a_restart(console: LimitsConsole) -> None:
    first = await console.browser(Role.ADMIN)
    await first.put(FENCE, json={"values": SLOWER, "reason": "GNSS jumps"})
    again = console.desk()
    await again.load()
    second = await second_admin(console)
    assert _of((await second.get("/alarms/limits")).json(), "outside-fence")["asked"]
    assert _of((await second.post(f"{FENCE}/drop")).json(), "outside-fence")["asked"] is None
    assert console.types["outside-fence"].on_s == 0.5


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"values": WIDER, "reason": " "}, "reason"),
        ({"values": {**WIDER, "at": 0.01}, "reason": "x"}, "at"),
        ({"values": {**WIDER, "at": 99}, "reason": "x"}, "at"),
        ({"values": {**WIDER, "deadband": 0.3}, "reason": "x"}, "deadband"),
        ({"values": {**WIDER, "on_s": 601}, "reason": "x"}, "on_s"),
    ],
)
async def test_what_cannot_be_used_is_refused_with_the_field(
    console: LimitsConsole, body: dict[str, Any], field: str
) -> None:
    admin = await console.browser(Role.ADMIN)
    answer = await admin.put(OFF_TRACK, json=body)
    assert (answer.status_code, answer.json()["field"]) == (422, field)
    assert console.types["off-track"] == catalogue()["off-track"]


async def test_only_admins_may(console: LimitsConsole) -> None:
    supervisor = await console.browser(Role.SUPERVISOR)
    assert (await supervisor.get("/alarms/limits")).status_code == 403
    assert (await supervisor.put(OFF_TRACK, json={"values": WIDER, "reason": "x"})).status_code == 403
    assert (await supervisor.post(f"{FENCE}/agree")).status_code == 403


def test_a_condition_under_way_goes_by_the_new_delay() -> None:
    types = dict(catalogue())
    conditions = Conditions(types.__getitem__)
    found = (Finding("off-track", "0.4 m"),)
    assert conditions.see("weeder-01", found, 0.0) == []
    types["off-track"] = replace(types["off-track"], on_s=30.0)
    conditions.retune()
    assert conditions.see("weeder-01", found, 10.0) == []
    assert [one.turn for one in conditions.see("weeder-01", found, 30.0)] == [Turn.COMES]


def test_a_critical_alarm_cannot_be_made_to_wait() -> None:
    kind = catalogue()["outside-fence"]
    with pytest.raises(BadTuning, match="between 0 and 5 s"):
        tuned(kind, Tuning(6.0, 2.0))
    with pytest.raises(BadTuning, match="no limit"):
        tuned(kind, Tuning(1.0, 2.0, at=1.0))


@pytest.mark.parametrize(("level", "waited_s"), [(Priority.CRITICAL, 5), (Priority.HIGH, 600)])
def test_what_a_robot_calls_critical_waits_no_longer_than_priority_1(level: Priority, waited_s: int) -> None:
    types = {"robot-fault": tuned(catalogue()["robot-fault"], Tuning(600.0, 2.0))}
    conditions = Conditions(types.__getitem__)
    fault = Finding("robot-fault", "Brake failed.", "brake", level)
    turns = [[change.turn for change in conditions.see("w", (fault,), float(second))] for second in range(601)]
    assert turns.index([Turn.COMES]) == waited_s


def test_a_fault_that_becomes_critical_while_it_waits_counts_at_once() -> None:
    types = {"robot-fault": tuned(catalogue()["robot-fault"], Tuning(600.0, 2.0))}
    conditions = Conditions(types.__getitem__)
    for now_s in (0.0, 60.0):
        assert conditions.see("w", (Finding("robot-fault", "Oil.", "oil", Priority.MEDIUM),), now_s) == []
    (change,) = conditions.see("w", (Finding("robot-fault", "Oil.", "oil", Priority.CRITICAL),), 61.0)
    assert (change.turn, change.finding.priority) == (Turn.COMES, Priority.CRITICAL)


async def test_a_change_that_could_not_be_kept_does_not_come_true_later(
    console: LimitsConsole, monkeypatch: pytest.MonkeyPatch
) -> None:
    admin, other = await console.browser(Role.ADMIN), await second_admin(console)
    await admin.put(FENCE, json={"values": SLOWER, "reason": "GPS jumps at the wood"})
    keep = AlarmSettings.put

    def full(*_args: Any) -> None:
        raise DatabaseUnavailable("the disk is full")

    monkeypatch.setattr(AlarmSettings, "put", full)
    for answer in (
        await admin.put(OFF_TRACK, json={"values": WIDER, "reason": "Wide tyres on wet soil"}),
        await other.post(f"{FENCE}/agree"),
        await other.post(f"{FENCE}/drop"),
    ):
        assert answer.status_code == 503
    monkeypatch.setattr(AlarmSettings, "put", keep)
    row = _of((await admin.get("/alarms/limits")).json(), "outside-fence")
    assert row["changed"] is None
    assert row["asked"] is not None

    await other.put("/alarms/limits/stalled", json={"values": None, "reason": "As it was"})
    await console.desk().load()
    for code in ("off-track", "outside-fence"):
        assert console.types[code] == catalogue()[code]
    assert (await other.post(f"{FENCE}/agree")).status_code == 200, "it still waits for a second person"

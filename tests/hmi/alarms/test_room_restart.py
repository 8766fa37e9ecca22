"""What was active when the console went down: it ends when those who report it look again and find nothing."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from hmi.app.alarms import GRACE_S, AlarmRoom
from hmi.app.console_health import AUDIT_FIRST_S
from hmi.app.records import Records
from hmi.clock import FakeClock
from hmi.domain.alarm import life
from hmi.domain.alarm.alarm import CONSOLE, Alarm, AlarmKey
from hmi.domain.alarm.conditions import Change, Turn
from hmi.domain.alarm.finding import Finding
from hmi.domain.freshness import LOST_S
from hmi.security.authorization import Authorizer
from hmi.settings import Settings
from hmi.store.alarms import Person
from hmi.store.fleet import FleetStore
from tests.hmi.ingest.wire import Entry

MARTHA = Person("Martha Keller", "Tablet 3")
STATION = "station-3"
PLANNER, BATTERY, SILENT, LINK, AUDIT = (
    "planner-away.console",
    "station-battery.station-3",
    "all-silent.console",
    "link-lost.w",
    "audit-broken.console",
)
OURS = {PLANNER, BATTERY, SILENT, LINK, AUDIT}


class Farm:
    """A console's alarms that can be started again on what is on disk."""

    def __init__(self, folder: Path) -> None:
        self.clock = FakeClock()
        self.settings = Settings.model_validate({"data": folder, "farm_id": "farm", "secret": "s" * 40, "port": 0})

    @asynccontextmanager
    async def room(self) -> AsyncIterator[AlarmRoom]:
        """Return the alarms of a console as it starts."""
        records = Records(self.settings, self.clock, lambda _robot_id: False)
        records.open()
        fleet = self.fleet = FleetStore(self.clock.mono_s)
        fleet.set_registry([Entry("w")])
        room = AlarmRoom(
            self.settings, self.clock, records, fleet, Authorizer(records.robots.of_any_farm),
            lambda _mission_id: None, lambda _event: None, lambda: True,
        )  # fmt: skip
        await room.prepare()
        room.start()
        try:
            yield room
        finally:
            await room.stop()
            records.close()

    async def leave(self, *conditions: tuple[str, str]) -> None:
        """Let conditions come and be seen, and end the console."""
        async with self.room() as room:
            for code, source in conditions:
                room.store.apply([Change(Turn.COMES, AlarmKey(code, source), Finding(code))])
                room.store.acknowledge(AlarmKey(code, source).id, MARTHA)

    async def pass_time(self, room: AlarmRoom, seconds: float, step_s: float = 1.0) -> None:
        """Let rounds go by."""
        for _ in range(round(seconds / step_s)):
            self.clock.advance(step_s)
            await room.round()


def _states(room: AlarmRoom) -> dict[str, str]:
    """Return the alarms of these tests; what this machine has of its own does not matter."""
    return {one.id: one.alarm.state.value for one in room.store.all() if one.id in OURS}


@pytest.fixture
def farm(tmp_path: Path) -> Farm:
    """Return a farm without anything."""
    return Farm(tmp_path)


async def test_what_a_station_or_the_console_mended_over_a_restart_goes_away(farm: Farm) -> None:
    await farm.leave(("planner-away", CONSOLE), ("station-battery", STATION))
    async with farm.room() as room:
        await farm.pass_time(room, GRACE_S - 2)
        assert _states(room) == {PLANNER: "acknowledged", BATTERY: "acknowledged"}
        await farm.pass_time(room, 1860, step_s=20)  # nobody knows this station any more
        assert _states(room) == {}


async def test_what_is_still_so_after_a_restart_stays_as_it_was_answered(farm: Farm) -> None:
    await farm.leave(("planner-away", CONSOLE), ("station-battery", STATION))
    async with farm.room() as room:
        room.further["planner"] = lambda: (Finding("planner-away", "It does not answer."),)
        room.stations = lambda: {STATION: ("Soil 3", (Finding("station-battery", "9 % left."),))}
        await farm.pass_time(room, 1860, step_s=20)
        assert _states(room) == {PLANNER: "acknowledged", BATTERY: "acknowledged"}


async def test_what_stations_say_is_waited_for_until_they_are_read(farm: Farm) -> None:
    await farm.leave(("station-battery", STATION))
    async with farm.room() as room:
        room.stations = lambda: None
        await farm.pass_time(room, 3600, step_s=40)
        assert _states(room) == {BATTERY: "acknowledged"}


async def test_a_broken_audit_stays_broken_over_a_restart_until_its_chain_was_walked(farm: Farm) -> None:
    await farm.leave(("audit-broken", CONSOLE), ("planner-away", CONSOLE))
    async with farm.room() as room:
        await farm.pass_time(room, AUDIT_FIRST_S - 2)
        assert _states(room) == {AUDIT: "acknowledged"}
        await farm.pass_time(room, 2)
        for _ in range(500):  # it is walked in a thread
            if _states(room)[AUDIT] != "acknowledged":
                break
            await asyncio.sleep(0.01)
            await farm.pass_time(room, 1)
        assert _states(room) == {AUDIT: "latched"}  # this farm's chain is whole: it was restored


async def test_what_was_silent_by_design_stays_silent_until_its_cause_ends(farm: Farm) -> None:
    await farm.leave(("link-lost", "w"), ("all-silent", CONSOLE))
    async with farm.room() as room:
        assert _states(room) == {LINK: "suppressed", SILENT: "acknowledged"}
        await farm.pass_time(room, GRACE_S + 30)
        assert _states(room) == {LINK: "unacknowledged"}


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
async def test_the_order_of_restoring_does_not_matter_for_what_is_silent_by_design(
    farm: Farm, order: tuple[int, int]
) -> None:
    async with farm.room() as room:
        alarms = [Alarm(AlarmKey("link-lost", "w")), Alarm(AlarmKey("all-silent", CONSOLE))]
        for number in order:
            room.store.restore(life.condition_comes(alarms[number], farm.clock.utc() - timedelta(minutes=5)))
        assert _states(room) == {LINK: "suppressed", SILENT: "unacknowledged"}
        assert room.store.get(LINK).unanswered_at is None


async def test_a_robot_that_comes_back_after_it_was_taken_out_has_nothing_put_aside(farm: Farm) -> None:
    async with farm.room() as room:
        until = farm.clock.utc() + timedelta(hours=4)
        room.watch.report("w", "stop", (Finding("battery-low"), Finding("robot-fault", "Nozzle.", "nozzle")))
        await farm.pass_time(room, 60, step_s=20)
        room.store.shelve("battery-low.w", MARTHA, "known", until)
        room.store.take_out("robot-fault.w.nozzle", MARTHA, "at the maker")
        steps: list[tuple[str, str]] = []
        room.store.listeners.append(lambda step: steps.append((step.what.value, step.text)))
        room.robot_removed("w")
        assert {one.alarm.state.value for one in room.store.of("w")} == {"returned"}
        why = "It was taken out of the registry."
        assert steps[2:] == [("unshelved", why), ("in_service", why)]


async def test_a_fault_over_the_cloud_or_the_stations_keeps_no_alarm_of_a_robot_from_coming(farm: Farm) -> None:
    def fails() -> Any:
        raise RuntimeError("a fault of ours")

    async with farm.room() as room:
        room.further["cloud"] = room.stations = fails
        room.further["planner"] = lambda: (Finding("planner-away", "It does not answer."),)
        farm.fleet.put_heartbeat("w", boot="b", challenge="c", heard_s=farm.clock.mono_s())
        await farm.pass_time(room, 1)
        farm.clock.advance(LOST_S)
        farm.fleet.refresh_links()
        await farm.pass_time(room, 1860, step_s=20)
        assert {PLANNER, LINK} <= _states(room).keys()

"""What goes wrong with a robot becomes an alarm, at the right time and in the robot's own words."""

from __future__ import annotations

from datetime import timedelta

import pytest

from backend_clients.edge import messages_up as up
from hmi.domain.alarm.live_alarm import What
from hmi.domain.alarm.priority import Priority
from tests.hmi.alarms.rig import MARTHA, AlarmRig

ROBOT = "weeder-01"
RTK = up.Fault(code="rtk-float", level="medium", text="RTK is not fixed.", hint="Wait.")
NOZZLE = up.Fault(code="nozzle_7", level="high", text="Nozzle 7 is blocked.", hint="Clean nozzle 7.")


async def test_a_robot_that_falls_silent_raises_one_alarm_that_stays_until_somebody_saw_it() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(3, ROBOT)
        assert rig.states() == {}
        rig.run(5)
        assert rig.states() == {"link-lost.weeder-01": "unacknowledged"}
        heard_s = rig.one("link-lost.weeder-01").raised_s
        assert 4.0 < rig.clock.mono_s() - (heard_s - 3.5) <= 5.5
        rig.run(5, ROBOT)
        assert rig.states() == {"link-lost.weeder-01": "returned"}
        rig.alarms.acknowledge("link-lost.weeder-01", MARTHA)
        assert rig.states() == {}
        assert [step.what for step in rig.steps] == [What.RAISED, What.RETURNED, What.ACKNOWLEDGED]


async def test_a_robot_never_heard_since_the_start_has_lost_nothing() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(30)
        assert rig.states() == {}


async def test_a_robot_nobody_registered_raises_nothing() -> None:
    async with AlarmRig() as rig:
        rig.run(2, ROBOT)
        rig.say(rig.wire().state(faults=[RTK]))
        rig.run(10)
        assert rig.states() == {}


async def test_values_that_stand_still_while_the_robot_is_heard_are_an_alarm_of_their_own() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(2, ROBOT)
        for _ in range(12):
            rig.clock.advance(0.5)
            rig.say(rig.wire().heartbeat())
            rig.round()
        assert rig.states() == {"values-old.weeder-01": "unacknowledged"}


async def test_a_fault_that_the_catalogue_knows_becomes_its_type_with_the_robots_words() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(1, ROBOT)
        rig.say(rig.wire().state(faults=[RTK]))
        assert rig.states() == {}
        rig.run(3, ROBOT)
        live = rig.one("rtk-float.weeder-01")
        assert (live.alarm.text, live.priority) == ("RTK is not fixed.", Priority.MEDIUM)


async def test_a_fault_nobody_has_words_for_keeps_the_robots_words_hint_and_level() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(1, ROBOT)
        rig.say(rig.wire().state(faults=[NOZZLE]))
        live = rig.one("robot-fault.weeder-01.nozzle-7")
        assert live.priority is Priority.HIGH
        assert (live.alarm.text, live.alarm.advice) == ("Nozzle 7 is blocked.", "Clean nozzle 7.")
        rig.say(rig.wire().state())
        assert rig.states() == {"robot-fault.weeder-01.nozzle-7": "returned"}


async def test_a_fault_stays_while_the_robot_is_silent_for_nobody_knows_better() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(1, ROBOT)
        rig.say(rig.wire().state(faults=[NOZZLE]))
        rig.run(60)
        assert set(rig.states().values()) == {"unacknowledged"}
        assert "robot-fault.weeder-01.nozzle-7" in rig.states()


async def test_a_robot_that_was_shut_down_in_order_is_not_lost_unless_it_had_work() -> None:
    async with AlarmRig(ROBOT, "weeder-02") as rig:
        rig.run(3, ROBOT, "weeder-02")
        order = up.OrderState(mission_id="m-1", revision=1, sha256="a" * 64, status="paused", row=1, rows=9, segment=0,
                              segment_s_m=0.0, area_m2=9.0, area_done_m2=1.0, distance_m=1.0)  # fmt: skip
        rig.say(rig.wire("weeder-02").state(mode="paused", path=[], order=order))
        for robot_id in (ROBOT, "weeder-02"):
            rig.say(rig.wire(robot_id).presence(online=False, reason="shutdown"))
        rig.run(10)
        assert rig.states() == {"link-lost.weeder-02": "unacknowledged"}


async def test_a_whole_fleet_that_goes_to_bed_in_order_raises_nothing_and_so_does_its_morning() -> None:
    fleet = tuple(f"weeder-{number:02d}" for number in range(10))
    async with AlarmRig(*fleet) as rig:
        rig.run(3, *fleet)
        for robot_id in fleet:
            rig.say(rig.wire(robot_id).presence(online=False, reason="shutdown"))
        rig.run(700)
        for robot_id in fleet:
            rig.wire(robot_id).boot, rig.wire(robot_id).booted_s = "boot-bbbb", rig.clock.mono_s()
        rig.run(10, *fleet)
        assert rig.states() == {}


def _hydraulic(level: str) -> up.Fault:
    return up.Fault(code="hydraulic", level=level, text="Hydraulic pressure falls.", hint="")


HYDRAULIC = "robot-fault.weeder-01.hydraulic"


@pytest.mark.parametrize("aside", ["shelved", "out_of_service", "acknowledged"])
async def test_a_fault_that_becomes_critical_is_put_aside_no_more_and_asks_at_once(aside: str) -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(1, ROBOT)
        rig.say(rig.wire().state(faults=[_hydraulic("medium")]))
        if aside == "shelved":
            rig.alarms.shelve(HYDRAULIC, MARTHA, "known", rig.clock.utc() + timedelta(hours=4))
        elif aside == "out_of_service":
            rig.alarms.take_out(HYDRAULIC, MARTHA, "at the maker")
        else:
            rig.alarms.acknowledge(HYDRAULIC, MARTHA)
        rig.run(1, ROBOT)
        rig.steps.clear()
        rig.say(rig.wire().state(faults=[_hydraulic("critical")]))
        assert rig.states() == {HYDRAULIC: "unacknowledged"}
        assert rig.alarms.counts()[Priority.CRITICAL] == (1, 1)
        (step,) = rig.steps
        assert (step.what, step.live.priority, step.rose_from) == (What.RAISED, Priority.CRITICAL, Priority.MEDIUM)
        assert step.text.startswith(f"Was priority 3, {aside.replace('_', ' ')}.")


async def test_what_an_admin_took_out_stays_out_when_it_becomes_critical() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(1, ROBOT)
        rig.say(rig.wire().state(faults=[_hydraulic("medium")]))
        rig.alarms.take_out(HYDRAULIC, MARTHA, "at the maker", holds_critical=True)
        rig.say(rig.wire().state(faults=[_hydraulic("critical")]))
        assert rig.states() == {HYDRAULIC: "out_of_service"}


async def test_what_lies_on_the_shelf_and_comes_back_critical_is_shown() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(1, ROBOT)
        rig.say(rig.wire().state(faults=[_hydraulic("medium")]))
        rig.alarms.shelve(HYDRAULIC, MARTHA, "known", rig.clock.utc() + timedelta(hours=4))
        rig.say(rig.wire().state())
        rig.run(5, ROBOT)
        rig.say(rig.wire().state(faults=[_hydraulic("critical")]))
        assert rig.states() == {HYDRAULIC: "unacknowledged"}
        assert rig.one(HYDRAULIC).priority is Priority.CRITICAL


async def test_a_fault_whose_level_flutters_is_not_raised_at_each_turn() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(1, ROBOT)
        for _ in range(20):
            for level in ("medium", "critical"):
                rig.say(rig.wire().state(faults=[_hydraulic(level)]))
                rig.run(1, ROBOT)
        assert [step.live.priority for step in rig.steps] == [Priority.MEDIUM, Priority.CRITICAL]
        rig.say(rig.wire().state(faults=[_hydraulic("medium")]))
        rig.run(50, ROBOT)
        assert rig.one(HYDRAULIC).priority is Priority.CRITICAL
        rig.run(20, ROBOT)
        assert rig.one(HYDRAULIC).priority is Priority.MEDIUM

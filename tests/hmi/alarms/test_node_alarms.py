"""The error monitor of all nodes: what is wrong with a robot's software becomes an alarm, once and steadily."""

from __future__ import annotations

from typing import Any

from backend_clients.edge import machine as wire
from backend_clients.edge import messages_up as up
from tests.hmi.alarms.rig import AlarmRig

ROBOT = "weeder-01"
NODES = [
    wire.NodeInfo(name="gnss", label="RTK receiver", rate_hz=20.0),
    wire.NodeInfo(name="guidance", label="Guidance", rate_hz=20.0, starts_after=["gnss"]),
    wire.NodeInfo(name="camera", label="Rear camera", rate_hz=15.0),
]


def begin(rig: AlarmRig) -> None:
    """Let the robot say what nodes it has."""
    rig.clock.advance(100.0)
    rig.beat(ROBOT)
    rig.say(rig.wire().factsheet(nodes=NODES))


def tell(rig: AlarmRig, *silent: str, **changes: dict[str, Any]) -> None:
    """Let every node but the silent ones be reported, with changes by name."""
    for info in NODES:
        if info.name not in silent:
            said = {"name": info.name, "state": "started", "rate_hz": info.rate_hz, "since_ms": 1000}
            rig.say(rig.wire().node(**{**said, **changes.get(info.name, {})}))


def live(rig: AlarmRig, seconds: int, *silent: str, **changes: dict[str, Any]) -> None:
    """Let time pass with reports each five seconds."""
    for _ in range(seconds // 5):
        tell(rig, *silent, **changes)
        rig.run(5, ROBOT)


async def test_a_robot_whose_software_runs_raises_nothing() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        live(rig, 60)
        assert rig.states() == {}


async def test_a_node_of_which_three_reports_are_missing_is_an_alarm_and_gone_when_it_is_heard_again() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        tell(rig)
        live(rig, 15, "camera")
        assert rig.states() == {}
        live(rig, 5, "camera")
        assert rig.states() == {"node-silent.weeder-01.camera": "unacknowledged"}
        assert rig.one("node-silent.weeder-01.camera").alarm.text == "Rear camera is not heard any more."
        live(rig, 10)
        assert rig.states() == {"node-silent.weeder-01.camera": "returned"}


async def test_when_no_node_is_reported_any_more_one_alarm_says_so() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        tell(rig)
        rig.run(25, ROBOT)
        [alarm] = rig.alarms.all()
        assert (alarm.alarm.key.code, alarm.alarm.text) == ("node-silent", "None of its 3 nodes is reported any more.")


async def test_a_robot_that_is_not_heard_has_a_lost_link_and_no_silent_nodes() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        tell(rig)
        rig.run(40)
        assert set(rig.states()) == {"link-lost.weeder-01"}
        rig.run(10, ROBOT)
        assert not any("node" in one for one in rig.states())
        rig.run(10, ROBOT)
        assert any("node-silent" in one for one in rig.states())


async def test_a_longer_period_that_a_node_declares_is_respected() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        tell(rig, **{info.name: {"period_ms": 30_000} for info in NODES})
        rig.run(80, ROBOT)
        assert rig.states() == {}
        rig.run(15, ROBOT)
        assert set(rig.states()) == {"node-silent.weeder-01"}


async def test_a_slow_node_is_an_alarm_with_a_dead_band() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        live(rig, 30, guidance={"rate_hz": 10.1})
        assert rig.states() == {}
        live(rig, 15, guidance={"rate_hz": 9.0})
        [alarm] = rig.alarms.all()
        assert (alarm.id, alarm.alarm.text) == ("node-slow.weeder-01.guidance", "Guidance runs at 9 Hz, usual 20 Hz.")
        live(rig, 20, guidance={"rate_hz": 10.5})
        assert rig.states() == {"node-slow.weeder-01.guidance": "unacknowledged"}
        live(rig, 20, guidance={"rate_hz": 11.5})
        assert rig.states() == {"node-slow.weeder-01.guidance": "returned"}


async def test_a_wrong_clock_of_a_node_is_an_alarm_with_a_dead_band() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        live(rig, 30, camera={"clock_offset_ms": -49.0})
        assert rig.states() == {}
        live(rig, 15, camera={"clock_offset_ms": -180.0})
        [alarm] = rig.alarms.all()
        assert alarm.id == "node-clock.weeder-01.camera"
        assert alarm.alarm.text == "Rear camera: 180 ms behind the robot's clock."
        live(rig, 20, camera={"clock_offset_ms": -45.0})
        assert rig.states() == {"node-clock.weeder-01.camera": "unacknowledged"}
        live(rig, 20, camera={"clock_offset_ms": 5.0})
        assert rig.states() == {"node-clock.weeder-01.camera": "returned"}


async def test_a_node_started_before_one_that_it_needs_is_an_alarm_after_a_while() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        live(rig, 5, gnss={"since_ms": 60_000})
        assert rig.states() == {}
        live(rig, 10, gnss={"since_ms": 60_000})
        [alarm] = rig.alarms.all()
        assert alarm.id == "node-start-order.weeder-01.guidance"
        assert alarm.alarm.text.startswith("Guidance: It was started before RTK receiver")
        live(rig, 10, gnss={"since_ms": 60_000}, guidance={"since_ms": 80_000})
        assert rig.states() == {"node-start-order.weeder-01.guidance": "returned"}


async def test_what_follows_from_a_failed_node_is_shown_as_its_consequence() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        live(rig, 5)
        live(rig, 20, gnss={"state": "failure", "text": "no antenna"})
        assert set(rig.states()) == {"node-failed.weeder-01.gnss", "node-start-order.weeder-01.guidance"}
        assert rig.one("node-failed.weeder-01.gnss").alarm.text == "RTK receiver failed. no antenna"
        assert rig.one("node-start-order.weeder-01.guidance").first == "node-failed.weeder-01.gnss"


async def test_a_node_that_restarts_three_times_in_ten_minutes_is_an_alarm() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        for times in range(3):
            live(rig, 60, camera={"restarts": times})
            assert rig.states() == {}
        live(rig, 10, camera={"restarts": 3})
        assert rig.states() == {"node-restarting.weeder-01.camera": "unacknowledged"}


async def test_a_robot_that_also_says_in_short_that_a_node_failed_raises_no_second_alarm() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        live(rig, 5)
        fault = up.Fault(code="node-failure", level="high", text="A part of its software failed.")
        rig.say(rig.wire().state(faults=[fault]))
        tell(rig, camera={"state": "failure"})
        live(rig, 10, camera={"state": "failure"})
        assert set(rig.states()) == {"node-failed.weeder-01.camera"}


async def test_a_declared_node_that_never_reports_is_an_alarm_while_others_are_heard() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        live(rig, 15, "camera")
        assert rig.states() == {}
        live(rig, 10, "camera")
        [alarm] = rig.alarms.all()
        assert (alarm.id, alarm.alarm.text) == ("node-silent.weeder-01.camera", "Rear camera was never heard.")
        live(rig, 10)
        assert rig.states() == {"node-silent.weeder-01.camera": "returned"}


async def test_a_robot_none_of_whose_nodes_was_ever_heard_has_one_alarm_that_ends_with_the_first() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        none = [node.name for node in NODES]
        live(rig, 14, *none)
        assert rig.states() == {}
        live(rig, 10, *none)
        [alarm] = rig.alarms.all()
        told = ("node-silent.weeder-01", f"None of its {len(none)} nodes was ever heard.")
        assert (alarm.id, alarm.alarm.text) == told
        live(rig, 10)
        assert rig.states() == {"node-silent.weeder-01": "returned"}


async def test_a_node_that_was_never_heard_is_missed_by_the_slowest_period_of_the_others() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        live(rig, 80, "camera", guidance={"period_ms": 30_000})
        assert rig.states() == {}
        live(rig, 20, "camera", guidance={"period_ms": 30_000})
        assert set(rig.states()) == {"node-silent.weeder-01.camera"}


async def test_a_node_that_declares_a_long_period_is_missed_by_its_own_and_not_by_that_of_the_others() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.clock.advance(100.0)
        rig.beat(ROBOT)
        slow = wire.NodeInfo(name="camera", label="Rear camera", period_ms=60_000)
        rig.say(rig.wire().factsheet(nodes=[*NODES[:2], slow]))
        live(rig, 175, "camera")
        assert rig.states() == {}
        live(rig, 15, "camera")
        assert rig.one("node-silent.weeder-01.camera").alarm.text == "Rear camera was never heard."


async def test_a_node_that_says_nothing_of_its_period_has_the_usual_one_though_the_others_report_more_often() -> None:
    async with AlarmRig(ROBOT) as rig:
        begin(rig)
        often = {name: {"period_ms": 1000} for name in ("gnss", "guidance")}
        for _ in range(14):
            tell(rig, "camera", **often)
            rig.run(1, ROBOT)
        assert rig.states() == {}
        for _ in range(10):
            tell(rig, "camera", **often)
            rig.run(1, ROBOT)
        assert set(rig.states()) == {"node-silent.weeder-01.camera"}

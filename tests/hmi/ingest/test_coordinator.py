"""What robots say reaches the store with its true age; what is wrong is counted and harms nothing."""

from __future__ import annotations

import msgspec
import pytest

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Up
from hmi.domain.command import Acknowledgement
from hmi.domain.event import RobotEvent
from hmi.domain.robot import Mode, SafetyState
from hmi.ingest.robot_clock import JUMPS_BELIEVED
from hmi.store.fleet import CAMERA_LIMIT, UNREGISTERED_LIMIT
from tests.hmi.ingest.wire import KINDS, FakeWireRobot, Rig

ID = "weeder-01"


async def test_everything_a_robot_says_reaches_the_store() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        for message in (
            weeder.presence(),
            weeder.factsheet(),
            weeder.heartbeat(),
            weeder.telemetry(),
            weeder.state(),
            weeder.safety(),
            weeder.node(),
        ):
            rig.say(message)
        robot = rig.store.robot(ID)
        assert robot is not None
        assert robot.is_registered
        assert robot.factsheet is not None
        assert robot.factsheet.tool_label == "Laser"
        assert (robot.factsheet.battery_wh, robot.factsheet.charge_w) == (8000.0, 2000.0)
        assert robot.telemetry is not None
        assert robot.telemetry.pose.speed_mps == 0.42
        assert robot.state is not None
        assert robot.state.mode is Mode.IDLE
        assert robot.safety is not None
        assert robot.safety.standstill
        assert robot.nodes["planner"].state == "started"
        assert robot.link.is_online
        assert robot.link.challenge == "challenge-2"
        assert robot.link.boot == weeder.boot


async def test_a_held_frame_keeps_its_true_age() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        rig.say(weeder.telemetry())
        rig.clock.advance(1)
        held = weeder.telemetry(speed_mps=0.3)
        rig.clock.advance(12)
        rig.say(held)
        robot = rig.store.robot(ID)
        assert robot is not None
        assert robot.telemetry is not None
        stamp = robot.telemetry.pose.stamp
        assert rig.clock.mono_s() - stamp.source_s == pytest.approx(12)
        assert stamp.received_s == rig.clock.mono_s()


async def test_a_held_heartbeat_is_no_proof_of_life() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        rig.say(weeder.heartbeat())
        held = weeder.heartbeat()
        rig.clock.advance(5)
        rig.say(held)
        robot = rig.store.robot(ID)
        assert robot is not None
        assert not robot.link.is_online


async def test_a_silent_robot_goes_offline_without_any_message() -> None:
    async with Rig(ID) as rig:
        rig.say(rig.robot().heartbeat())
        revision = rig.store.revision
        rig.clock.advance(3.6)
        rig.edge.look_after()
        robot = rig.store.robot(ID)
        assert robot is not None
        assert not robot.link.is_online
        assert ID in rig.store.since(revision).robots


async def test_a_last_will_takes_a_robot_offline_and_a_heartbeat_brings_it_back() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        rig.say(weeder.heartbeat())
        rig.say(weeder.presence(online=False, reason="lost"))
        assert not rig.store.robot(ID).link.is_online  # type: ignore[union-attr]
        rig.clock.advance(0.2)
        rig.say(weeder.heartbeat())
        assert rig.store.robot(ID).link.is_online  # type: ignore[union-attr]


async def test_a_retained_copy_of_live_data_is_refused() -> None:
    async with Rig(ID) as rig:
        rig.say(rig.robot().safety(), is_retained=True)
        assert rig.store.robot(ID).safety is None  # type: ignore[union-attr]
        assert rig.edge.tally.total["retained"] == 1


async def test_a_retained_factsheet_is_taken() -> None:
    async with Rig(ID) as rig:
        rig.say(rig.robot().factsheet(), is_retained=True)
        assert rig.store.robot(ID).factsheet is not None  # type: ignore[union-attr]


async def test_an_older_frame_never_replaces_a_newer_one() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        older = weeder.state(mode="auto")
        rig.clock.advance(0.5)
        rig.say(weeder.state(mode="paused"))
        rig.say(older)
        assert rig.store.robot(ID).state.mode is Mode.PAUSED  # type: ignore[union-attr]
        assert rig.edge.tally.total["out_of_order"] == 1


async def test_what_an_earlier_boot_said_is_refused_while_the_new_one_is_heard() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        rig.say(weeder.state(mode="auto"))
        held = weeder.state(mode="auto")
        rig.clock.advance(2)
        rebooted = FakeWireRobot(ID, rig.clock, boot="boot-bbbb", booted_s=rig.clock.mono_s() - 1)
        rig.say(rebooted.state(mode="stopped"))
        rig.say(held)
        assert rig.store.robot(ID).state.mode is Mode.STOPPED  # type: ignore[union-attr]
        assert rig.edge.tally.total["old_boot"] == 1


async def test_a_forged_boot_does_not_silence_the_real_robot_for_ever() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        rig.say(weeder.heartbeat())
        rig.say(FakeWireRobot(ID, rig.clock, boot="boot-evil").heartbeat())
        rig.clock.advance(4)
        rig.say(weeder.heartbeat())
        assert rig.store.robot(ID).link.boot == weeder.boot  # type: ignore[union-attr]


async def test_one_frame_from_the_future_does_not_blind_the_console() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        rig.say(weeder.telemetry())
        rig.say(msgspec.structs.replace(weeder.telemetry(), mono_ms=2**50))
        rig.clock.advance(0.1)
        rig.say(weeder.telemetry(speed_mps=0.1))
        robot = rig.store.robot(ID)
        assert robot.telemetry.pose.speed_mps == 0.1  # type: ignore[union-attr]
        assert rig.clock.mono_s() - robot.telemetry.pose.stamp.source_s < 0.2  # type: ignore[union-attr]
        assert rig.edge.tally.total["clock_jump"] == 1


async def test_a_clock_that_really_moved_is_believed_in_the_end() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        rig.say(weeder.telemetry())
        weeder.booted_s -= 3600
        for _ in range(JUMPS_BELIEVED):
            rig.clock.advance(0.1)
            rig.say(weeder.telemetry(speed_mps=0.2))
        assert rig.store.robot(ID).telemetry.pose.speed_mps == 0.2  # type: ignore[union-attr]


async def test_listeners_hear_acknowledgements_events_and_safety() -> None:
    async with Rig(ID) as rig:
        acks: list[Acknowledgement] = []
        events: list[RobotEvent] = []
        safeties: list[tuple[str, SafetyState]] = []
        rig.edge.listeners.on_ack.append(acks.append)
        rig.edge.listeners.on_event.append(events.append)
        rig.edge.listeners.on_safety.append(lambda robot_id, value: safeties.append((robot_id, value)))
        weeder = rig.robot()
        rig.say(weeder.ack(outcome="rejected", code="stop_latched", text="A STOP is active."))
        rig.say(weeder.event())
        rig.say(weeder.safety(latched=True))
        assert [(a.ref, a.is_accepted, a.code) for a in acks] == [("command-1", False, "stop_latched")]
        assert [(e.kind, e.name, e.at_utc) for e in events] == [("state_entered", "Treat row", rig.clock.utc())]
        assert safeties[0][0] == ID
        assert safeties[0][1].latched


async def test_an_event_told_twice_happened_once() -> None:
    async with Rig(ID) as rig:
        events: list[RobotEvent] = []
        rig.edge.listeners.on_event.append(events.append)
        event = rig.robot().event()
        rig.say(event)
        rig.say(event)
        assert len(events) == 1


async def test_a_robot_that_is_not_registered_is_shown_but_not_listened_to() -> None:
    async with Rig() as rig:
        acks: list[Acknowledgement] = []
        rig.edge.listeners.on_ack.append(acks.append)
        stranger = rig.robot("stranger-9")
        rig.say(stranger.heartbeat())
        rig.say(stranger.ack())
        robot = rig.store.robot("stranger-9")
        assert robot is not None
        assert not robot.is_registered
        assert acks == []
        assert rig.store.address("stranger-9") is None


async def test_strangers_are_bounded_in_number() -> None:
    async with Rig(ID) as rig:
        for number in range(UNREGISTERED_LIMIT + 50):
            rig.say(rig.robot(f"stranger-{number}").heartbeat())
        rig.say(rig.robot().heartbeat())
        assert len(rig.store.robots()) == UNREGISTERED_LIMIT + 1
        assert rig.edge.tally.total["too_many_robots"] == 50
        assert rig.store.robot(ID).link.is_online  # type: ignore[union-attr]


async def test_the_round_trip_is_measured_from_the_echo_and_without_the_time_the_robot_held_it() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        rig.edge.ping_due()  # the first call only spreads the start
        rig.clock.advance(1)
        rig.edge.ping_due()
        ping = rig.published()[0]
        assert isinstance(ping, down.Ping)
        assert ping.nonce.startswith(down.CONSOLE_NONCE)  # keeps an unattended mission going
        rig.clock.advance(0.300)
        rig.say(weeder.heartbeat(echo_nonce=ping.nonce, echo_held_ms=214.0))
        link = rig.store.robot(ID).link  # type: ignore[union-attr]
        assert link.rtt_s == pytest.approx(0.086)
        assert link.rtt_max_s == pytest.approx(0.086)
        rig.clock.advance(0.2)
        rig.say(weeder.heartbeat(echo_nonce=ping.nonce, echo_held_ms=0.0))
        assert rig.store.robot(ID).link.rtt_s == pytest.approx(0.086)  # type: ignore[union-attr]


async def test_each_registered_robot_is_pinged_once_a_second() -> None:
    async with Rig(*[f"robot-{i}" for i in range(40)]) as rig:
        for _ in range(200):
            rig.edge.ping_due()
            rig.clock.advance(0.05)
        assert 40 * 8 <= len(rig.link.sent) <= 40 * 10


async def test_the_inside_of_a_machine_is_kept_with_its_age() -> None:
    async with Rig(ID) as rig:
        robot = FakeWireRobot(ID, rig.clock)
        rig.say(robot.body())
        rig.say(robot.worksite())
        rig.say(robot.node(since_ms=0, clock_offset_ms=40.0, host="crane"))
        kept = rig.store.robot(ID)
        assert kept is not None
        assert kept.body is not None
        assert kept.body.joints == {"slew": -0.52, "boom": 0.5}
        assert kept.body.seen[0].distance_m == 7.4
        assert kept.body.stamp.source_s == rig.clock.mono_s()
        assert kept.worksite is not None
        assert [one.status for one in kept.worksite.targets] == ["done", "failed_ground"]
        assert (kept.nodes["planner"].clock_offset_s, kept.nodes["planner"].host) == (0.04, "crane")


def test_every_kind_of_message_has_a_topic_in_these_tests() -> None:
    assert set(KINDS.values()) == set(Up)
    assert all(issubclass(kind, up.Header) for kind in KINDS)


async def test_what_cameras_found_is_kept_for_each_camera_with_the_time_of_its_picture() -> None:
    async with Rig(ID) as rig:
        robot = rig.robot()
        rig.say(robot.heartbeat())
        rig.say(robot.detections())
        rig.say(robot.detections(camera="rear", boxes=[]))
        kept = rig.store.robot(ID)
        assert kept is not None
        assert set(kept.sights) == {"front", "rear"}
        [box] = kept.sights["front"].boxes
        assert (box.kind, box.x, box.hit) == ("weed", 0.4, True)
        assert kept.sights["front"].stamp.source_s <= rig.clock.mono_s()
        for number in range(40):
            rig.say(robot.detections(camera=f"forged-{number}"))
        kept = rig.store.robot(ID)
        assert kept is not None
        assert len(kept.sights) == CAMERA_LIMIT


async def test_a_heartbeat_that_came_before_a_robot_left_and_waited_here_does_not_bring_it_back() -> None:
    async with Rig(ID) as rig:
        weeder = rig.robot()
        rig.say(weeder.heartbeat())
        rig.clock.advance(0.2)
        rig.post(weeder.heartbeat())
        rig.clock.advance(0.001)
        rig.post(weeder.presence(online=False, reason="shutdown"))
        rig.edge.drain()
        link = rig.store.robot(ID).link  # type: ignore[union-attr]
        assert (link.is_online, link.said_goodbye) == (False, True)
        rig.clock.advance(0.2)
        rig.say(weeder.heartbeat())
        link = rig.store.robot(ID).link  # type: ignore[union-attr]
        assert (link.is_online, link.said_goodbye) == (True, False)

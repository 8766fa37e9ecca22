"""Joints by hand: the rules of driving hold, joint by joint."""

from __future__ import annotations

import math

import pytest

from hmi.commands.drive import DriveFrame, DriveVerdict, JogFrame
from hmi.commands.lease_service import LeaseOp
from hmi.commands.service import CommandRequest
from hmi.domain.command import Acknowledgement, Action, CommandOrder, DriveOrder, JogOrder
from hmi.domain.machine import FunctionInfo, JointInfo
from hmi.domain.robot import Mode, Node, Stamp
from hmi.security.session_info import SessionInfo
from tests.hmi.commands.field import ANNA, JONAS, MARTHA, VERA, Field, factsheet

SLEW = JointInfo("slew", "Slew", "rad", -1.9, 1.9, 0.5, -1.8, 1.8)
EXTENSION = JointInfo("extension", "Extension", "m", 0.0, 4.0, 0.6, None, 3.8)


async def moving() -> Field:
    """Return a field whose machine Martha moves by hand."""
    field = Field()
    field.weeder.factsheet = factsheet(joints=(SLEW, EXTENSION))
    asked = CommandRequest("weeder-01", Action.DRIVE_OPEN, "open-0001", field.tick())
    assert (await field.desk.commands.submit(MARTHA, asked)).is_accepted
    return field


def push(
    field: Field, *, actor: SessionInfo = MARTHA, lane: str = "lane-1", tick: str = "", picture_s: float | None = None,
    **rates: float,
) -> DriveVerdict:  # fmt: skip
    """Send one frame on a fresh picture."""
    asked = JogFrame("weeder-01", rates or {"slew": 0.1}, tick or field.tick(), picture_s)
    return field.desk.drive.jog(actor, lane, asked)


def setpoints(field: Field) -> list[dict[str, float]]:
    """Return what the joints were told."""
    return [dict(o.rates) for o in field.weeder.orders if isinstance(o, JogOrder)]


async def test_each_frame_is_forwarded_once_and_nothing_without_one() -> None:
    field = await moving()
    for _ in range(5):
        field.wait(0.1)
        assert push(field).is_forwarded
    field.wait(1.0)
    await field.desk.tend()
    assert setpoints(field) == [{"slew": 0.1}] * 5
    numbers = [o.lease_seq for o in field.weeder.orders if isinstance(o, JogOrder)]
    assert numbers == sorted(set(numbers))
    assert field.weeder.rates == {"slew": 0.1}


@pytest.mark.parametrize(("picture_s", "expected"), [(None, 0.25), (0.3, 0.25), (0.6, 0.1), (1.1, None)])
async def test_joints_go_by_the_picture_that_is_open_as_wheels_do(
    picture_s: float | None, expected: float | None
) -> None:
    field = await moving()
    verdict = push(field, picture_s=picture_s, slew=0.5)
    assert verdict.is_forwarded is (expected is not None)
    assert verdict.code == ("ok" if expected is not None else "picture_old")
    assert setpoints(field) == ([] if expected is None else [{"slew": expected}])


@pytest.mark.parametrize(("actor", "code"), [(JONAS, "no_lease"), (VERA, "not_allowed")])
async def test_who_does_not_hold_the_robot_moves_nothing(actor: SessionInfo, code: str) -> None:
    field = await moving()
    verdict = push(field, actor=actor)
    assert (verdict.is_forwarded, verdict.code) == (False, code)
    assert setpoints(field) == []


async def test_a_frame_that_was_held_up_moves_nothing_and_the_joint_is_told_to_rest() -> None:
    field = await moving()
    push(field, slew=0.1, extension=-0.2)
    held_up = [field.tick() for _ in range(20)]
    field.wait(2.1)
    assert {push(field, tick=tick).code for tick in held_up} == {"stale_tick"}
    assert setpoints(field) == [{"slew": 0.1, "extension": -0.2}, {"slew": 0.0, "extension": 0.0}]
    assert field.weeder.rates == {}


@pytest.mark.parametrize(("rtt_s", "expected"), [(0.02, 0.25), (0.199, 0.25), (0.21, 0.1), (0.301, None), (2.0, None)])
async def test_a_slow_link_makes_the_joints_slow_and_a_slower_one_stops_them(
    rtt_s: float, expected: float | None
) -> None:
    field = await moving()
    push(field)
    field.weeder.rtt_s = rtt_s
    verdict = push(field, slew=-2.0)
    if expected is None:
        assert (verdict.is_forwarded, verdict.code) == (False, "delay")
        assert setpoints(field)[-1] == {"slew": 0.0}
    else:
        assert setpoints(field)[-1] == {"slew": pytest.approx(-expected)}


async def test_an_unknown_delay_stops_the_joints() -> None:
    field = await moving()
    field.weeder.rtt_s = None
    assert push(field).code == "delay_unknown"


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
async def test_what_is_no_number_stops_the_joints(value: float) -> None:
    field = await moving()
    push(field)
    assert push(field, slew=value).code == "bad_setpoint"
    assert setpoints(field) == [{"slew": 0.1}, {"slew": 0.0}]


async def test_a_joint_the_machine_does_not_have_moves_nothing() -> None:
    field = await moving()
    verdict = push(field, tail=0.1)
    assert (verdict.code, verdict.text) == ("bad_setpoint", "Weeder 01 has no joint tail.")
    field.weeder.factsheet = None
    assert push(field).code == "bad_setpoint"
    assert setpoints(field) == []


async def test_a_socket_that_is_lost_sends_one_zero_and_then_silence() -> None:
    field = await moving()
    push(field)
    field.desk.drive.connection_lost("lane-1")
    field.desk.drive.connection_lost("lane-1")
    assert setpoints(field) == [{"slew": 0.1}, {"slew": 0.0}]


async def test_wheels_and_joints_are_one_pair_of_hands() -> None:
    field = await moving()
    push(field, lane="lane-1")
    frame = DriveFrame("weeder-01", 0.1, 0.0, field.tick())
    assert field.desk.drive.setpoint(MARTHA, "lane-2", frame).code == "driven_elsewhere"
    assert field.desk.drive.setpoint(MARTHA, "lane-1", frame).is_forwarded
    field.desk.drive.connection_lost("lane-1")
    assert setpoints(field)[-1] == {"slew": 0.0}
    wheels = [o.v_mps for o in field.weeder.orders if isinstance(o, DriveOrder)]
    assert wheels == [0.1, 0.0]


async def test_letting_go_of_the_joints_does_not_forget_that_the_wheels_turn() -> None:
    field = await moving()
    field.desk.drive.setpoint(MARTHA, "lane-1", DriveFrame("weeder-01", 0.1, 0.0, field.tick()))
    push(field, slew=0.1)
    push(field, slew=0.0)
    field.desk.drive.connection_lost("lane-1")
    assert [o.v_mps for o in field.weeder.orders if isinstance(o, DriveOrder)] == [0.1, 0.0]


async def test_taking_control_brings_the_joints_to_rest_at_once() -> None:
    field = await moving()
    push(field)
    field.desk.leases.operate(ANNA, "weeder-01", LeaseOp.TAKE, tick_id=field.tick(), reason="Person near")
    assert setpoints(field)[-1] == {"slew": 0.0}
    assert push(field).code == "no_lease"


async def test_a_stop_wins_over_joints_that_are_held() -> None:
    field = await moving()
    push(field)
    field.weeder.press("stop-00001", "Vera Lang")
    assert push(field).code == "no_lease"
    assert field.weeder.rates == {}


async def test_joints_move_only_while_driving_by_hand_is_open() -> None:
    field = await moving()
    field.weeder.mode = Mode.AUTO
    assert push(field).code == "not_manual"


async def test_a_silent_robot_is_not_moved() -> None:
    field = await moving()
    field.wait(2.5, hears=False)
    assert push(field).code == "robot_silent"


async def test_joints_rest_when_the_function_that_moves_them_goes_off() -> None:
    field = await moving()
    now_s = field.clock.mono_s()
    field.weeder.factsheet = factsheet(
        joints=(SLEW,), functions=(FunctionInfo("manual-tool", "Move the crane by hand", ("crane",)),)
    )
    field.weeder.nodes = {"crane": Node("crane", "started", None, None, 0, "", Stamp(now_s, now_s))}
    assert push(field).is_forwarded
    field.weeder.nodes = {"crane": Node("crane", "failure", None, None, 0, "", Stamp(now_s, now_s))}
    verdict = push(field)
    assert (verdict.code, verdict.text) == (
        "function_off",
        "Move the crane by hand is off: crane failed. Restart crane on Supervisor.",
    )
    assert setpoints(field)[-1] == {"slew": 0.0}


async def test_input_at_the_joints_starts_the_five_minutes_anew() -> None:
    field = await moving()
    for _ in range(200):
        field.wait(1.0)
        field.desk.pulse.here(MARTHA, "weeder-01", field.tick())
    push(field, slew=0.0)
    assert field.desk.drive.ends_in_s("weeder-01") == pytest.approx(100)
    push(field)
    assert field.desk.drive.ends_in_s("weeder-01") == pytest.approx(300)


async def test_five_minutes_without_input_end_it() -> None:
    field = await moving()
    for _ in range(305):
        field.wait(1.0)
        field.desk.pulse.here(MARTHA, "weeder-01", field.tick())
        await field.desk.tend()
    closes = [o for o in field.weeder.orders if isinstance(o, CommandOrder) and o.action is Action.DRIVE_CLOSE]
    assert len(closes) == 1


async def test_joints_that_the_robot_does_not_move_are_told_to_rest_and_why() -> None:
    field = await moving()
    push(field)
    text = "Somebody is within reach of the crane."
    refusal = Acknowledgement("weeder-01", "drive", "7", False, "person_inside", text, None, None, None)
    field.desk.drive.refused_by_robot(refusal)
    assert setpoints(field) == [{"slew": 0.1}, {"slew": 0.0}]
    assert [(told["code"], told["text"]) for told in field.events_of("jog")] == [("person_inside", text)]
    assert field.events_of("drive") == []

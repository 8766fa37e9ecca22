"""Hold to run: forwarded once or not at all, slower when the link is slow, zero when in doubt."""

from __future__ import annotations

import math

import pytest

from hmi.commands.drive import DriveFrame, DriveVerdict
from hmi.commands.lease_service import LeaseOp
from hmi.commands.ledger import CommandResult, Ticket
from hmi.commands.service import CommandRequest
from hmi.domain.command import Acknowledgement, Action, CommandOrder, DriveOrder, Outcome
from hmi.domain.robot import Mode
from hmi.security.session_info import SessionInfo
from tests.hmi.commands.field import ANNA, JONAS, MARTHA, Field, factsheet


async def driving() -> Field:
    """Return a field whose weeder Martha drives by hand."""
    field = Field()
    field.weeder.factsheet = factsheet()
    asked = CommandRequest("weeder-01", Action.DRIVE_OPEN, "open-0001", field.tick())
    assert (await field.desk.commands.submit(MARTHA, asked)).is_accepted
    assert field.weeder.mode is Mode.MANUAL
    return field


def push(
    field: Field, v: float = 0.2, w: float = 0.0, *, actor: SessionInfo = MARTHA, lane: str = "lane-1", tick: str = ""
) -> DriveVerdict:
    """Send one frame on a fresh picture."""
    return field.desk.drive.setpoint(actor, lane, DriveFrame("weeder-01", v, w, tick or field.tick()))


def setpoints(field: Field) -> list[tuple[float, float]]:
    """Return what the robot was told."""
    return [(o.v_mps, o.yaw_rate_radps) for o in field.weeder.orders if isinstance(o, DriveOrder)]


async def test_each_frame_is_forwarded_once_and_nothing_without_one() -> None:
    field = await driving()
    for _ in range(5):
        field.wait(0.1)
        assert push(field).is_forwarded
    field.wait(1.0)
    await field.desk.tend()
    assert setpoints(field) == [(0.2, 0.0)] * 5
    numbers = [o.lease_seq for o in field.weeder.orders if isinstance(o, DriveOrder)]
    assert numbers == sorted(set(numbers))
    assert field.weeder.v_mps == 0.2


async def test_who_does_not_hold_the_robot_moves_nothing() -> None:
    field = await driving()
    verdict = push(field, actor=JONAS)
    assert (verdict.is_forwarded, verdict.code) == (False, "no_lease")
    assert verdict.text == "Martha Keller has control. Ask for it."
    assert setpoints(field) == []


async def test_a_frame_that_was_held_up_moves_nothing_and_the_robot_is_told_to_rest() -> None:
    field = await driving()
    push(field)
    held_up = [field.tick() for _ in range(20)]
    field.wait(2.1)
    verdicts = [push(field, tick=tick) for tick in held_up]
    assert {v.code for v in verdicts} == {"stale_tick"}
    assert setpoints(field) == [(0.2, 0.0), (0.0, 0.0)]


@pytest.mark.parametrize(
    ("rtt_s", "expected_mps"), [(0.02, 0.5), (0.199, 0.5), (0.21, 0.2), (0.299, 0.2), (0.301, None), (2.0, None)]
)
async def test_a_slow_link_makes_the_robot_slow_and_a_slower_one_stops_it(
    rtt_s: float, expected_mps: float | None
) -> None:
    field = await driving()
    push(field)
    field.weeder.rtt_s = rtt_s
    verdict = push(field, v=2.0)
    if expected_mps is None:
        assert (verdict.is_forwarded, verdict.code) == (False, "delay")
        assert setpoints(field)[-1] == (0.0, 0.0)
    else:
        assert setpoints(field)[-1][0] == pytest.approx(expected_mps)


async def test_the_way_to_the_browser_counts_as_delay_too() -> None:
    field = await driving()
    field.weeder.rtt_s = 0.15
    tick = field.tick()
    field.wait(0.24)
    assert push(field, v=0.5, tick=tick).v_mps == pytest.approx(0.2)
    tick = field.tick()
    field.wait(0.26)
    assert push(field, v=0.5, tick=tick).code == "delay"


async def test_an_unknown_delay_stops_driving() -> None:
    field = await driving()
    field.weeder.rtt_s = None
    assert push(field).code == "delay_unknown"


async def test_setpoints_are_slowed_down_without_bending_the_curve() -> None:
    field = await driving()
    push(field, v=1.0, w=0.6)
    [(v, w)] = setpoints(field)
    assert v == pytest.approx(0.5)
    assert w / v == pytest.approx(0.6)


async def test_the_machines_own_limits_hold() -> None:
    field = await driving()
    field.weeder.factsheet = factsheet(max_speed_mps=0.1, max_yaw_rate_radps=0.05, can_reverse=False)
    push(field, v=0.5)
    push(field, v=-0.5)
    push(field, v=0.0, w=2.0)
    assert setpoints(field) == [pytest.approx((0.1, 0.0)), (0.0, 0.0), pytest.approx((0.0, 0.05))]


async def test_a_robot_that_never_said_what_it_is_creeps() -> None:
    field = await driving()
    field.weeder.factsheet = None
    assert push(field, v=0.5).v_mps == pytest.approx(0.2)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
async def test_what_is_no_number_stops_the_robot(value: float) -> None:
    field = await driving()
    push(field)
    assert push(field, v=value).code == "bad_setpoint"
    assert push(field, w=value).code == "bad_setpoint"
    assert setpoints(field) == [(0.2, 0.0), (0.0, 0.0)]


async def test_a_socket_that_is_lost_sends_one_zero_and_then_silence() -> None:
    field = await driving()
    push(field)
    field.desk.drive.connection_lost("another-lane")
    assert setpoints(field) == [(0.2, 0.0)]
    field.desk.drive.connection_lost("lane-1")
    field.desk.drive.connection_lost("lane-1")
    assert setpoints(field) == [(0.2, 0.0), (0.0, 0.0)]
    assert field.weeder.v_mps == 0.0


async def test_a_second_page_waits_until_the_first_let_go() -> None:
    field = await driving()
    push(field, lane="lane-1")
    assert push(field, v=0.1, lane="lane-2").code == "driven_elsewhere"
    assert field.weeder.v_mps == 0.2
    push(field, v=0.0, lane="lane-1")
    assert push(field, v=0.1, lane="lane-2").is_forwarded


async def test_taking_control_brings_the_robot_to_rest_at_once() -> None:
    field = await driving()
    push(field)
    field.desk.leases.operate(ANNA, "weeder-01", LeaseOp.TAKE, tick_id=field.tick(), reason="Person near")
    assert setpoints(field)[-1] == (0.0, 0.0)
    assert field.weeder.v_mps == 0.0
    assert push(field).code == "no_lease"


async def test_a_stop_ends_driving_until_control_is_taken_anew() -> None:
    field = await driving()
    push(field)
    field.weeder.press("stop-00001", "Vera Lang")
    assert push(field).code == "no_lease"
    assert field.weeder.v_mps == 0.0


async def test_driving_needs_to_be_opened_first() -> None:
    field = await driving()
    field.weeder.mode = Mode.PAUSED
    assert push(field).code == "not_manual"


async def test_a_silent_robot_is_not_driven() -> None:
    field = await driving()
    field.wait(2.5, hears=False)
    assert push(field).code == "robot_silent"


async def test_without_a_broker_the_person_is_told() -> None:
    field = await driving()
    field.weeder.is_deaf = True
    assert push(field).code == "not_connected"


async def test_five_minutes_without_input_end_driving() -> None:
    field = await driving()
    for _ in range(310):
        field.wait(1.0)
        field.desk.pulse.here(MARTHA, "weeder-01", field.tick())
        push(field, v=0.0)
        await field.desk.tend()
    closes = [o for o in field.weeder.orders if isinstance(o, CommandOrder) and o.action is Action.DRIVE_CLOSE]
    assert len(closes) == 1
    assert field.events_of("drive")[-1]["text"] == "Driving by hand ended: nothing was pressed for 5:00."


async def test_a_hand_that_presses_while_another_robot_is_closed_goes_on_driving() -> None:
    field = await driving()
    field.add("weeder-02", "Weeder 02").factsheet = factsheet()
    asked = CommandRequest("weeder-02", Action.DRIVE_OPEN, "open-0002", field.tick())
    assert (await field.desk.commands.submit(MARTHA, asked)).is_accepted
    for _ in range(301):
        field.wait(1.0)
        for robot_id in ("weeder-01", "weeder-02"):
            field.desk.pulse.here(MARTHA, robot_id, field.tick())
    closed: list[str] = []

    def press(ticket: Ticket, result: CommandResult) -> None:
        if ticket.what == Action.DRIVE_CLOSE.value and result.outcome is Outcome.PENDING:
            closed.append(ticket.robot_id)
            field.desk.drive.setpoint(MARTHA, "lane-1", DriveFrame("weeder-02", 0.2, 0.0, field.tick()))

    field.desk.ledger.when_settled(press)
    await field.desk.tend()
    assert closed == ["weeder-01"]
    assert field.desk.drive.ends_in_s("weeder-02") == 300.0


async def test_driving_that_ends_while_another_robot_is_closed_is_no_error() -> None:
    field = await driving()
    field.add("weeder-02", "Weeder 02").factsheet = factsheet()
    asked = CommandRequest("weeder-02", Action.DRIVE_OPEN, "open-0002", field.tick())
    assert (await field.desk.commands.submit(JONAS, asked)).is_accepted
    for _ in range(301):
        field.wait(1.0)
        field.desk.pulse.here(MARTHA, "weeder-01", field.tick())
        field.desk.pulse.here(JONAS, "weeder-02", field.tick())
    field.desk.ledger.when_settled(lambda _ticket, _result: field.desk.leases.end_session(JONAS.session_id))
    await field.desk.tend()
    assert [event["robot"] for event in field.events_of("drive")] == ["weeder-01"]


async def test_every_input_starts_the_five_minutes_anew() -> None:
    field = await driving()
    field.wait(200)
    assert push(field).code == "no_lease"  # no sign of life from the page: control ended long before
    field = await driving()
    for _ in range(200):
        field.wait(1.0)
        field.desk.pulse.here(MARTHA, "weeder-01", field.tick())
    assert field.desk.drive.ends_in_s("weeder-01") == pytest.approx(100)
    assert push(field).ends_in_s == pytest.approx(300)


@pytest.mark.parametrize(("picture_s", "expected_mps"), [(None, 0.5), (0.2, 0.5), (0.51, 0.2), (1.0, 0.2)])
async def test_an_old_picture_makes_who_steers_by_it_slow(picture_s: float | None, expected_mps: float) -> None:
    field = await driving()
    verdict = field.desk.drive.setpoint(MARTHA, "lane-1", DriveFrame("weeder-01", 0.5, 0.0, field.tick(), picture_s))
    assert verdict.v_mps == pytest.approx(expected_mps)


@pytest.mark.parametrize("picture_s", [1.01, 12.0, math.nan, -1.0])
async def test_nobody_steers_by_a_frozen_picture_and_the_robot_is_told_to_rest(picture_s: float) -> None:
    field = await driving()
    push(field)
    verdict = field.desk.drive.setpoint(MARTHA, "lane-1", DriveFrame("weeder-01", 0.2, 0.0, field.tick(), picture_s))
    assert (verdict.is_forwarded, verdict.code) == (False, "picture_old")
    assert setpoints(field) == [(0.2, 0.0), (0.0, 0.0)]
    assert push(field).is_forwarded, "without the picture the limit is gone"


def answer(code: str, text: str = "") -> Acknowledgement:
    """Return the robot's answer to a setpoint."""
    return Acknowledgement("weeder-01", "drive", "7", code == "ok", code, text, None, None, None)


async def test_what_the_robot_refuses_is_told_once_and_it_is_told_to_rest() -> None:
    field = await driving()
    push(field)
    for _ in range(3):
        field.desk.drive.refused_by_robot(answer("function_off", "Driving is off: drive does not run."))
    assert setpoints(field) == [(0.2, 0.0), (0.0, 0.0)]
    [told] = field.events_of("drive")
    assert (told["op"], told["code"], told["text"]) == (
        "refused",
        "function_off",
        "Driving is off: drive does not run.",
    )


async def test_an_answer_to_a_hand_that_is_gone_says_nothing() -> None:
    field = await driving()
    field.desk.drive.refused_by_robot(answer("not_in_manual"))
    push(field)
    field.desk.drive.refused_by_robot(answer("ok"))
    push(field, v=0.0)
    field.desk.drive.refused_by_robot(answer("not_in_manual"))
    assert field.events_of("drive") == []
    assert setpoints(field) == [(0.2, 0.0), (0.0, 0.0)]

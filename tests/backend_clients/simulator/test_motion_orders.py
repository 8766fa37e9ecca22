"""Missions, pauses, driving by hand: what the robot does when it is asked."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from backend_clients.edge import messages_down as down
from tests.backend_clients.simulator.rig import Rig, small_mission


def status(rig: Rig) -> str:
    order = rig.state.order
    return order.status if order is not None else "none"


def row_of(rig: Rig) -> int:
    order = rig.state.order
    assert order is not None
    return order.row


def until(rig: Rig, row: int) -> None:
    for _ in range(400):
        if row_of(rig) >= row and rig.state.path[-1] == "Laser firing":
            return
        rig.run(0.5)
    raise AssertionError(f"row {row} was never reached: {rig.state}")


def test_sending_a_mission_moves_nothing_and_is_answered_with_its_hash() -> None:
    rig = Rig()
    mission = small_mission()
    ack = rig.load(mission)
    rig.run(5)
    assert (ack.outcome, ack.ref, ack.sha256 is not None) == ("accepted", "mission-1", True)
    assert rig.robot.machine.base.distance_m == 0
    assert (rig.state.mode, status(rig)) == ("idle", "loaded")


def test_the_horn_sounds_for_three_seconds_before_anything_moves() -> None:
    rig = Rig()
    assert rig.start().outcome == "accepted"
    rig.run(2.9)
    assert rig.robot.machine.base.distance_m == 0
    assert rig.state.path == ["Mission", "Start", "Horn"]
    assert rig.state.hold is not None
    assert rig.state.hold.code == "start_horn"
    rig.run(1.0)
    assert rig.speed > 0.1


def test_a_mission_is_driven_to_its_end_with_the_laser_on_in_rows_only() -> None:
    rig = Rig()
    rig.start()
    fired_outside = 0
    worst_m = 0.0
    for _ in range(1600):
        rig.run(0.05)
        base = rig.robot.machine.base
        if rig.robot.machine.tool_on and not (-0.1 < base.y_m < 12.1 and abs(base.x_m - 3 * round(base.x_m / 3)) < 0.1):
            fired_outside += 1
        cross = rig.telemetry.cross_track_m
        worst_m = max(worst_m, abs(cross or 0.0))
        if status(rig) == "done":
            break
    order = rig.state.order
    assert order is not None
    assert (order.status, order.row, order.rows) == ("done", 3, 3)
    assert order.area_done_m2 == pytest.approx(order.area_m2, rel=0.05)
    assert order.remaining_s == 0
    assert fired_outside == 0
    assert worst_m < 0.05
    assert [e.data["row"] for e in rig.events if e.kind == "treatment"] == [1, 2, 3]
    assert rig.state.mode == "idle"


def test_a_treated_headland_is_one_event_after_the_rows() -> None:
    rig = Rig()
    rows = small_mission(rows=1, length_m=6)
    (x, y), before = rows.segments[-1].points[-1], rows.segments[-1].points[-2]
    along = math.atan2(y - before[1], x - before[0])
    lap = [(x, y), (x + 8 * math.cos(along), y + 8 * math.sin(along))]
    headland = down.Segment(kind="headland", points=lap, speed_mps=0.45, tool_on=True)
    rig.start(small_mission(segments=[*rows.segments, headland]))
    rig.run(60)
    treated = [(e.name, e.data["row"]) for e in rig.events if e.kind == "treatment"]
    assert treated == [("Row 1 treated", 1), ("Headland treated", 0)]
    assert next(e.data["length_m"] for e in rig.events if e.name == "Headland treated") == pytest.approx(8, abs=0.5)


@pytest.mark.parametrize(("dose", "share"), [(1.0, 1.0), (0.5, 0.5), (2.0, 0.5)])
def test_a_dose_changes_what_is_treated_in_the_same_time(dose: float, share: float) -> None:
    def weeds(mission: down.Mission) -> float:
        rig = Rig()
        rig.start(mission)
        rig.run(60)
        return float(next(e.data["weeds"] for e in rig.events if e.kind == "treatment"))

    usual = small_mission(rows=1, length_m=60)
    dosed = [msgspec.structs.replace(s, dose=dose) if s.tool_on else s for s in usual.segments]
    assert weeds(small_mission(segments=dosed)) == pytest.approx(share * weeds(usual), rel=0.05, abs=1)


def test_the_speed_never_exceeds_six_kilometres_an_hour() -> None:
    rig = Rig()
    mission = small_mission(rows=1, length_m=60)
    fast = [
        s.__class__(kind=s.kind, points=s.points, speed_mps=9.0, tool_on=s.tool_on, row=s.row) for s in mission.segments
    ]
    rig.start(small_mission(segments=fast))
    top = 0.0
    for _ in range(40):
        rig.run(0.5)
        top = max(top, rig.speed)
    assert 1.5 < top <= 6 / 3.6 + 1e-9


def test_rtk_noise_stays_within_fifteen_millimetres() -> None:
    rig = Rig()
    worst = 0.0
    for _ in range(400):
        rig.run(0.1)
        worst = max(worst, abs(rig.telemetry.x_m - rig.config.x_m), abs(rig.telemetry.y_m - rig.config.y_m))
    assert 0.001 < worst <= 0.0151


def test_pause_brakes_and_resume_goes_on_in_the_same_row() -> None:
    rig = Rig()
    rig.start()
    until(rig, 2)
    assert rig.do("pause", lease_token=0, lease_seq=0).outcome == "accepted"
    rig.run(3)
    assert (rig.state.mode, rig.speed, rig.robot.machine.tool_on) == ("paused", 0, False)
    assert rig.state.hold is not None
    assert rig.state.hold.code == "paused"
    assert rig.do("resume").outcome == "accepted"
    rig.run(6)
    assert (rig.state.mode, row_of(rig)) == ("auto", 2)
    assert rig.speed > 0.5


def test_resume_is_refused_with_the_way_out_after_the_robot_was_moved() -> None:
    rig = Rig()
    rig.start()
    until(rig, 1)
    rig.do("pause")
    rig.run(3)
    rig.do("drive_open")
    rig.drive_for(3, 0.5)
    rig.do("drive_close")
    rig.run(2)
    ack = rig.do("resume")
    assert (ack.outcome, ack.code) == ("rejected", "moved_while_paused")
    assert "Drive it back" in ack.text
    assert "Resume later" in ack.text
    assert rig.state.hold is not None
    assert rig.state.hold.code == "moved_while_paused"


def test_start_after_a_move_goes_to_the_path_ahead_and_finishes() -> None:
    rig = Rig()
    rig.start()
    until(rig, 1)
    rig.do("pause")
    rig.run(2)
    rig.do("drive_open")
    rig.drive_for(2, 0.5, 0.3)
    rig.drive_for(2, 0.6)
    rig.do("drive_close")
    rig.run(2)
    before = row_of(rig)
    mission = small_mission()
    assert rig.do("start", mission_id=mission.mission_id).outcome == "accepted"
    assert row_of(rig) == before
    rig.run(100)
    assert status(rig) == "done"


def test_abort_ends_the_mission_and_needs_no_lease() -> None:
    rig = Rig()
    rig.start()
    rig.run(6)
    ack = rig.do("abort", lease_token=0, lease_seq=0)
    rig.run(3)
    assert ack.outcome == "accepted"
    assert (status(rig), rig.state.mode, rig.speed) == ("aborted", "idle", 0)


def test_return_home_drives_home_with_the_laser_off_and_keeps_the_mission() -> None:
    rig = Rig()
    rig.start()
    until(rig, 2)
    assert rig.do("return_home").outcome == "accepted"
    was_on = False
    for _ in range(120):
        rig.run(0.5)
        was_on = was_on or rig.robot.machine.tool_on
        if not rig.boot.brain.is_auto:
            break
    base = rig.robot.machine.base
    assert (base.x_m, base.y_m) == pytest.approx((rig.config.x_m, rig.config.y_m), abs=0.1)
    assert not was_on
    assert status(rig) == "paused"


def test_a_mission_that_ends_at_home_is_done_only_at_home() -> None:
    rig = Rig()
    rig.start(small_mission(rows=1, at_end="return_home", home=(-4.0, -6.0)))
    rig.run(80)
    base = rig.robot.machine.base
    assert status(rig) == "done"
    assert (base.x_m, base.y_m) == pytest.approx((-4.0, -6.0), abs=0.1)


def test_a_mission_in_another_datum_is_driven_at_the_same_place_on_earth() -> None:
    near = Rig(datum_lat_deg=52.0004, datum_lon_deg=5.0003, x_m=-20.6, y_m=-46.5)
    near.start(small_mission(rows=1))
    near.run(60)
    assert status(near) == "done"
    assert near.telemetry.lat_deg == pytest.approx(52.0 + 12 / 111267, abs=2e-6)
    assert near.telemetry.lon_deg == pytest.approx(5.0, abs=2e-6)


@pytest.mark.parametrize(
    ("prepare", "code"),
    [
        ({"mission_id": "other"}, "wrong_mission"),
        ({"mission_id": "mission-1", "mission_sha256": "0" * 64}, "wrong_mission"),
    ],
)
def test_start_is_refused_for_another_mission(prepare: dict[str, str], code: str) -> None:
    rig = Rig()
    rig.load(small_mission())
    ack = rig.do("start", **prepare)
    assert (ack.outcome, ack.code) == ("rejected", code)
    assert ack.text.endswith(".")


def test_start_without_a_mission_is_refused() -> None:
    assert Rig().do("start", mission_id="mission-1").code == "no_mission"


def test_a_running_mission_cannot_be_replaced() -> None:
    rig = Rig()
    rig.start()
    rig.run(4)
    assert rig.load(small_mission(mission_id="mission-2")).code == "mission_active"
    assert rig.load(small_mission()).code == "already_stored"


def test_a_path_with_a_hole_is_refused_in_words() -> None:
    rig = Rig()
    segments = list(small_mission().segments)
    del segments[2]
    ack = rig.load(small_mission(segments=segments))
    assert ack.code == "bad_mission"
    assert "does not begin where the one before it ends" in ack.text


def test_a_drive_setpoint_moves_it_and_its_absence_stops_it_within_half_a_second() -> None:
    rig = Rig()
    rig.do("drive_open")
    rig.drive_for(3, 0.5)
    assert rig.speed == pytest.approx(0.5, abs=0.01)
    began = rig.clock.mono_s()
    rig.run(0.35)
    assert rig.speed == pytest.approx(0.5, abs=0.01)
    rig.run(0.6)
    assert rig.speed == 0
    assert rig.robot.stopped_at_s is not None
    assert rig.robot.stopped_at_s - began < 0.5 + 0.5 / 1.2 + 0.15


def test_driving_by_hand_is_capped_and_never_fires_the_laser() -> None:
    rig = Rig()
    rig.start()
    until(rig, 1)
    assert rig.do("drive_open").outcome == "accepted"
    top = 0.0
    for _ in range(40):
        rig.drive(2.0)
        rig.run(0.1)
        top = max(top, rig.speed)
        assert not rig.robot.machine.tool_on
    assert top <= 1.0 + 0.5
    assert rig.speed == pytest.approx(1.0, abs=0.01)
    assert (rig.state.mode, status(rig)) == ("manual", "paused")


def test_setpoints_are_refused_when_driving_is_not_open() -> None:
    rig = Rig()
    ack = rig.drive(0.5)
    assert ack is not None
    assert (ack.kind, ack.code) == ("drive", "not_in_manual")
    assert rig.drive(0.5) is None, "refused setpoints are answered at most twice a second"
    rig.run(1)
    assert rig.speed == 0


def test_an_open_drive_nobody_uses_is_closed() -> None:
    rig = Rig()
    rig.do("drive_open")
    rig.has_page = False
    rig.run(11)
    assert rig.state.mode == "idle"


def test_a_supervised_mission_pauses_when_no_page_of_its_operator_is_open() -> None:
    rig = Rig()
    rig.start()
    rig.run(6)
    rig.has_page = False
    rig.run(2.4)
    assert rig.state.mode == "auto"
    rig.run(1.3)
    assert rig.state.mode == "paused"
    assert rig.state.hold is not None
    assert rig.state.hold.code == "operator_lost"


def test_an_unattended_mission_goes_on_without_a_page_but_not_without_the_farm() -> None:
    rig = Rig()
    rig.has_page = False
    rig.start(is_supervised=False)
    rig.run(9.8)
    assert rig.state.mode == "auto"
    rig.run(0.5)
    assert rig.state.hold is not None
    assert rig.state.hold.code == "link_lost"


def test_a_mission_goes_on_as_the_one_who_resumes_it_says_not_as_it_began() -> None:
    rig = Rig()
    rig.start(is_supervised=False)
    rig.run(6)
    rig.do("pause")
    rig.run(2)
    assert rig.do("resume", is_supervised=True).outcome == "accepted"
    rig.run(6)
    rig.has_page = False
    rig.run(4.0)
    assert rig.state.hold is not None
    assert rig.state.hold.code == "operator_lost"


def gateway_ping(rig: Rig) -> down.Order:
    return down.Ping(robot="weeder-01", nonce="stop-0123456789ab")


def refused_order(rig: Rig) -> down.Order:
    return rig.order("pause", challenge="of-yesterday")


def order_of_an_old_lease(rig: Rig) -> down.Order:
    return rig.order("resume", lease_token=rig.token - 1)


def mission_of_the_cloud(rig: Rig) -> down.Order:
    return small_mission()


def console_ping(rig: Rig) -> down.Order:
    return down.Ping(robot="weeder-01", nonce="console-1")


def page_of_the_operator(rig: Rig) -> down.Order:
    return down.OperatorHeartbeat(
        robot="weeder-01", lease_token=rig.token, lease_seq=rig.next_seq(), challenge=rig.challenge()
    )


def unattended(rig: Rig, message: Callable[[Rig], down.Order], seconds: float) -> str:
    """Start an unattended mission, send it one message a second; return what it does after ``seconds``."""
    rig.has_page = False
    rig.start(is_supervised=False)
    for _ in range(round(seconds)):
        rig.robot.receive(message(rig))
        rig.run(1)
    return rig.state.hold.code if rig.state.hold is not None else rig.state.mode


@pytest.mark.parametrize("message", [gateway_ping, refused_order, order_of_an_old_lease, mission_of_the_cloud])
def test_what_also_comes_from_a_farm_without_console_keeps_no_unattended_mission_going(
    message: Callable[[Rig], down.Order],
) -> None:
    assert unattended(Rig(), message, 11) == "link_lost"


@pytest.mark.parametrize("message", [console_ping, page_of_the_operator])
def test_signs_of_life_of_the_console_keep_an_unattended_mission_going(message: Callable[[Rig], down.Order]) -> None:
    assert unattended(Rig(), message, 11) == "auto"


def test_a_repeated_order_is_no_new_sign_of_life() -> None:
    rig = Rig()
    first = rig.order("stock_refilled", command_id="same-id-1")
    assert unattended(rig, lambda _rig: first, 11) == "link_lost"


def test_each_robot_pauses_after_its_own_time_without_the_console_and_says_so() -> None:
    rig = Rig(link_lost_pause_s=5.0)
    assert rig.boot.reporter.factsheet().behaviour.link_lost_pause_s == 5.0
    assert unattended(rig, gateway_ping, 6) == "link_lost"
    with pytest.raises(ValueError, match="outside 5 to 300"):
        Rig(link_lost_pause_s=301.0)


def test_a_reboot_brings_the_mission_back_paused_with_its_progress(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.start()
    until(rig, 2)
    place = (rig.robot.machine.base.x_m, rig.robot.machine.base.y_m)
    before = rig.state
    rig.restart_process()
    rig.run(5)
    after = rig.state
    assert after.boot != before.boot
    assert (after.mode, status(rig), row_of(rig)) == ("paused", "paused", 2)
    assert rig.robot.machine.base.distance_m == 0
    assert (rig.robot.machine.base.x_m, rig.robot.machine.base.y_m) == pytest.approx(place, abs=2.0)
    assert rig.do("resume").outcome == "accepted"
    rig.run(60)
    assert status(rig) == "done"


def test_speed_up_hastens_a_mission_but_not_driving_by_hand() -> None:
    slow, fast = Rig(), Rig()
    for rig, speed in ((slow, 1.0), (fast, 10.0)):
        rig.start()
        rig.run(2, speed=speed)
    assert slow.robot.machine.base.distance_m == 0
    assert fast.robot.machine.base.distance_m > 8
    fast.do("pause")
    fast.run(3)
    fast.do("drive_open")
    before = fast.robot.machine.base.distance_m
    fast.drive_for(2, 0.5)
    assert fast.robot.machine.base.distance_m - before < 1.0


@pytest.mark.parametrize(
    "named",
    [
        {"mission_sha256": "0" * 64},
        {"mission_id": "mission-2"},
        {"mission_id": None, "mission_sha256": None},
    ],
)
def test_a_resume_is_for_the_version_that_was_looked_at(named: dict[str, Any]) -> None:
    rig = Rig()
    rig.start()
    until(rig, 1)
    rig.do("pause")
    rig.run(3)
    assert rig.do("resume", **named).code == "wrong_mission"
    rig.run(4)
    assert (rig.state.mode, rig.speed) == ("paused", 0)
    assert rig.do("resume").outcome == "accepted"

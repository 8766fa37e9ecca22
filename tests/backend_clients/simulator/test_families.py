"""Every family obeys the same safety rules; each does its own work."""

from __future__ import annotations

import math

import pytest

from backend_clients.edge import messages_down as down
from backend_clients.simulator.faults import CraneLimit, LowBattery, TrayEmpty
from tests.backend_clients.simulator.rig import Rig, small_mission

FAMILIES = ("weeder", "planter", "uav")
EFFECTS = {
    "weeder": "Laser off, tracks brake",
    "planter": "Drive and crane stop, hydraulics hold",
    "uav": "Brakes and hovers",
}
each_family = pytest.mark.parametrize("family", FAMILIES)


@pytest.fixture(params=[False, True], ids=["full", "lean"])
def is_lean(request: pytest.FixtureRequest) -> bool:
    """Return whether the robot is a lean one."""
    return bool(request.param)


def until(rig: Rig, wanted: object, limit_s: float) -> float:
    """Let time pass until ``wanted()``; return how long it took."""
    took_s = 0.0
    while not wanted():  # type: ignore[operator]
        assert took_s < limit_s, rig.state
        rig.run(0.25)
        took_s += 0.25
    return took_s


@each_family
def test_a_factsheet_names_the_family_and_what_stop_does(family: str) -> None:
    sheet = Rig(family=family).boot.reporter.factsheet()
    assert sheet.family == family
    assert sheet.behaviour.stop_effect == EFFECTS[family]
    nodes = {node.name for node in Rig(family=family).boot.reporter.nodes()}
    needed = {name for function in sheet.functions for name in function.depends_on}
    assert needed <= nodes | {function.name for function in sheet.functions}


@each_family
def test_stop_brakes_latches_and_survives_the_power_cut(family: str, is_lean: bool, tmp_path: object) -> None:
    rig = Rig(tmp_path, family=family, is_lean=is_lean)  # type: ignore[arg-type]
    rig.start(small_mission(length_m=60.0))
    until(rig, lambda: rig.speed > 0.8, 30.0)
    speed, limits = rig.speed, rig.boot.reporter.factsheet().limits
    assert rig.stop().outcome == "accepted"
    rig.run(speed / limits.decel_mps2 + 0.5 + 0.6)
    assert (rig.safety.latched, rig.safety.standstill, rig.safety.tool_off) == (True, True, True)
    rig.has_page = False
    rig.restart_process()
    assert rig.safety.latched
    assert rig.do("resume").code in ("stop_latched", "lease_revoked")


@each_family
def test_a_reset_moves_nothing_and_resume_goes_on(family: str, is_lean: bool) -> None:
    rig = Rig(family=family, is_lean=is_lean)
    rig.start(small_mission(length_m=60.0))
    until(rig, lambda: rig.speed > 0.5, 30.0)
    rig.stop()
    rig.run(4.0)
    assert rig.reset().outcome == "accepted"
    place = rig.boot.brain.place
    rig.run(5.0)
    assert math.dist(place, rig.boot.brain.place) < 1e-6
    assert rig.do("resume").outcome == "accepted"
    until(rig, lambda: rig.speed > 0.3, 10.0)


@each_family
def test_driving_by_hand_ends_half_a_second_after_the_last_setpoint(family: str, is_lean: bool) -> None:
    rig = Rig(family=family, is_lean=is_lean)
    rig.do("drive_open")
    rig.drive_for(3.0, 0.5)
    assert rig.speed == pytest.approx(0.5, abs=0.01)
    assert rig.safety.tool_off
    rig.run(0.35)  # and the 0.1 s since the last one
    assert rig.speed == pytest.approx(0.5, abs=0.01)
    rig.run(0.1 + 0.5 / rig.config.profile.motion.brake_mps2)
    assert rig.speed == 0


@each_family
def test_a_supervised_mission_pauses_when_nobody_looks_and_an_unattended_one_when_the_farm_is_silent(
    family: str, is_lean: bool
) -> None:
    rig = Rig(family=family, is_lean=is_lean)
    rig.start(small_mission(length_m=80.0))
    rig.run(6.0)
    rig.has_page = False
    rig.run(4.2)
    assert rig.state.hold is not None
    assert (rig.state.mode, rig.state.hold.code) == ("paused", "operator_lost")
    if family == "uav":  # see below
        return
    other = Rig(family=family, is_lean=is_lean)
    other.start(small_mission(length_m=80.0), is_supervised=False)
    other.has_page = False
    other.run(9.0)
    assert other.state.mode == "auto"
    other.run(2.0)
    assert other.state.hold is not None
    assert other.state.hold.code == "link_lost"


@each_family
def test_a_late_order_of_an_old_lease_is_refused(family: str) -> None:
    rig = Rig(family=family)
    late = rig.order("drive_open")
    rig.run(3.0)
    answer = rig.robot.receive(late)
    assert answer is not None
    assert answer.code == "stale_challenge"


def planting() -> Rig:
    """Return a planter that stands at its first tree."""
    rig = Rig(family="planter")
    rig.start(small_mission(length_m=12.0))
    until(rig, lambda: rig.robot.machine.tool_on, 30.0)
    return rig


@pytest.mark.slow
def test_a_planter_works_a_whole_site_before_it_drives_four_metres_on() -> None:
    rig = planting()
    body = rig.robot.machine.rig
    assert body is not None
    until(rig, lambda: body.site is not None, 5.0)
    first, base = body.site, rig.boot.brain.place
    assert first is not None
    assert (rig.speed, rig.safety.standstill) == (0, False)  # the crane works
    until(rig, lambda: body.site is not first, 600.0)
    assert not first.is_left
    assert math.dist(base, rig.boot.brain.place) == pytest.approx(4.0, abs=0.15)
    assert rig.robot.machine.seedlings == 67 - first.planted - body.in_head - body.in_arm


def test_stop_in_the_middle_of_a_planting_stops_the_crane_at_once() -> None:
    rig = planting()
    rig.stop()
    rig.run(0.6)
    assert (rig.safety.standstill, rig.safety.tool_off) == (True, True)


def test_a_planter_without_seedlings_waits_for_a_tray_and_goes_on_with_a_full_one() -> None:
    rig = planting()
    rig.robot.set_fault(TrayEmpty(left=1))
    until(rig, lambda: rig.state.hold is not None, 240.0)
    hold = rig.state.hold
    assert hold is not None
    assert (hold.code, hold.who) == ("tray_empty", "person at the machine")
    assert [fault.code for fault in rig.state.faults] == ["tray-empty"]
    rig.robot.clear_fault("tray-empty")
    until(rig, lambda: rig.robot.machine.tool_on, 30.0)
    until(rig, lambda: rig.robot.machine.seedlings == 66, 60.0)


def test_a_crane_outside_its_limit_waits_until_somebody_moves_it_by_hand() -> None:
    rig = Rig(family="planter")
    rig.start(small_mission(length_m=12.0))
    rig.run(5.0)
    rig.robot.set_fault(CraneLimit())
    rig.run(2.0)
    hold = rig.state.hold
    assert hold is not None
    assert (hold.code, hold.text) == ("crane_limit", "The crane is outside its limit.")
    assert rig.speed == 0
    rig.do("drive_open")
    rig.jog_for(1.0, stick=-0.2)
    assert "crane-limit" not in [fault.code for fault in rig.state.faults]


@pytest.mark.slow
def test_a_planter_reports_each_tree_and_the_trees_of_a_row() -> None:
    rig = Rig(family="planter")
    rig.start(small_mission(rows=2, length_m=6.0, width_m=4.0))
    until(rig, lambda: any(e.name == "Row 1 planted" for e in rig.events), 900.0)
    treated = [e for e in rig.events if e.kind == "treatment"]
    planted = [e for e in treated if e.data.get("outcome") == "done"]
    assert treated[-1].data["trees"] == len(planted) > 0
    assert {"target", "code", "x_m", "y_m", "stop", "duration_s", "mission_id"} <= set(planted[0].data)
    assert planted[0].name == f"Tree {planted[0].data['target'].removeprefix('tree-')} planted"


def test_a_uav_flies_home_by_itself_at_its_reserve_and_charges_there() -> None:
    rig = Rig(family="uav")
    rig.start(small_mission(rows=9, length_m=200.0), is_supervised=False)
    until(rig, lambda: rig.boot.brain.place[1] > 30, 60.0)
    rig.robot.set_fault(LowBattery(soc=0.26))
    assert rig.robot.machine.is_airborne
    until(rig, lambda: rig.state.path[0] == "Return home", 60.0)
    until(rig, lambda: rig.boot.brain.is_at_home, 120.0)
    rig.run(2.0)
    battery = rig.telemetry.battery
    assert battery is not None
    assert battery.charging
    assert not rig.robot.machine.is_airborne


def test_a_uav_climbs_to_the_height_its_path_was_planned_for_before_it_moves_along_it() -> None:
    rig = Rig(family="uav")
    rig.start(small_mission(rows=3, length_m=200.0), is_supervised=False)
    brain, machine = rig.boot.brain, rig.robot.machine
    start, least_m = brain.place, 1000.0
    for _ in range(200):
        rig.run(0.2)
        if math.dist(brain.place, start) > 1.0:
            least_m = min(least_m, machine.height_m)
    assert math.dist(brain.place, start) > 5.0
    assert least_m > 29.0


def uav(is_lean: bool) -> Rig:
    """Return a UAV on the first of its search lines, which takes it half a minute."""
    rig = Rig(family="uav", is_lean=is_lean)
    rig.start(small_mission(rows=3, length_m=200.0), is_supervised=False)
    until(rig, lambda: rig.boot.brain.place[1] > 5, 60.0)
    rig.has_page = False
    return rig


def farthest_m(rig: Rig, seconds: float) -> float:
    """Let time pass until it has landed at home; return how far out it was."""
    far_m = 0.0
    for _ in range(round(seconds * 2)):
        if rig.boot.brain.is_at_home:
            return far_m
        rig.run(0.5)
        far_m = max(far_m, rig.boot.brain.place[1])
    raise AssertionError(f"it did not come home: {rig.state}")


def test_a_uav_that_loses_the_farm_ends_its_line_flies_home_and_lands(is_lean: bool) -> None:
    rig = uav(is_lean)
    assert farthest_m(rig, 300.0) > 199.0
    assert rig.state.order is not None
    assert (rig.state.mode, rig.state.order.status, rig.state.order.row) == ("paused", "paused", 1)
    rig.run(2.0)
    assert not rig.robot.machine.is_airborne


def test_a_uav_nobody_looks_at_does_not_hover_until_its_battery_is_empty(is_lean: bool) -> None:
    rig = uav(is_lean)
    rig.do("pause")
    rig.run(9.0)
    assert (rig.state.mode, rig.speed) == ("paused", 0.0)
    farthest_m(rig, 60.0)  # the farm is not heard
    again = uav(is_lean)
    again.do("pause")
    again.robot.set_fault(LowBattery(soc=0.24))
    again.robot.receive(down.Ping(robot="weeder-01", nonce="console-1"))
    again.run(4.0)
    assert again.state.path[0] == "Return home"  # it is heard, but the reserve is reached


def test_who_looks_on_decides_how_long_a_uav_hovers_until_the_battery_is_very_low(is_lean: bool) -> None:
    rig = uav(is_lean)
    rig.has_page = True
    rig.do("drive_open")
    rig.robot.set_fault(LowBattery(soc=0.15))
    rig.drive_for(5.0, 0.5)
    assert rig.state.mode == "manual"
    rig.robot.set_fault(LowBattery(soc=0.09))
    rig.drive_for(1.0, 0.5)
    assert rig.state.path[0] == "Return home"


def test_a_stopped_uav_stays_where_it_is_though_the_farm_is_lost(is_lean: bool) -> None:
    rig = uav(is_lean)
    rig.stop()
    rig.run(3.0)
    place = rig.boot.brain.place
    rig.robot.set_fault(LowBattery(soc=0.05))
    rig.run(15.0)
    assert math.dist(place, rig.boot.brain.place) < 0.01


def test_a_uav_in_the_air_lasts_about_twenty_minutes() -> None:
    energy = Rig(family="uav").config.profile.energy
    flying_w = energy.idle_w + energy.hover_w + energy.tool_w + 5 * energy.drive_w_per_mps
    assert 18 * 60 < energy.capacity_j / flying_w < 25 * 60


def test_a_lean_robot_does_the_same_mission_as_a_full_one() -> None:
    ends = []
    for is_lean in (False, True):
        rig = Rig(is_lean=is_lean)
        rig.start(small_mission(rows=2))
        until(rig, lambda rig=rig: rig.state.order is not None and rig.state.order.status == "done", 120.0)
        order = rig.state.order
        assert order is not None
        ends.append((order.row, round(order.area_done_m2 / order.area_m2, 1)))
    assert ends[0] == ends[1] == (2, 1.0)

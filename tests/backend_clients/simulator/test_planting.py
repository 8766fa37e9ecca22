"""Crane, sites and what a planter says of them."""

from __future__ import annotations

import base64
import itertools
import math
import random

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from backend_clients.edge import messages_down as down
from backend_clients.simulator.crane import JOINTS, TRANSPORT, Crane, OutOfReach, pose_for, tip_of
from backend_clients.simulator.enu import EnuFrame
from backend_clients.simulator.families import FAMILIES
from backend_clients.simulator.faults import PersonAhead
from backend_clients.simulator.joint_travel import is_beyond
from backend_clients.simulator.kinematics import Base
from backend_clients.simulator.mission_run import MissionRun
from backend_clients.simulator.planter_rig import FAILS_NEVER, PlanterRig, Tuning
from backend_clients.simulator.planting_site import CLEAR_M, Site, Stretch, area_of, is_reachable, map_site
from backend_clients.simulator.planting_stops import Stops
from tests.backend_clients.simulator.rig import LAT, LON, Rig, small_mission
from tests.backend_clients.simulator.test_families import until

BASE = Base(x_m=8.0, y_m=0.0, theta_rad=0.0)


def mapped(seed: str, width_m: float = 4.0) -> Site:
    """Return a mapped site of 4 m behind a machine that looks east."""
    site = Site(1, 1, area_of(((0.0, 0.0), (4.0, 0.0)), width_m))
    map_site(site, BASE, width_m, seed, first_tree=1)
    return site


@given(st.floats(2.0, 9.0), st.floats(-2.6, 2.6), st.floats(0.0, 3.0))
def test_joints_found_for_a_tip_put_it_there_within_their_soft_limits(reach_m: float, turn: float, z_m: float) -> None:
    tip = (-1.8 - reach_m * math.cos(turn), reach_m * math.sin(turn), z_m)
    try:
        pose = pose_for(tip)
    except OutOfReach:
        return
    assert math.dist(tip_of(pose), tip) < 1e-6
    assert not any(is_beyond(joint, pose[joint.name]) for joint in JOINTS)


@given(st.floats(0.01, 0.5), st.integers(0, 50))
def test_no_joint_is_faster_than_its_speed_and_all_arrive_where_they_were_sent(dt_s: float, seed: int) -> None:
    rng, crane = random.Random(seed), Crane()
    goal = {joint.name: rng.uniform(joint.lower, joint.upper) for joint in JOINTS}
    crane.send(goal)
    for _ in range(int(60 / dt_s)):
        before = dict(crane.pose)
        crane.step(dt_s)
        for joint in JOINTS:
            assert abs(crane.pose[joint.name] - before[joint.name]) <= joint.max_rate * dt_s + 1e-6
    assert crane.is_there
    assert crane.pose == pytest.approx(goal)


@pytest.mark.parametrize("seed", range(40))
def test_every_point_is_clear_of_obstacles_reachable_and_no_denser_than_2500_a_hectare(seed: int) -> None:
    site = mapped(f"site/{seed}")
    assert len(site.targets) <= 16.0 * 2500 / 10_000
    for target in site.targets:
        at = (target.x_m, target.y_m)
        assert is_reachable(BASE, at)
        assert all(math.dist(at, (o.x_m, o.y_m)) >= o.radius_m + CLEAR_M - 1e-3 for o in site.obstacles)
        assert 0 <= at[0] <= 4
        assert abs(at[1]) <= 2


def test_obstacles_and_points_follow_from_the_seed() -> None:
    assert mapped("a") == mapped("a")
    assert mapped("a").obstacles != mapped("b").obstacles


def planter_that(tuning: Tuning) -> Rig:
    """Return a planter at work in a long row whose actions fail as ``tuning`` says."""
    rig = Rig(family="planter")
    rig.robot.machine.rig = PlanterRig("failing", tuning)
    rig.robot.boot = rig.robot.power_up()
    rig.start(small_mission(rows=1, length_m=60.0, width_m=4.0))
    return rig


@pytest.mark.slow
def test_what_fails_is_tried_otherwise_and_every_outcome_comes_with_its_code() -> None:
    rig = planter_that(Tuning(fail_dock=0.15, fail_crane=0.2, fail_ground=0.25, fail_scar=0.25))
    wanted = {
        "SAVE_SUCCESS": "done",
        "SAVE_FAIL_SCAR": "failed_tool",
        "SAVE_FAIL_GROUND": "failed_ground",
        "SAVE_FAIL_CRANE": "failed_machine",
    }
    codes: dict[str, str] = {}
    results: set[str] = set()
    for _ in range(300):
        rig.run(5.0)
        codes |= {e.data["code"]: e.data["outcome"] for e in rig.events if "target" in e.data}
        results |= {e.data["result"] for e in rig.events if e.kind == "state_left"}
        rig.events.clear()
        if codes == wanted and "FAIL_DOCK" in results:
            break
    assert codes == wanted
    assert {"OK", "FAIL_DOCK", "FAIL_GROUND", "FAIL_SCAR", "FAIL_CRANE"} <= results


def test_after_three_failed_dockings_it_asks_a_person_and_goes_on_once_the_crane_is_retracted() -> None:
    rig = planter_that(Tuning(fail_dock=1.0))
    until(rig, lambda: rig.boot.brain.hold_code == "ask_person", 300.0)
    assert sum(e.kind == "state_left" and e.data["result"] == "FAIL_DOCK" for e in rig.events) == 3
    assert "wait-person" in [one.id for one in rig.state.active]
    assert rig.do("tool_retract").outcome == "accepted"
    until(rig, lambda: "dock-waypoint" in [one.id for one in rig.state.active], 60.0)


@pytest.mark.slow
def test_a_seedling_still_held_goes_to_the_next_point_without_docking() -> None:
    rig = planter_that(Tuning(fail_dock=0, fail_crane=0, fail_ground=0.5, fail_scar=0))
    rig.run(900.0)
    failed = sum(e.data.get("code") == "SAVE_FAIL_GROUND" for e in rig.events)
    docked = sum(e.kind == "state_entered" and e.data["state"] == "drop" for e in rig.events)
    lowered = sum(e.kind == "state_entered" and e.data["state"] == "on-ground" for e in rig.events)
    assert failed >= 2
    assert docked <= lowered - failed + 1


@pytest.mark.slow
def test_a_new_stop_begins_with_an_empty_surface_and_an_interrupted_one_is_kept() -> None:
    rig = Rig(family="planter")
    rig.start(small_mission(rows=1, length_m=12.0, width_m=4.0))
    until(rig, lambda: rig.boot.reporter.worksite() is not None, 120.0)
    rig.run(100.0)
    first = rig.boot.reporter.worksite()
    assert first is not None
    done = [one.id for one in first.targets if one.status != "planned"]
    rig.stop()
    rig.run(2.0)
    rig.reset()
    rig.run(1.0)
    rig.do("resume")
    rig.run(10.0)
    kept = rig.boot.reporter.worksite()
    assert kept is not None
    assert (kept.stop, [one.id for one in kept.targets if one.status != "planned"]) == (first.stop, done)
    until(rig, lambda: (rig.boot.reporter.worksite() or first).stop > first.stop, 600.0)
    fresh = rig.boot.reporter.worksite()
    assert fresh is not None
    assert {one.status for one in fresh.targets} <= {"planned", "current"}
    assert not {one.id for one in fresh.targets} & {one.id for one in first.targets}


def test_a_scan_is_the_same_again_and_shows_a_person() -> None:
    rig = Rig(family="planter")
    empty = rig.boot.reporter.scan()
    assert empty.points == rig.boot.reporter.scan().points
    rig.robot.set_fault(PersonAhead(distance_m=5.0))
    seen = rig.boot.reporter.scan()
    points = np.frombuffer(base64.b64decode(seen.points), "<i2").reshape(-1, 3) / 100 + np.array(seen.origin)
    person = rig.robot.machine.person
    assert person is not None
    near = np.hypot(points[:, 0] - person[0], points[:, 1] - person[1]) < 0.4
    assert np.ptp(points[near][:, 2]) > 1.0
    assert len(points) <= 4000


def test_the_body_says_tip_load_stock_and_gauges_in_their_scales() -> None:
    rig = Rig(family="planter")
    rig.start(small_mission(rows=1, length_m=12.0, width_m=4.0))
    scales = {one.key: one for one in rig.boot.reporter.factsheet().gauges}
    for _ in range(60):
        rig.run(2.0)
        body = rig.boot.reporter.body()
        assert set(body.gauges) == set(scales)
        assert all(scales[key].lower <= value <= scales[key].upper for key, value in body.gauges.items())
        assert body.stock == rig.robot.machine.seedlings
        assert set(body.joints) == set(body.planned) == set(TRANSPORT)
        assert body.tool is not None


def planted_row(spacing_m: float, length_m: float, pieces: int = 1) -> down.Mission:
    """Return a mission of one row in so many segments, and a way on that the machine has behind the last site."""
    row = small_mission(rows=1, length_m=length_m, width_m=4.0, plant_spacing_m=spacing_m)
    ends = [(0.0, length_m * k / pieces) for k in range(pieces + 1)]
    rows = [
        down.Segment(kind="row", points=[a, b], speed_mps=1.0, tool_on=True, row=1) for a, b in itertools.pairwise(ends)
    ]
    beyond = down.Segment(kind="exit", points=[ends[-1], (0.0, length_m + 8.0)], speed_mps=1.0)
    return msgspec.structs.replace(row, segments=[row.segments[0], *rows, beyond])


@pytest.mark.parametrize("pieces", [1, 3])
@pytest.mark.parametrize("spacing_m", [0.5, 2.0, 4.0, 7.0])
def test_plants_stand_as_far_apart_as_the_mission_says_however_the_row_is_cut(spacing_m: float, pieces: int) -> None:
    run = MissionRun(planted_row(spacing_m, 40.0, pieces), EnuFrame(LAT, LON), (0.0, -2.0), FAMILIES["planter"])
    stops, plants, s_m = Stops(run), [], 0.0
    assert stops.trees_left(0.0) == math.floor(40.0 / spacing_m + 0.5)
    while (one := stops.next(s_m, set())) is not None:
        plants += one.plants_m
        s_m = one.stop_m + 0.01
    assert len(plants) == math.floor(40.0 / spacing_m + 0.5)
    assert np.diff(plants) == pytest.approx(spacing_m)
    assert plants[0] == pytest.approx(2.0 + spacing_m / 2), "two metres of way before the row"


def test_a_site_in_line_has_its_plants_on_the_row() -> None:
    site = Site(1, 1, area_of(((0.0, 0.0), (4.0, 0.0)), 4.0))
    line = Stretch(1, 10.0, 14.0, 18.0, (10.5, 11.5, 12.5, 13.5), 1.0)
    map_site(site, BASE, 4.0, "clear", first_tree=1, line=line)
    free = [one for one in site.targets if abs(one.y_m) < 0.01]
    assert {round(one.x_m, 2) for one in free} <= {0.5, 1.5, 2.5, 3.5}
    assert len(site.targets) >= 3


@pytest.mark.slow
@pytest.mark.parametrize("spacing_m", [1.0, 4.0])
def test_a_planter_plants_as_far_apart_as_it_was_told(spacing_m: float) -> None:
    rig = Rig(family="planter")
    rig.robot.machine.rig = PlanterRig("spaced", FAILS_NEVER)
    rig.robot.boot = rig.robot.power_up()
    rig.start(planted_row(spacing_m, 16.0))
    until(rig, lambda: rig.state.order is not None and rig.state.order.status == "done", 3600.0)
    assert rig.robot.machine.rig.trees == round(16.0 / spacing_m)

"""Ways over lanes on which a machine cannot turn round: a planter of 6.4 m that steers, on farm roads."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, Polygon

from hmi.domain.mission_plan import PlanRefused
from hmi.planning.bent_way import BentWay
from hmi.planning.coverage import plan_coverage
from hmi.planning.ground import Ground
from hmi.planning.job import Job
from hmi.planning.lanes import Lanes
from hmi.planning.links import Linker
from hmi.planning.machine import RobotProfile
from hmi.planning.path_check import check_path
from hmi.planning.plan import GENTLE_RAD, LegKind, headings
from hmi.planning.projection import Floats
from tests.hmi.planning.grounds import square

STEERS = RobotProfile(
    length_m=6.4, width_m=2.6, base_to_front_m=4.0, turning_radius_m=5.0, can_pivot=False, row_speed_mps=0.8
)
PIVOTS = RobotProfile(length_m=6.4, width_m=2.6, base_to_front_m=4.0, turning_radius_m=1.0, can_pivot=True)
HOME = (-60.0, -60.0)
YARD = shapely.box(-75, -75, -50, -50)


def _lane(width_m: float, *, gate_y: float = 30.0) -> Polygon:
    """Return a lane with two right angles from the yard to the field's west side."""
    return LineString([(-62, -60), (-20, -60), (-20, gate_y), (4, gate_y)]).buffer(width_m / 2, join_style="mitre")


def _job(width_m: float, machine: RobotProfile = STEERS) -> Job:
    roads = shapely.union_all([YARD, _lane(width_m)])
    return Job(square(80), 3.0, machine, home=HOME, roads=roads, returns_home=True)


def _is_driven(line: Floats, radius_m: float) -> bool:
    """Say whether no bend is tighter than the radius: three points of an arc tell it."""
    turned = np.abs(np.remainder(np.diff(headings(line)) + math.pi, 2 * math.pi) - math.pi)
    steps = np.hypot(*np.diff(line, axis=0).T)
    tight = turned > np.minimum(steps[:-1], steps[1:]) / radius_m * 1.05 + math.radians(6)
    return not tight.any() and float(turned.max(initial=0.0)) < math.radians(15)


@pytest.mark.parametrize("width_m", [5.0, 6.0, 8.0])
def test_a_long_machine_that_steers_takes_the_lane_to_its_field_and_back(width_m: float) -> None:
    job = _job(width_m)
    plan = plan_coverage(job)
    assert not any("No known way" in note for note in plan.notes)
    for kind in (LegKind.APPROACH, LegKind.EXIT):
        legs = [leg for leg in plan.legs if leg.kind is kind]
        assert legs
        assert all(_is_driven(leg.points, STEERS.turning_radius_m) for leg in legs)
    assert plan.legs[0].points[0] == pytest.approx(HOME)
    assert plan.legs[-1].points[-1] == pytest.approx(HOME)
    ground = Ground(shapely.union_all([job.parcel, job.roads]), STEERS)
    assert sum(ground.outside_m(leg.points) for leg in plan.legs) == 0
    check_path(job, job.parcel, plan.legs)


def test_a_machine_that_turns_on_the_spot_takes_a_lane_narrower_than_its_diagonal() -> None:
    job = _job(5.0, PIVOTS)
    plan = plan_coverage(job)
    ways = [leg for leg in plan.legs if leg.kind in (LegKind.APPROACH, LegKind.EXIT)]
    ground = Ground(shapely.union_all([job.parcel, job.roads]), PIVOTS)
    assert ways
    assert sum(ground.outside_m(leg.points) for leg in ways) == 0


def test_a_lane_too_narrow_for_the_machine_is_told_with_both_widths() -> None:
    with pytest.raises(PlanRefused, match=r"is 2\.0 m wide where it is narrowest, and this machine needs 2\.8 m") as no:
        plan_coverage(_job(2.0))
    assert (no.value.code, no.value.field) == ("home_unreachable", "home_id")


def test_a_bend_too_tight_for_the_machine_is_told_with_its_radius() -> None:
    with pytest.raises(PlanRefused, match=r"a bend or a corner too tight .* a radius of 5\.0 m"):
        plan_coverage(_job(3.2))


def test_a_bent_lane_of_many_corners_is_followed_as_one_line() -> None:
    angles = np.linspace(0, math.pi, 40)
    bent = LineString([(-20 - 30 * math.sin(a), -30 + 30 * -math.cos(a)) for a in angles] + [(5, 0)]).buffer(2.5)
    ground = Ground(shapely.union_all([shapely.box(0, -30, 60, 30), bent, shapely.Point(-20, -60).buffer(6)]), STEERS)
    way = Lanes(Linker(ground)).from_place((-20.0, -60.0), (20.0, 5.0, 0.0))
    assert way is not None
    assert len(way) == 1
    assert _is_driven(way[0], STEERS.turning_radius_m)
    assert ground.outside_m(way[0]) == 0


@given(
    width_m=st.floats(3.0, 9.0),
    corner=st.floats(-100, 100),
    reach_m=st.floats(25, 60),
    radius_m=st.sampled_from([0.5, 3.0, 5.0, 7.0]),
)
@settings(max_examples=12, deadline=None)
def test_whatever_way_is_found_stays_on_the_ground_and_can_be_steered(
    width_m: float, corner: float, reach_m: float, radius_m: float
) -> None:
    assume(abs(corner) > 5)
    bend = math.radians(corner)
    end = (-5.0 - reach_m * math.cos(bend), 30.0 + reach_m * math.sin(bend))
    lane = LineString([end, (-5.0, 30.0), (5.0, 30.0)]).buffer(width_m / 2)
    machine = RobotProfile(5.0, 2.2, 3.0, turning_radius_m=radius_m, can_pivot=False)
    ground = Ground(shapely.union_all([square(60), lane, shapely.Point(end).buffer(4)]), machine)
    for way in (
        Lanes(Linker(ground)).from_place(end, (20.0, 20.0, 0.0)),
        Lanes(Linker(ground)).to_place((20.0, 20.0, 0.0), end),
    ):
        if way is None:
            assert width_m < 8 or abs(corner) > 60
            continue
        assert len(way) == 1
        assert ground.outside_m(way[0]) == 0
        assert _is_driven(way[0], radius_m)


def test_where_two_pieces_meet_in_a_corner_it_turns_on_the_spot_between_them() -> None:
    machine = RobotProfile(3.75, 1.86, 1.875, turning_radius_m=4.0, can_pivot=True)
    lane = LineString([(0, 0), (15, 0)]).buffer(1.23)
    road = LineString([(13, 0), (15, 0), (15.45, -9.7), (7.29, -10.16)]).buffer(2.66)
    ground = Ground(shapely.union_all([shapely.Point(0, 0).buffer(2.4), lane, road]), machine)
    end = (7.29, -10.16, -1.357)
    for way in (Lanes(Linker(ground)).from_place((0.0, 0.0), end), Lanes(Linker(ground)).to_place(end, (0.0, 0.0))):
        assert way is not None
        assert max(float(np.abs(np.diff(np.unwrap(headings(line)))).max(initial=0.0)) for line in way) <= GENTLE_RAD
        assert all(math.dist(a[-1], b[0]) < 0.02 for a, b in pairwise(way))
        assert sum(ground.outside_m(line) for line in way) == 0


def test_a_corner_too_tight_behind_many_roomy_ones_is_given_up_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    machine, asked, fits = RobotProfile(), [0], Ground.fits

    def counted(self: Ground, points: Floats, *, is_crop_free: bool = False, is_backward: bool = False) -> bool:
        asked[0] += 1
        assert asked[0] < 3000
        return fits(self, points, is_crop_free=is_crop_free, is_backward=is_backward)

    zigzag = [(12.0 * k, 5.0 * (k % 2)) for k in range(21)]
    (x, y), tight = zigzag[-1], (zigzag[-1][0] + 20, zigzag[-1][1])
    wide = LineString(zigzag).buffer(3, join_style="mitre", cap_style="flat")
    lane = LineString([(x - 1, y), tight, (x + 20, y + 25)]).buffer(1, join_style="mitre")
    ground = Ground(shapely.union_all([wide, lane]), machine)
    monkeypatch.setattr(Ground, "fits", counted)
    way = np.array([*zigzag, tight, (x + 20, y + 25)])
    assert BentWay(Linker(ground), way, machine.turning_radius_m).pieces() is None

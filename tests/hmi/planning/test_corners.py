"""Corners of laps, worked to their tips."""

from __future__ import annotations

import math

import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from shapely.geometry import Polygon

from hmi.domain.mission_plan import Pattern
from hmi.planning.coverage import plan_coverage
from hmi.planning.job import Job
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import Leg, LegKind, Plan
from hmi.planning.treatment import EVERYWHERE, DoseMap
from tests.hmi.planning.grounds import assert_drivable, square, union_of, worked_strips
from tests.hmi.planning.test_properties import SLACK_RAD, drives, fields_with_holes, planned, sharpest_excess_rad

TRACKED = RobotProfile(turning_radius_m=1.5)
WHEELED = RobotProfile(turning_radius_m=1.5, can_pivot=False)
ROOM = square(60)


def regular(corners: int, radius_m: float) -> Polygon:
    """Return a field with equal sides."""
    turns = [2 * math.pi * k / corners for k in range(corners)]
    return Polygon([(radius_m * math.cos(turn), radius_m * math.sin(turn)) for turn in turns])


def loops(plan: Plan) -> list[Leg]:
    """Return the ways from one side of a lap to the next with the tool off."""
    return [leg for leg in plan.legs if leg.kind is LegKind.HEADLAND and not leg.tool_on]


def reached(job: Job, plan: Plan) -> float:
    """Return the share that is worked of the ground behind the round corners of the outermost lap."""
    radius = job.machine.turning_radius_m
    reachable = job.parcel.buffer(-(1.5 + radius)).buffer(radius).buffer(1.5).intersection(job.parcel)
    return float(union_of(worked_strips(plan.legs, job.width_m)).intersection(reachable).area / reachable.area)


def test_the_square_of_twenty_metres_is_worked_to_ninety_nine_of_a_hundred() -> None:
    job = Job(square(20), 3.0, TRACKED)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert reached(job, plan) >= 0.99
    assert plan.figures.overlap_m2 <= 0.0201 * plan.figures.area_m2


def test_a_blunt_corner_is_worked_to_its_tip_and_no_further() -> None:
    job = Job(regular(5, 14), 3.0, TRACKED)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert loops(plan)
    assert reached(job, plan) >= 0.985
    laps = worked_strips([leg for leg in plan.legs if leg.kind is LegKind.HEADLAND], 3.0)
    turn = 2 * math.pi / 5
    # where the next side begins on its outer edge the first one may end: two triangles are worked twice
    beyond_m = 1.5 * (math.tan(turn / 2) * math.cos(turn) + math.sin(turn) - math.tan(turn / 2))
    twice_m2 = 4.5 * math.sin(turn) * math.cos(turn) + beyond_m**2 * math.tan(turn) / 2
    assert sum(strip.area for strip in laps) - union_of(laps).area <= len(loops(plan)) * 1.05 * twice_m2


def test_a_round_field_is_not_worked_twice_for_its_many_blunt_corners() -> None:
    job = Job(shapely.Point(0, 0).buffer(13.6257, quad_segs=3), 3.0, TRACKED)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert reached(job, plan) >= 0.985
    assert plan.figures.overlap_m2 <= 0.06 * plan.figures.area_m2


def test_a_machine_that_cannot_turn_on_the_spot_drives_a_loop_in_each_corner() -> None:
    job = Job(ROOM, 3.0, WHEELED)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert plan.figures.pivots == 0
    assert len(loops(plan)) >= 4
    assert all(leg.length_m > math.pi * 1.5 for leg in loops(plan))
    # what stays are the tips beyond the outermost lap, which no machine reaches
    tips = ROOM.area - ROOM.buffer(-3).buffer(3).area
    assert plan.figures.missed_m2 <= tips + 1


def test_where_no_loop_fits_a_tracked_machine_turns_on_the_spot_and_says_so() -> None:
    field = ROOM.difference(shapely.box(25, 25, 33, 33))
    assert isinstance(field, Polygon)
    job = Job(field, 3.0, TRACKED)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert any(leg.pivot for leg in loops(plan))
    softly = plan_coverage(Job(field, 3.0, TRACKED, pattern=Pattern.SKIP_ROWS))
    assert not any(leg.pivot for leg in loops(softly)), "that order is chosen for arcs in place of turns on the spot"


def test_tips_that_are_not_to_be_treated_are_driven_round() -> None:
    only_middle = DoseMap(((shapely.box(15, 0, 45, 60), 1.0),), rest=0.0)
    corner = shapely.box(0, 0, 9, 9)

    def driven_m(doses: DoseMap) -> float:
        legs = plan_coverage(Job(ROOM, 3.0, TRACKED, doses=doses)).legs
        return sum(shapely.LineString(leg.points).intersection(corner).length for leg in legs)

    assert driven_m(only_middle) < driven_m(EVERYWHERE) - 8


def test_a_narrow_tool_leaves_tips_that_no_loop_is_worth() -> None:
    assert loops(plan_coverage(Job(square(20), 0.5, RobotProfile()))) == []


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(fields_with_holes())
@pytest.mark.long
def test_loops_stay_inside_and_bend_no_tighter_than_the_machine(field: Polygon) -> None:
    for machine in (TRACKED, WHEELED):
        job = Job(field, 3.0, machine)
        plan = planned(job)
        if plan is None:
            continue
        assert_drivable(job, plan)
        assert all(sharpest_excess_rad(points, 1.5) <= SLACK_RAD for points in drives(plan))

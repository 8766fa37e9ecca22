"""What holds for every plan: the outline stays inside, rows are driven once, the path can be steered."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import Polygon

from hmi.domain.mission_plan import PlanRefused
from hmi.planning.coverage import plan_coverage
from hmi.planning.job import Job
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import Leg, LegKind, Plan
from tests.hmi.planning.grounds import (
    convex_fields,
    crooked_fields,
    ground_of,
    metres_outside,
    pivots_without_room,
    undeclared_jumps,
    union_of,
    widest_gap_m,
    worked_strips,
)

MACHINES = (
    RobotProfile(turning_radius_m=1.5),
    RobotProfile(length_m=1.2, width_m=0.8, base_to_front_m=0.7, turning_radius_m=0.5),
    RobotProfile(length_m=3.0, width_m=1.5, base_to_front_m=2.4, turning_radius_m=2.0, can_pivot=False),
)
FAIR = ("field_too_small", "turn_does_not_fit", "no_way")
SLACK_RAD = math.radians(4)  # half a piece: arcs are sampled every 8 degrees


@st.composite
def fields_with_holes(draw: st.DrawFn) -> Polygon:
    """Draw fields of about a hectare with one to four holes of any kind, also ones that touch the border."""
    field = draw(st.one_of(convex_fields(), crooked_fields()))
    left, low, right, high = field.bounds
    for _ in range(draw(st.integers(1, 4))):
        x = left + draw(st.floats(0.1, 0.9)) * (right - left)
        y = low + draw(st.floats(0.1, 0.9)) * (high - low)
        size = draw(st.floats(0.3, 8))
        hole = shapely.box(-size, -size * draw(st.floats(0.2, 1)), size, size)
        turned = affinity.translate(affinity.rotate(hole, draw(st.floats(0, 90))), x, y)
        rest = field.difference(turned)
        if isinstance(rest, Polygon) and rest.area > 150:
            field = rest
    return field


fields = st.one_of(convex_fields(), crooked_fields(), fields_with_holes())
jobs = st.builds(Job, fields, st.sampled_from([0.5, 1.5, 3.0]), st.sampled_from(MACHINES))


def planned(job: Job) -> Plan | None:
    """Return the plan; ``None`` if the field is refused for a reason that small and narrow fields have."""
    try:
        return plan_coverage(job)
    except PlanRefused as refused:
        if refused.code in FAIR:
            return None
        raise


def drives(plan: Plan) -> list[np.ndarray]:
    """Return the path in pieces as they are driven without turning on the spot."""
    pieces: list[list[Leg]] = []
    for leg in plan.legs:
        if leg.pivot or not pieces:
            pieces.append([])
        pieces[-1].append(leg)
    return [np.vstack([legs[0].points[:1], *(leg.points[1:] for leg in legs)]) for legs in pieces]


def sharpest_excess_rad(points: np.ndarray, radius_m: float) -> float:
    """Return by how much the path turns, over any stretch of it, more than its radius allows."""
    steps = np.diff(points, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    turns = np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(steps[:, 1], steps[:, 0])))))
    if not len(turns) or radius_m <= 0:
        return 0.0
    # between the middles of straight pieces: what is turned, less what may be turned
    middles = np.cumsum(lengths) - lengths / 2
    excess = np.append(0.0, np.cumsum(turns)) - middles / radius_m
    return float((excess - np.minimum.accumulate(excess)).max())


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(jobs)
@pytest.mark.slow
def test_a_plan_stays_inside_can_be_steered_drives_each_row_once_and_adds_up(job: Job) -> None:
    plan = planned(job)
    if plan is None:
        return
    assert_inside(job, plan)
    assert_steerable(job, plan)
    assert_rows_driven_once(job, plan)
    assert_figures_add_up(job, plan)


def assert_inside(job: Job, plan: Plan) -> None:
    """Assert that the outline never leaves the field, turning on the spot included."""
    field = ground_of(job)
    assert metres_outside(field, job.machine, plan, 0.07) == 0
    assert pivots_without_room(field, job.machine, plan) == []


def assert_steerable(job: Job, plan: Plan) -> None:
    """Assert one line without gaps, bent no tighter than the turning radius but at declared turns on the spot."""
    assert widest_gap_m(plan) < 1e-6
    assert undeclared_jumps(plan) == []
    assert job.machine.can_pivot or not any(leg.pivot for leg in plan.legs)
    for points in drives(plan):
        assert sharpest_excess_rad(points, job.machine.turning_radius_m) <= SLACK_RAD


def assert_rows_driven_once(job: Job, plan: Plan) -> None:
    """Assert that no ground is worked by two rows, and that rows and laps leave nothing of the inner field."""
    rows = [leg for leg in plan.legs if leg.kind is LegKind.ROW]
    assert [leg.row for leg in rows] == list(range(1, len(rows) + 1))
    strips = worked_strips(rows, job.width_m)
    assert sum(strip.area for strip in strips) == pytest.approx(union_of(strips).area, rel=0.002)
    figures = plan.figures
    if not plan.notes and figures.inner_m2 > 50 * job.width_m:
        # tips that no row of a metre fits into; five of them are much of a star of a tenth of a hectare
        tips = 0.03 if figures.inner_m2 > 1000 else 0.06
        assert figures.inner_covered_m2 >= (1 - tips) * figures.inner_m2


def assert_figures_add_up(job: Job, plan: Plan) -> None:
    """Assert that the plan's numbers are those of its path."""
    figures = plan.figures
    covered = union_of(worked_strips(plan.legs, job.width_m)).intersection(ground_of(job))
    assert figures.covered_m2 == pytest.approx(covered.area, rel=0.002)
    assert figures.length_m == pytest.approx(sum(leg.length_m for leg in plan.legs))
    assert figures.pivots == sum(leg.pivot for leg in plan.legs)
    assert figures.overlap_m2 >= 0

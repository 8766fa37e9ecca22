"""Row orders that a person may choose."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from hmi.domain.mission_plan import Corner, Pattern
from hmi.planning.coverage import plan_coverage
from hmi.planning.job import Job
from hmi.planning.machine import RobotProfile
from hmi.planning.patterns import lands, row_by_row, skip_rows, span_for
from hmi.planning.plan import LegKind
from tests.hmi.planning.grounds import assert_drivable, convex_fields, crooked_fields, given_field, square
from tests.hmi.planning.test_properties import MACHINES, assert_rows_driven_once, assert_steerable, planned

CHOSEN = (Pattern.ROW_BY_ROW, Pattern.SKIP_ROWS, Pattern.SPIRAL)
counts = st.integers(1, 200)
spans = st.integers(2, 9)


@given(counts, spans, st.sampled_from([row_by_row, skip_rows, lands]))
def test_every_row_has_its_turn_once(count: int, span: int, order: object) -> None:
    assert sorted(order(count, span)) == list(range(count))  # type: ignore[operator]


@given(st.integers(5, 200), spans)
def test_skipped_rows_are_never_nearer_than_a_wide_turn_where_there_are_enough(count: int, span: int) -> None:
    steps = [abs(b - a) for a, b in pairwise(skip_rows(count, span))]
    assert min(steps) >= (span if count >= 2 * span + 1 else max(1, count // 2 - 1))
    assert max(steps) <= max(count // 2, 6 * span + 3), "no way across the whole field between two rows"


@given(counts, spans)
def test_a_land_is_worked_from_its_edges_to_its_middle(count: int, span: int) -> None:
    order = lands(count, span)
    assert order[0] == 0
    if count > 1 and round(count / max(8, 5 * span)) <= 1:
        assert order[1] == count - 1
        assert abs(order[-1] - order[-2]) == 1


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.one_of(convex_fields(), crooked_fields()),
    st.sampled_from([1.5, 3.0]),
    st.sampled_from(MACHINES),
    st.sampled_from(CHOSEN),
    st.none() | st.sampled_from(list(Corner)),
)
@pytest.mark.slow
def test_a_chosen_order_stays_inside_can_be_steered_and_drives_each_row_once(
    field: Polygon, width: float, machine: RobotProfile, pattern: Pattern, corner: Corner | None
) -> None:
    job = Job(field, width, machine, pattern=pattern, corner=corner)
    plan = planned(job)
    if plan is None:
        return
    assert_drivable(job, plan)
    assert_steerable(job, plan)
    assert_rows_driven_once(job, plan)


@pytest.mark.parametrize("pattern", CHOSEN)
def test_the_parcel_is_worked_as_well_in_every_order(pattern: Pattern) -> None:
    job = Job(given_field("nl-parcel"), 3.0, RobotProfile(turning_radius_m=1.5), pattern=pattern)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert plan.figures.rows == 131
    assert plan.figures.inner_covered_m2 >= 0.999 * plan.figures.inner_m2


@pytest.mark.parametrize(
    ("corner", "east", "north"),
    [
        (Corner.NORTH_WEST, False, True),
        (Corner.NORTH_EAST, True, True),
        (Corner.SOUTH_WEST, False, False),
        (Corner.SOUTH_EAST, True, False),
    ],
)
@pytest.mark.parametrize("pattern", list(Pattern))
def test_the_rows_begin_in_the_chosen_corner(pattern: Pattern, corner: Corner, east: bool, north: bool) -> None:
    plan = plan_coverage(Job(square(60), 3.0, RobotProfile(), angle_rad=0.0, pattern=pattern, corner=corner))
    x, y = next(leg for leg in plan.legs if leg.kind is LegKind.ROW).points[0]
    assert (x > 30, y > 30) == (east, north)


def test_row_by_row_sweeps_around_a_hole_without_going_back() -> None:
    field = square(90).difference(shapely.box(40, 40, 50, 50))
    assert isinstance(field, Polygon)
    plan = plan_coverage(Job(field, 3.0, RobotProfile(), angle_rad=0.0, pattern=Pattern.ROW_BY_ROW))
    heights = [float(leg.points[0][1]) for leg in plan.legs if leg.kind is LegKind.ROW]
    below = [y for y in heights if y < 33]
    above = [y for y in heights if y > 57]
    assert heights[: len(below)] == sorted(below)
    assert heights[-len(above) :] == sorted(above)


def test_wide_turns_need_no_turn_on_the_spot() -> None:
    machine = RobotProfile(turning_radius_m=1.0)
    tight = plan_coverage(Job(square(80), 1.0, machine, pattern=Pattern.ROW_BY_ROW)).figures
    wide = plan_coverage(Job(square(80), 1.0, machine, pattern=Pattern.SKIP_ROWS)).figures
    assert span_for(machine, 1.0) == 2
    assert wide.pivots < tight.pivots / 4
    assert wide.covered_m2 >= 0.99 * tight.covered_m2


def test_rows_lie_closer_where_they_shall_overlap() -> None:
    apart = plan_coverage(Job(square(60), 3.0, RobotProfile())).figures
    lapped = plan_coverage(Job(square(60), 2.4, RobotProfile(), tool_width_m=3.0)).figures
    assert lapped.rows > apart.rows
    assert lapped.overlap_m2 == pytest.approx(0.2 / 0.8 * lapped.area_m2, rel=0.15)
    assert np.isclose(lapped.covered_m2, lapped.area_m2, rtol=0.03)

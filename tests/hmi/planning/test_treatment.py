"""Where the tool works."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from hmi.domain.mission_plan import PlanRefused
from hmi.planning.coverage import plan_coverage
from hmi.planning.job import Job
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import Leg, LegKind, Plan
from hmi.planning.treatment import DoseMap
from tests.hmi.planning.grounds import (
    convex_fields,
    metres_outside,
    square,
    undeclared_jumps,
    union_of,
    widest_gap_m,
    worked_strips,
)
from tests.hmi.planning.test_properties import planned

ROW = Leg(LegKind.ROW, np.array([[0.0, 0.0], [100.0, 0.0]]), 0.4, tool_on=True, row=7)
MIDDLE = shapely.box(40, -5, 60, 5)


def told(pieces: list[Leg]) -> list[tuple[float, float, bool, float]]:
    """Return from, to, on and dose of each piece of a row along x."""
    return [(round(float(p.points[0][0]), 3), round(float(p.points[-1][0]), 3), p.tool_on, p.dose) for p in pieces]


def test_the_tool_goes_off_after_the_border_and_on_before_it() -> None:
    doses = DoseMap(((MIDDLE, 0.0),), lead_in_m=2.0, lead_out_m=0.5)
    assert told(doses.cut([ROW])) == [(0, 40.5, True, 1), (40.5, 58, False, 1), (58, 100, True, 1)]


@pytest.mark.parametrize("short_m", [0.0, 0.05, 0.09, 0.2])
def test_a_row_keeps_its_ends_whatever_is_off_there(short_m: float) -> None:
    # the tool goes off short of the end by less than is worth a piece of its own, and at the beginning alike
    off = shapely.box(99.5 - short_m, -5, 200, 5).union(shapely.box(-200, -5, 2.0 + short_m, 5))
    pieces = DoseMap(((off, 0.0),), lead_in_m=2.0, lead_out_m=0.5).cut([ROW])
    assert pieces[0].points[0].tolist() == [0.0, 0.0]
    assert pieces[-1].points[-1].tolist() == [100.0, 0.0]
    assert all(np.array_equal(a.points[-1], b.points[0]) for a, b in pairwise(pieces))


def test_only_the_area_is_treated_where_the_rest_is_off() -> None:
    doses = DoseMap(((MIDDLE, 1.0),), rest=0.0, lead_in_m=2.0, lead_out_m=0.5)
    assert told(doses.cut([ROW])) == [(0, 38, False, 1), (38, 60.5, True, 1), (60.5, 100, False, 1)]


def test_between_two_doses_the_border_is_exact_and_more_takes_longer() -> None:
    pieces = DoseMap(((MIDDLE, 2.0),), lead_in_m=2.0, lead_out_m=0.5).cut([ROW])
    assert told(pieces) == [(0, 40, True, 1), (40, 60, True, 2), (60, 100, True, 1)]
    assert [piece.speed_mps for piece in pieces] == [0.4, 0.2, 0.4]
    assert [piece.is_continued for piece in pieces] == [False, True, True]
    assert all(piece.row == 7 for piece in pieces)


def test_a_gap_shorter_than_the_leads_is_worked_through() -> None:
    narrow = shapely.box(49, -5, 51, 5)
    pieces = DoseMap(((narrow, 0.0),), lead_in_m=2.0, lead_out_m=0.5).cut([ROW])
    assert all(piece.tool_on for piece in pieces)
    assert sum(piece.length_m for piece in pieces) == pytest.approx(100)


def test_the_area_named_last_wins() -> None:
    doses = DoseMap(((MIDDLE, 0.0), (shapely.box(50, -5, 60, 5), 0.5)))
    assert told(doses.cut([ROW])) == [(0, 40, True, 1), (40, 50, False, 1), (50, 60, True, 0.5), (60, 100, True, 1)]


def test_rows_in_ground_that_is_off_are_not_driven() -> None:
    field, half = square(60), shapely.box(0, 30, 60, 60)
    whole = plan_coverage(Job(field, 3.0, RobotProfile(), angle_rad=0.0)).figures
    plan = plan_coverage(Job(field, 3.0, RobotProfile(), angle_rad=0.0, doses=DoseMap(((half, 0.0),))))
    assert plan.figures.rows < 0.65 * whole.rows
    assert plan.figures.wanted_m2 == pytest.approx(1800)
    assert plan.figures.missed_m2 < 0.05 * 1800
    assert plan.figures.energy_j < 0.7 * whole.energy_j


def test_a_field_without_ground_to_treat_is_refused() -> None:
    with pytest.raises(PlanRefused) as refused:
        plan_coverage(Job(square(60), 3.0, RobotProfile(), doses=DoseMap(((square(60).buffer(9), 0.0),))))
    assert (refused.value.code, refused.value.field) == ("nothing_to_treat", "treatment")


def planned_if_wanted(job: Job) -> Plan | None:
    """Return the plan; ``None`` if nothing is to be treated or the field is too small."""
    try:
        return planned(job)
    except PlanRefused as refused:
        if refused.code == "nothing_to_treat":
            return None
        raise


circles = st.builds(
    lambda x, y, r: shapely.Point(x, y).buffer(r), st.floats(-40, 40), st.floats(-40, 40), st.floats(1, 30)
)


@pytest.mark.slow
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    convex_fields(),
    st.lists(st.tuples(circles, st.sampled_from([0.0, 0.5, 1.0, 2.0])), max_size=3),
    st.sampled_from([0.0, 1.0]),
    st.floats(0, 1),
)
def test_the_tool_is_on_where_it_is_wanted_and_off_beyond_its_lead(
    field: Polygon, areas: list[tuple[Polygon, float]], rest: float, lead_m: float
) -> None:
    doses = DoseMap(tuple(areas), rest, lead_m, lead_m)
    job = Job(field, 3.0, RobotProfile(turning_radius_m=1.5), doses=doses)
    plan = planned_if_wanted(job)
    if plan is None:
        return
    assert metres_outside(field, job.machine, plan) == 0
    assert undeclared_jumps(plan) == []
    assert widest_gap_m(plan) < 1e-6
    wanted = doses.wanted(field.buffer(9))
    worked = union_of(worked_strips(plan.legs, 3.0)).buffer(0.01)
    for leg in plan.legs:
        line = shapely.LineString(leg.points)
        if leg.tool_on:
            assert line.difference(wanted.buffer(lead_m + 0.3)).length < 0.3 + 2 * lead_m
        elif leg.kind in (LegKind.ROW, LegKind.HEADLAND):
            # the loop in the corner of a lap leads over ground that is worked along its sides; where a border runs
            # askew between them, their square ends leave some of it
            some_m = job.width_m / 2 if leg.is_continued else 0.3
            assert line.intersection(wanted.buffer(-0.2)).difference(worked).length < some_m
    rows = [leg.row for leg in plan.legs if leg.row]
    assert all(b - a in (0, 1) for a, b in pairwise(rows))

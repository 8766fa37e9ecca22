"""Rows along a drawn line: parallel, coverable, never tighter than the robot turns, and said where they cannot be."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from hmi.domain.mission_plan import PlanRefused, Rows
from hmi.planning.coverage import plan_coverage
from hmi.planning.ground import erode
from hmi.planning.guide import parallels
from hmi.planning.job import Job
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import LegKind, Plan, headings
from hmi.planning.projection import Floats
from hmi.planning.recorded import CropRow
from hmi.planning.swaths import edge_angle
from hmi.planning.treatment import DoseMap
from tests.hmi.planning.grounds import assert_drivable, crooked_fields, square, union_of, worked_strips
from tests.hmi.planning.lines import guides, wave
from tests.hmi.planning.test_properties import FAIR, MACHINES, assert_steerable, fields

SIDE_M = 60.0
ROUND = RobotProfile(turning_radius_m=1.5)
WHEELED = RobotProfile(turning_radius_m=1.5, can_pivot=False)
UNFIT = (*FAIR, "guide_too_tight", "bad_guide", "no_rows")


def along(line: Floats, field: Polygon | None = None, machine: RobotProfile = ROUND, **more: Any) -> Job:
    """Return a job whose rows follow a line."""
    guide = CropRow("Guide", line)
    return Job(field or square(SIDE_M), 3.0, machine, rows=Rows.GUIDE_LINE, lines=(guide,), **more)


def rows_of(plan: Plan) -> list[Floats]:
    return [leg.points for leg in plan.legs if leg.kind is LegKind.ROW]


@pytest.mark.parametrize("machine", [ROUND, WHEELED])
def test_rows_run_side_by_side_along_a_curved_line_and_the_turns_join_them(machine: RobotProfile) -> None:
    line = wave(-5.0, 65.0, 25.0)
    job = along(line, machine=machine)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert_steerable(job, plan)
    rows = rows_of(plan)
    assert len(rows) >= 15
    guide = shapely.LineString(line)
    for row in rows:
        inside = [p for p in shapely.points(row) if 0 < guide.project(p) < guide.length]
        widths = shapely.distance(inside, guide) / 3.0
        assert np.abs(widths - round(float(widths.mean()))).max() < 0.05, "a whole number of widths from the line"
    figures = plan.figures
    assert figures.inner_covered_m2 >= 0.99 * figures.inner_m2
    assert figures.covered_m2 == pytest.approx(
        union_of(worked_strips(plan.legs, 3.0)).intersection(job.parcel).area, rel=0.001
    )


def test_the_line_itself_is_a_row() -> None:
    line = wave(-5.0, 65.0, 25.0)
    drawn, plan = shapely.LineString(line), plan_coverage(along(line))
    assert min(float(shapely.distance(shapely.points(row), drawn).max()) for row in rows_of(plan)) < 0.08


def test_a_line_that_ends_inside_the_field_is_drawn_on_straight() -> None:
    figures = plan_coverage(along(wave(15.0, 45.0, 25.0))).figures
    assert figures.inner_covered_m2 >= 0.985 * figures.inner_m2


def test_a_line_along_the_edge_serves_the_whole_field() -> None:
    figures = plan_coverage(along(np.array([[0.5, 0.5], [30.0, 3.0], [59.5, 0.5]]))).figures
    assert figures.inner_covered_m2 >= 0.985 * figures.inner_m2


def test_a_hole_cuts_rows_and_is_never_touched() -> None:
    field = square(SIDE_M).difference(shapely.Point(30, 30).buffer(4))
    assert isinstance(field, Polygon)
    job = along(wave(-5.0, 65.0, 25.0), field)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert len(rows_of(plan)) > len(rows_of(plan_coverage(along(wave(-5.0, 65.0, 25.0)))))


def test_a_small_corner_of_the_line_is_rounded_and_said() -> None:
    bent = np.array([[-5.0, 20.0], [30.0, 20.0], [65.0, 45.0]])  # 35 degrees
    plan = plan_coverage(along(bent, machine=replace(WHEELED, turning_radius_m=4.0)))
    assert any("straighter than the guide line asks" in note for note in plan.notes)
    assert_steerable(along(bent, machine=replace(WHEELED, turning_radius_m=4.0)), plan)


def test_a_corner_no_robot_follows_is_refused_with_its_place() -> None:
    sharp = np.array([[-5.0, 10.0], [40.0, 30.0], [-5.0, 50.0]])
    with pytest.raises(PlanRefused, match=r"tighter than .* 1\.5 m: 49 m along the guide line") as refused:
        plan_coverage(along(sharp))
    assert refused.value.field == "rows"
    assert "Draw the guide line straighter there" in refused.value.text


@pytest.mark.parametrize(
    ("line", "code"),
    [
        (np.array([[10.0, 10.0], [50.0, 50.0], [50.0, 10.0], [10.0, 50.0]]), "bad_guide"),  # crosses itself
        (np.array([[30.0, 30.0], [30.3, 30.0]]), "bad_guide"),
        (np.array([[30.0, 30.0], [math.nan, 30.0]]), "no_lines"),
        (np.empty((0, 2)), "no_lines"),
    ],
)
def test_lines_that_guide_nothing_are_refused_in_words(line: Floats, code: str) -> None:
    with pytest.raises(PlanRefused) as refused:
        plan_coverage(along(line))
    assert refused.value.code == code
    assert refused.value.text.endswith(".")


def test_of_several_guide_lines_the_longest_is_followed_and_named() -> None:
    job = along(wave(-5.0, 65.0, 25.0))
    short = CropRow("Short", np.array([[10.0, 10.0], [10.0, 30.0]]))
    plan = plan_coverage(replace(job, lines=(short, *job.lines)))
    assert plan.notes[0] == "The field has 2 guide lines; the rows follow the longest, Guide."


def test_the_tool_goes_on_before_treated_ground_along_the_curve() -> None:
    area = shapely.box(20, -5, 40, 65)
    job = along(wave(-5.0, 65.0, 25.0), doses=DoseMap(((area, 1.0),), 0.0, 0.5, 0.2))
    plan = plan_coverage(job)
    assert_steerable(job, plan)
    pieces = [(a, b, c) for a, b, c in zip(plan.legs, plan.legs[1:], plan.legs[2:], strict=False) if a.row == c.row > 0]
    through = [leg for before, leg, after in pieces if leg.tool_on and not before.tool_on and not after.tool_on]
    assert len(through) > 10
    for leg in through:
        line = shapely.LineString(leg.points)
        assert line.length - line.intersection(area).length == pytest.approx(0.7, abs=0.02)
        assert np.abs(np.diff(headings(leg.points))).max(initial=0.0) < math.radians(8)


def test_along_the_edge_is_along_the_longest_one() -> None:
    field = Polygon([(0, 0), (80, 20), (70, 60), (-10, 40)])
    assert edge_angle(field) == pytest.approx(math.atan2(20, 80))
    figures = plan_coverage(Job(field, 3.0, ROUND, rows=Rows.ALONG_EDGE)).figures
    assert figures.angle_rad == pytest.approx(math.atan2(20, 80))


@st.composite
def guided_jobs(draw: st.DrawFn) -> Job:
    """Draw fields with any guide line that bends no tighter than 10 m."""
    field = draw(fields)
    return along(draw(guides(field, 10.0)), field, draw(st.sampled_from(MACHINES)))


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(guided_jobs())
@pytest.mark.slow
def test_whatever_the_line_the_path_stays_inside_and_can_be_steered(job: Job) -> None:
    try:
        plan = plan_coverage(job)
    except PlanRefused as refused:
        event(refused.code)
        if refused.code in UNFIT:
            return
        raise
    event("planned")
    assert_drivable(job, plan)
    assert_steerable(job, plan)


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(crooked_fields(), st.data(), st.sampled_from([0.75, 3.0]))
@pytest.mark.slow
def test_parallels_of_a_gentle_line_leave_and_work_twice_next_to_nothing(
    field: Polygon, data: st.DataObject, width_m: float
) -> None:
    inner = erode(field, 4.0)
    assume(inner.area > 200)
    guide = data.draw(guides(field, 120.0))  # gentle: parallels of it do not meet within the field
    found = parallels(guide, inner, width_m, 1.5)
    strips = [shapely.LineString(line).buffer(width_m / 2, cap_style="flat") for lines in found.lines for line in lines]
    on_field = shapely.intersection(strips, inner)
    worked = shapely.union_all(on_field, grid_size=1e-4)
    assert worked.area >= 0.99 * inner.area
    assert shapely.area(on_field).sum() <= 1.01 * worked.area

"""Rows that were recorded: driven as they are, in passes of whole rows, and what is wrong with them is named."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st

from hmi.domain.mission_plan import PlanRefused, Rows
from hmi.planning.coverage import plan_coverage
from hmi.planning.ground import erode
from hmi.planning.guide import parallels
from hmi.planning.job import Job
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import LegKind, Plan
from hmi.planning.projection import Floats
from hmi.planning.recorded import CropRow, passes
from tests.hmi.planning.grounds import assert_drivable, square
from tests.hmi.planning.lines import guides, wave, waves
from tests.hmi.planning.test_properties import FAIR, MACHINES, assert_steerable, fields

FIELD = square(60.0)
INNER = erode(FIELD, 6.0)
ROUND = RobotProfile(turning_radius_m=1.5)
UNFIT = (*FAIR, "no_rows", "bad_rows", "rows_too_tight")


def job_of(rows: Sequence[CropRow], width_m: float = 3.0, machine: RobotProfile = ROUND, **more: Any) -> Job:
    return Job(more.pop("field", FIELD), width_m, machine, rows=Rows.RECORDED_ROWS, lines=tuple(rows), **more)


def notes(rows: Sequence[CropRow], tool_m: float = 1.0, spacing_m: float | None = None) -> str:
    return " ".join(passes(rows, INNER, tool_m, 1.5, spacing_m).notes)


def driven(plan: Plan) -> list[Floats]:
    return [leg.points for leg in plan.legs if leg.kind is LegKind.ROW]


def furthest_m(line: Floats, row: CropRow) -> float:
    within = line[(line[:, 0] > 0) & (line[:, 0] < 60)]
    return float(shapely.distance(shapely.points(within), shapely.LineString(row.points)).max())


def test_a_tool_for_one_row_drives_every_row_itself() -> None:
    rows = waves(18, 3.0, 2.0, 58.0)
    job = job_of(rows)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert_steerable(job, plan)
    assert all("no recorded row runs there" in note for note in plan.notes)
    assert len(driven(plan)) >= 14  # the others lie in the headland
    assert all(min(furthest_m(line, row) for row in rows) < 0.1 for line in driven(plan))


def test_a_wide_tool_takes_whole_rows_and_drives_between_or_over_them() -> None:
    four = [line for lines in passes(waves(24, 0.75), INNER, 3.0, 1.5, None).lines for line in lines]
    assert len(four) == 6
    below, above = waves(24, 0.75)[1], waves(24, 0.75)[2]
    between = next(line for line in four if furthest_m(line, below) < 0.5)
    distances = [
        shapely.distance(shapely.points(between[1:-1]), shapely.LineString(row.points)) for row in (below, above)
    ]
    assert np.abs(np.subtract(*distances)).max() < 0.05, "in the middle of the four"
    three = passes(waves(24, 0.75), INNER, 2.3, 1.5, None).lines
    assert len(three) == 8
    assert min(furthest_m(lines[0], waves(24, 0.75)[1]) for lines in three) < 0.05, "on the middle one of three"


def test_a_row_that_lacks_a_piece_takes_none_of_its_neighbours_away() -> None:
    rows = waves(24, 0.75)
    for missing in (1, 2):
        broken = [*rows[:missing], CropRow("stub", rows[missing].points[:12]), *rows[missing + 1 :]]
        first = passes(broken, INNER, 3.0, 1.5, 0.75).lines[-1]
        assert sum(shapely.LineString(line).length for line in first) > 120
        middle = shapely.LineString(wave(-5.0, 125.0, 5.0 + 1.5 * 0.75))
        inside = shapely.points(first[0][1:-1])
        assert shapely.distance(inside, middle).max() < 0.3


def test_rows_recorded_to_and_fro_in_any_order_and_in_pieces_are_put_in_order() -> None:
    rows = waves(16, 3.0, 2.0, 58.0)
    mixed = [CropRow(row.name, row.points[::-1] if k % 2 else row.points) for k, row in enumerate(rows)][::-1]
    halves = [CropRow(f"{row.name} {end}", part) for row in mixed for end, part in _halves(row.points)]
    pieces = passes(halves, INNER, 3.0, 1.5, None)
    assert [len(lines) for lines in pieces.lines] == [1] * 16
    upward = sorted((lines[0] for lines in pieces.lines), key=lambda line: float(line[:, 1].mean()))
    assert all(furthest_m(line[1:-1], row) < 0.1 for line, row in zip(upward, rows, strict=True))
    assert pieces.notes == ()


def _halves(points: Floats) -> list[tuple[str, Floats]]:
    middle = len(points) // 2
    return [("a", points[: middle + 1]), ("b", points[middle:])]


def test_gaps_doubled_and_crossing_rows_are_named() -> None:
    rows = waves(14, 3.0)
    assert "6.0 m between row 7 and row 5" in notes([*rows[:5], *rows[6:]])
    broken = [*rows[:5], *(CropRow(f"row 6 {e}", p) for e, p in _with_gap(rows[5].points)), *rows[6:]]
    assert "Gaps in rows are driven through: 8 m in row 6 a" in notes(broken)
    double = CropRow("double", wave(10.0, 40.0, 5.3))
    assert "double on row 1" in notes([*rows, double])
    crossing = CropRow("slanting", np.array([[10.0, 20.0], [50.0, 45.0]]))
    assert "slanting crosses" in notes([*rows, crossing])
    assert notes(rows) == ""


def test_one_line_recorded_for_each_pass_is_no_field_full_of_gaps() -> None:
    passes_of_three = waves(14, 1.5)
    assert notes(passes_of_three, tool_m=1.5, spacing_m=0.5) == ""
    narrow = notes(passes_of_three, tool_m=1.0, spacing_m=0.5)
    assert narrow.startswith("The recorded rows lie 1.5 m apart, and the tool is 1 m wide: ")
    assert "between" not in narrow
    one_lacks = notes([*passes_of_three[:5], *passes_of_three[6:]], tool_m=1.5, spacing_m=0.5)
    assert one_lacks.startswith("The rows lie 1.5 m apart, but there are 3.0 m between row 7 and row 5: ")


def _with_gap(points: Floats) -> list[tuple[str, Floats]]:
    middle = len(points) // 2
    return [("a", points[: middle - 1]), ("b", points[middle + 2 :])]


def test_a_row_that_ends_in_the_middle_of_the_field_is_not_drawn_on() -> None:
    rows = [CropRow("short", wave(2.0, 30.0, 30.0)), *waves(6, 3.0, 2.0, 58.0)]
    plan = plan_coverage(job_of(rows))
    ends = [max(line[:, 0]) for line in driven(plan) if furthest_m(line, rows[0]) < 2.0]
    assert ends == [pytest.approx(30.0, abs=0.1)]
    assert any("no recorded row runs there" in note for note in plan.notes)


def test_rows_that_bend_too_tightly_or_are_none_are_refused_by_name() -> None:
    hairpin = CropRow("row 4", np.array([[8.0, 20.0], [50.0, 20.0], [50.0, 21.0], [8.0, 26.0]]))
    with pytest.raises(PlanRefused, match=r"Row 4 bends tighter .* 47 m from its beginning\. Mend it on the map"):
        plan_coverage(job_of([hairpin], crop_spacing_m=0.75))
    with pytest.raises(PlanRefused, match="No recorded row is longer than 1 m"):
        plan_coverage(job_of([CropRow("dot", np.array([[30.0, 30.0], [30.1, 30.0]]))]))
    far = [CropRow(row.name, row.points + 500.0) for row in waves(3, 3.0)]
    with pytest.raises(PlanRefused, match="None of the lines lies over the field"):
        plan_coverage(job_of(far))


@st.composite
def recorded_jobs(draw: st.DrawFn) -> Job:
    """Draw fields with the rows of a sloppy recording: shaken, shuffled, turned around, broken and some missing."""
    field = draw(fields)
    spacing, noise = draw(st.sampled_from([0.75, 1.5, 3.0])), Random(draw(st.integers(0, 9999)))
    inner = erode(field, 1.0)
    try:
        found = parallels(draw(guides(field, 40.0)), inner, spacing, 0.5)
    except PlanRefused:
        found = parallels(np.array([field.bounds[:2], field.bounds[2:]]), inner, spacing, 0.5)
    rows = []
    for number, lines in enumerate(found.lines):
        for line in lines:
            shape = shapely.LineString(line)
            places = np.linspace(0.02, 0.98, max(3, int(shape.length / 2)))
            points = shapely.get_coordinates(shape.interpolate(places, normalized=True))
            points = points + np.array([[noise.gauss(0, 0.015) for _ in "xy"] for _ in points])
            if noise.random() > 0.05:
                rows.append(CropRow(f"row {number}", points[:: noise.choice([1, -1])]))
    noise.shuffle(rows)
    machine = draw(st.sampled_from(MACHINES))
    return job_of(rows or waves(4, 3.0), draw(st.sampled_from([1.5, 3.0])), machine, field=field)


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(recorded_jobs())
@pytest.mark.long
def test_whatever_was_recorded_the_path_stays_inside_and_can_be_steered(job: Job) -> None:
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

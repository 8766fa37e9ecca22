"""Plans over whole fields."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from hmi.domain.mission_plan import PathUnfit, Pattern, PlanRefused
from hmi.planning import coverage
from hmi.planning.coverage import plan_coverage
from hmi.planning.headland import Headland, divide
from hmi.planning.job import Job, checked_field
from hmi.planning.machine import RobotProfile
from hmi.planning.path_check import check_path
from hmi.planning.plan import LegKind, Plan
from tests.hmi.planning.grounds import assert_drivable, convex_fields, crooked_fields, given_field, square

WEEDER = RobotProfile()
WHEELED = RobotProfile(can_pivot=False, turning_radius_m=1.5)
NIMBLE = RobotProfile(length_m=1.2, width_m=0.8, base_to_front_m=0.7, turning_radius_m=0.5)
calm = settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def plan_or_fair_refusal(job: Job) -> Plan | None:
    """Return the plan; ``None`` if the field is refused for a reason that small and narrow fields have."""
    try:
        return plan_coverage(job)
    except PlanRefused as refused:
        if refused.code in ("field_too_small", "turn_does_not_fit", "no_way"):
            return None
        raise


@pytest.mark.slow
@calm
@given(convex_fields(), st.sampled_from([1.5, 3.0]), st.sampled_from([WEEDER, NIMBLE, WHEELED]))
def test_a_convex_field_is_covered_without_leaving_it(field: Polygon, width: float, machine: RobotProfile) -> None:
    job = Job(field, width, machine)
    plan = plan_or_fair_refusal(job)
    if plan is None:
        return
    assert_drivable(job, plan)
    # sharp corners of small fields are left: then the planner is told
    assert plan.figures.covered_m2 >= 0.95 * plan.figures.area_m2 or any("stays untreated" in n for n in plan.notes)
    assert plan.figures.inner_covered_m2 >= 0.5 * plan.figures.inner_m2


@calm
@given(crooked_fields(), st.sampled_from([1.5, 3.0]), st.sampled_from([WEEDER, NIMBLE, WHEELED]))
@pytest.mark.slow
def test_a_crooked_field_with_a_hole_is_never_left(field: Polygon, width: float, machine: RobotProfile) -> None:
    job = Job(field, width, machine)
    plan = plan_or_fair_refusal(job)
    if plan is not None:
        assert_drivable(job, plan)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "width", "inner_share", "whole_share"),
    [("lshape", 3.0, 0.999, 0.995), ("nc12", 3.0, 0.995, 0.995), ("nl-parcel", 3.0, 0.999, 0.999)],
)
def test_the_given_fields_are_worked_headland_included(
    name: str, width: float, inner_share: float, whole_share: float
) -> None:
    job = Job(given_field(name), width, WEEDER)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    figures = plan.figures
    assert figures.inner_covered_m2 >= inner_share * figures.inner_m2
    assert figures.covered_m2 >= whole_share * figures.area_m2
    assert figures.overlap_m2 <= 0.02 * figures.area_m2
    assert plan.notes == ()


SLANTING = Polygon([(25.6, 5.7), (8.0, 72.1), (76.9, 89.1), (74.8, 51.6), (64.2, 19.0)])
LONG_LEGGED = RobotProfile(length_m=6.4, width_m=2.6, base_to_front_m=4.0, turning_radius_m=3.5, can_pivot=False)


@pytest.mark.long
def test_a_headland_that_nobody_chose_is_deepened_until_the_turns_fit() -> None:
    job = Job(SLANTING, 1.0, LONG_LEGGED, pattern=Pattern.SPIRAL)
    usual = len(divide(LONG_LEGGED, 1.0, None).offsets_m)
    with pytest.raises(PlanRefused, match="Choose more headland passes"):
        plan_coverage(replace(job, headland_passes=usual))
    plan = plan_coverage(job)
    assert plan.figures.headland_passes > usual
    assert_drivable(job, plan)


def test_turns_that_fit_behind_no_headland_ask_for_something_else(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[int] = []

    def never(_job: Job, _field: object, division: Headland, _tell: object) -> Plan:
        tried.append(len(division.offsets_m))
        raise PlanRefused("turn_does_not_fit", "It does not fit. Choose more headland passes.", "headland_passes")

    monkeypatch.setattr(coverage, "_cover", never)
    with pytest.raises(PlanRefused, match="Choose a larger working width") as refused:
        plan_coverage(Job(SLANTING, 1.0, LONG_LEGGED))
    assert refused.value.field == "width_m"
    usual = len(divide(LONG_LEGGED, 1.0, None).offsets_m)
    assert tried == [usual, usual + 4, usual + 7]  # one and two turning radii of 3.5 m deeper
    with pytest.raises(PlanRefused, match="Choose more headland passes"):
        plan_coverage(Job(SLANTING, 1.0, LONG_LEGGED, headland_passes=3))
    assert tried[3:] == [3]  # what a person chose stays


def test_a_step_in_the_outline_costs_neither_a_row_nor_a_strip() -> None:
    step = square(120).difference(shapely.box(48, 48, 121, 121))  # arms of 12 rows behind the headland
    assert isinstance(step, Polygon)
    figures = plan_coverage(Job(step, 3.0, RobotProfile(turning_radius_m=1.5), angle_rad=0.0)).figures
    assert figures.rows == 36
    assert figures.inner_covered_m2 >= 0.999 * figures.inner_m2
    assert figures.overlap_m2 <= 0.001 * figures.area_m2


def test_a_field_too_narrow_in_the_middle_is_worked_on_its_larger_side() -> None:
    field = shapely.union_all([shapely.box(0, 0, 25, 25), shapely.box(25, 11, 40, 13), shapely.box(40, 0, 110, 60)])
    assert isinstance(field, Polygon)
    job = Job(field, 1.5, WEEDER)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert plan.figures.covered_m2 > 60 * 60
    assert any("left out" in note for note in plan.notes)


def test_two_centimetres_too_many_make_no_row_more() -> None:
    assert plan_coverage(Job(square(60.04), 3.0, RobotProfile(turning_radius_m=1.5))).figures.rows == 16


@pytest.mark.slow
def test_every_one_of_hundreds_of_narrow_rows_is_counted_as_worked() -> None:
    figures = plan_coverage(Job(given_field("nl-parcel"), 0.5, WEEDER)).figures
    assert figures.rows > 700
    assert figures.inner_covered_m2 >= 0.9995 * figures.inner_m2
    assert figures.covered_m2 + figures.overlap_m2 == pytest.approx(0.5 * figures.working_length_m, rel=1e-3)


def test_the_laps_around_a_hole_are_driven_before_its_headland_is_left() -> None:
    holes = [shapely.box(x, 80, x + 8, 90) for x in (60, 130)]
    field = shapely.box(0, 0, 200, 170).difference(shapely.union_all(holes))
    assert isinstance(field, Polygon)
    plan = plan_coverage(Job(field, 3.0, RobotProfile(turning_radius_m=1.5)))
    assert_drivable(Job(field, 3.0, WEEDER), plan)
    kinds = [leg.kind for leg in plan.legs if leg.tool_on and not leg.is_continued]
    last_row = len(kinds) - kinds[::-1].index(LegKind.ROW)
    assert kinds[:last_row].count(LegKind.HEADLAND) == 4, "two laps a hole between the rows"
    longest = max(leg.length_m for leg in plan.legs if leg.kind is LegKind.TURN)
    assert longest < 60


def test_the_best_angle_of_the_parcel_is_the_one_its_source_quotes() -> None:
    figures = plan_coverage(Job(given_field("nl-parcel"), 3.0, WEEDER)).figures
    assert figures.angle_rad == pytest.approx(2.853, abs=0.04)
    assert figures.area_m2 == pytest.approx(172_581, rel=0.001)


@pytest.mark.slow
def test_a_hundred_hectares_with_ten_holes_are_covered_without_touching_one() -> None:
    job = Job(given_field("field100"), 12.0, WEEDER)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert plan.notes == ()
    assert plan.figures.covered_m2 >= 0.98 * plan.figures.area_m2


def test_half_metre_rows_are_joined_by_declared_turns_on_the_spot() -> None:
    job = Job(square(20), 0.5, WEEDER)
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert plan.figures.pivots >= plan.figures.rows


def test_rows_two_turning_radii_apart_are_joined_without_stopping() -> None:
    plan = plan_coverage(Job(square(60), 3.0, WEEDER))
    between_rows = [leg for leg in plan.legs if leg.kind is LegKind.TURN and not leg.pivot]
    assert plan.figures.pivots == 0
    assert len(between_rows) >= plan.figures.rows - 1


def test_rows_follow_the_angle_that_was_asked_for() -> None:
    plan = plan_coverage(Job(square(60), 3.0, WEEDER, angle_rad=math.radians(30)))
    for leg in plan.legs:
        if leg.row:
            assert math.remainder(leg.first_heading_rad - math.radians(30), math.pi) == pytest.approx(0, abs=1e-6)


def test_an_obstacle_splits_the_rows_and_is_driven_around() -> None:
    pylon = shapely.Point(30, 30).buffer(3, quad_segs=2)
    job = Job(square(60), 3.0, WEEDER, obstacles=(pylon,))
    plan = plan_coverage(job)
    assert_drivable(job, plan)
    assert plan.figures.rows > plan_coverage(Job(square(60), 3.0, WEEDER)).figures.rows


def test_the_way_from_home_follows_the_road_and_ends_at_home() -> None:
    road = shapely.LineString([(-40, 10), (5, 10)]).buffer(3)
    job = Job(square(40), 3.0, WEEDER, home=(-35.0, 10.0), roads=road, returns_home=True)
    plan = plan_coverage(job)
    first, last = plan.legs[0], plan.legs[-1]
    assert first.kind is LegKind.APPROACH
    assert last.kind is LegKind.EXIT
    assert tuple(first.points[0]) == pytest.approx((-35, 10))
    assert tuple(last.points[-1]) == pytest.approx((-35, 10))
    assert_drivable(Job(job.parcel.union(road), 3.0, WEEDER), plan)


def test_a_slow_robot_drives_its_ways_no_faster_than_it_can() -> None:
    road = shapely.LineString([(-40, 10), (1, 10)]).buffer(3)
    slow = replace(WEEDER, row_speed_mps=0.3, turn_speed_mps=0.3, transit_speed_mps=0.4)
    job = Job(square(40), 3.0, slow, home=(-35.0, 10.0), roads=road, returns_home=True)
    plan = plan_coverage(job)
    assert {leg.kind for leg in plan.legs} >= {LegKind.APPROACH, LegKind.EXIT}
    assert max(leg.speed_mps for leg in plan.legs) <= 0.4
    check_path(job, checked_field(job), plan.legs)
    hasty = [replace(leg, speed_mps=0.6) if leg.kind is LegKind.EXIT else leg for leg in plan.legs]
    with pytest.raises(PathUnfit, match=r"0\.60 m/s where 0\.40 m/s is the most"):
        check_path(job, checked_field(job), hasty)


NARROW = shapely.LineString([(-40, 10), (5, 10)]).buffer(0.4)  # wide enough for no machine


@pytest.mark.parametrize("roads", [None, shapely.Point(-35.0, 10.0).buffer(4.0), NARROW])
def test_a_home_that_no_way_leads_from_is_refused_with_the_way_out(roads: Polygon | None) -> None:
    with pytest.raises(PlanRefused, match=r"Draw .* under Maps, .* start at the field") as refused:
        plan_coverage(Job(square(40), 3.0, WEEDER, home=(-35.0, 10.0), roads=roads, returns_home=True))
    assert (refused.value.code, refused.value.field) == ("home_unreachable", "home_id")


def test_a_home_that_is_cut_off_is_refused_before_rows_are_ordered() -> None:
    heard: list[str] = []
    with pytest.raises(PlanRefused):
        plan_coverage(Job(square(40), 3.0, WEEDER, home=(-35.0, 10.0)), lambda _share, words: heard.append(words))
    assert heard == ["Laying rows", "Ordering rows"]


def test_a_field_in_two_parts_begins_in_the_one_that_home_leads_to() -> None:
    ditch = shapely.box(-1, 32, 81, 36)  # the larger part lies behind it
    road = shapely.LineString([(-40, 6), (5, 6)]).buffer(3)
    job = Job(square(80), 3.0, WEEDER, obstacles=(ditch,), home=(-35.0, 6.0), roads=road)
    plan = plan_coverage(job)
    assert plan.legs[0].kind is LegKind.APPROACH
    assert all(shapely.LineString(leg.points).bounds[3] < 32 for leg in plan.legs)
    assert any("cannot be reached from the others" in note for note in plan.notes)


@pytest.mark.parametrize(
    ("change", "code", "field"),
    [
        ({"width_m": 0.0}, "width_not_positive", "width_m"),
        ({"width_m": -3.0}, "width_not_positive", "width_m"),
        ({"width_m": math.nan}, "width_not_positive", "width_m"),
        ({"width_m": math.inf}, "width_not_positive", "width_m"),
        ({"width_m": 0.01}, "width_absurd", "width_m"),
        ({"width_m": 400.0}, "width_absurd", "width_m"),
        ({"angle_rad": math.nan}, "bad_angle", "angle_rad"),
        ({"headland_passes": -1}, "bad_headland", "headland_passes"),
        ({"headland_passes": 20}, "field_too_small", "headland_passes"),
        ({"home": (math.nan, 0.0)}, "bad_home", "home"),
        ({"parcel": square(1.5)}, "field_too_small", "field_id"),
        ({"parcel": Polygon([(0, 0), (40, 40), (40, 0), (0, 40)])}, "bad_field", "field_id"),
        ({"parcel": Polygon()}, "bad_field", "field_id"),
        ({"obstacles": (square(100),)}, "field_blocked", "field_id"),
        ({"parcel": square(9000), "width_m": 0.5}, "too_many_rows", "width_m"),
    ],
)
def test_what_cannot_be_planned_is_refused_with_a_reason(change: dict[str, object], code: str, field: str) -> None:
    given_job: dict[str, object] = {"parcel": square(40), "width_m": 3.0, "machine": WEEDER}
    with pytest.raises(PlanRefused) as refused:
        plan_coverage(Job(**{**given_job, **change}))  # type: ignore[arg-type]
    assert (refused.value.code, refused.value.field) == (code, field)
    assert refused.value.text.endswith(".")


def test_a_field_of_too_many_corners_is_refused() -> None:
    angles = np.linspace(0, 2 * math.pi, 200_002)
    with pytest.raises(PlanRefused) as refused:
        plan_coverage(Job(Polygon(np.column_stack([np.cos(angles), np.sin(angles)]) * 90), 3.0, WEEDER))
    assert refused.value.code == "too_many_points"


def test_an_edge_recorded_every_centimetre_is_thinned_and_planned() -> None:
    angles = np.linspace(0, 2 * math.pi, 20_000)
    plan = plan_coverage(Job(Polygon(np.column_stack([np.cos(angles), np.sin(angles)]) * 30), 3.0, WEEDER))
    assert plan.figures.covered_m2 >= 0.98 * plan.figures.area_m2


@pytest.mark.parametrize(
    "change", [{"width_m": 0.0}, {"row_speed_mps": math.nan}, {"base_to_front_m": 9.0}, {"turning_radius_m": -1.0}]
)
def test_a_machine_that_cannot_be_is_refused(change: dict[str, float]) -> None:
    with pytest.raises(PlanRefused, match="bad_machine"):
        RobotProfile(**change)

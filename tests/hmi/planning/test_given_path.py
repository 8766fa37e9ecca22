"""A path planned elsewhere: our own plans pass whole, and what breaks a rule is refused, however it is broken."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from typing import Any

import pytest
import shapely
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from hmi.domain.mission_plan import PathUnfit, Pattern, PlanRefused, PlanWish, Surroundings, TreatedArea, Treatment
from hmi.planning.coverage import plan_coverage
from hmi.planning.given_path import checked_candidate, checked_mission, legs_of, segments_of
from hmi.planning.job import checked_field
from hmi.planning.machine import RobotProfile
from hmi.planning.mission import job_of, plan_mission
from hmi.planning.plan import poses_along
from hmi.planning.projection import LocalFrame
from tests.hmi.missions.rig import lon_lat
from tests.hmi.missions.test_document import wish
from tests.hmi.planning.grounds import convex_fields, crooked_fields
from tests.hmi.planning.test_properties import fields_with_holes
from tests.hmi.presenters.robots import SHEET

FRAME = LocalFrame(51.78, 4.26)
Segments = list[dict[str, Any]]


def path_of(asked: PlanWish) -> Segments:
    """Return our own planner's path as a service tells it."""
    return segments_of(plan_coverage(job_of(asked)).legs)


@pytest.fixture(scope="module")
def usual() -> tuple[PlanWish, Segments]:
    asked = wish(angle_rad=0.0)
    return asked, path_of(asked)


def told_in_millimetres(segments: Segments) -> Segments:
    """Return a path as a service may round it."""
    return [{**one, "points": [[round(x, 3), round(y, 3)] for x, y in one["points"]]} for one in segments]


@pytest.mark.parametrize("pattern", Pattern)
def test_our_own_plan_comes_back_the_same_to_the_byte(pattern: Pattern) -> None:
    asked = wish(pattern=pattern)
    own, found = plan_mission(asked), checked_mission(asked, path_of(asked), [])
    assert (found.sha256, found.document) == (own.sha256, own.document)
    assert {**found.statistics, "notes": []} == {**own.statistics, "notes": []}


@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    st.one_of(convex_fields(), crooked_fields(), fields_with_holes()),
    st.sampled_from([0.5, 1.5, 3.0]),
    st.sampled_from(Pattern),
    st.booleans(),
)
@pytest.mark.slow
def test_whatever_our_planner_makes_is_taken(field: Any, width_m: float, pattern: Pattern, is_from_home: bool) -> None:
    inside = field.representative_point()
    home = (*lon_lat((inside.x, inside.y))[0],) if is_from_home else None
    rings = [FRAME.to_lon_lat(ring.coords).tolist() for ring in (field.exterior, *field.interiors)]
    asked = wish(parcel={"type": "Polygon", "coordinates": rings}, width_m=width_m, pattern=pattern, home=home)
    try:
        own = plan_mission(asked).statistics
        path = told_in_millimetres(path_of(asked))
    except PlanRefused:
        assume(False)
    assume(own["missed_m2"] < 0.7 * own["wanted_m2"])  # slivers of a field
    assert checked_candidate(asked, path, []).drawing["legs"]


def test_a_treatment_is_taken_as_planned_and_refused_where_its_dose_was_not_asked_for() -> None:
    corner = wish().parcel["coordinates"][0]
    middle = [sum(p[0] for p in corner[:4]) / 4, sum(p[1] for p in corner[:4]) / 4]
    half = [[p[0], min(p[1], middle[1])] for p in corner]
    asked = wish(angle_rad=0.0, treatment=Treatment((TreatedArea({"type": "Polygon", "coordinates": [half]}, 0.0),)))
    path = told_in_millimetres(path_of(asked))
    checked_mission(asked, path, [])
    everywhere = path_of(wish(angle_rad=0.0))
    with pytest.raises(PathUnfit, match="where that was not asked for"):
        checked_mission(asked, everywhere, [])


def changed(segments: Segments, number: int, **values: Any) -> Segments:
    """Return a path with one piece changed."""
    made = copy.deepcopy(segments)
    made[number % len(made)] |= values
    return made


def first(segments: Segments, kind: str) -> int:
    return next(k for k, one in enumerate(segments) if one["kind"] == kind)


def moved(segments: Segments, east_m: float, north_m: float = 0.0) -> Segments:
    return [{**one, "points": [[x + east_m, y + north_m] for x, y in one["points"]]} for one in segments]


def test_each_broken_rule_is_named(usual: tuple[PlanWish, Segments]) -> None:
    asked, path = usual
    row, turn = first(path, "row"), first(path, "turn")
    points = path[row]["points"]
    cases: list[tuple[str, Segments]] = [
        ("outside", moved(path, 0.0, 4.0) if asked.home is None else moved(path[row:], 0.0, 4.0)),
        ("gap", changed(path, row, points=[points[0], [points[1][0] - 0.2, points[1][1]]])),
        ("speed", changed(path, row, speed_mps=3.0)),
        ("tool", changed(path, turn, tool_on=True, speed_mps=0.2)),
        ("rows", changed(path, row, row=7)),
        ("dose", changed(path, row, dose=2.0, speed_mps=0.1)),
        ("numbers", changed(path, row, points=[[math.nan, 0.0], [1.0, 1.0]])),
        ("numbers", changed(path, row, points=[[9e4, 0.0], [1.0, 1.0]])),
        ("size", []),
    ]
    for code, broken in cases:
        with pytest.raises(PathUnfit) as refused:
            checked_mission(asked, broken, [])
        assert refused.value.code == code, refused.value.text
        assert refused.value.text.endswith(".")


def test_a_turn_on_the_spot_has_to_be_declared_and_to_be_possible() -> None:
    asked = wish(angle_rad=0.0, pattern=Pattern.ROW_BY_ROW, width_m=1.5, home=tuple(lon_lat((20, 20))[0]))
    path = path_of(asked)
    pivots = [k for k, one in enumerate(path) if one["pivot"]]
    with pytest.raises(PathUnfit, match="corner"):
        checked_mission(asked, changed(path, pivots[-1], pivot=False), [])
    with pytest.raises(PathUnfit, match="which this robot cannot"):
        checked_mission(replace(asked, robot=replace(SHEET, can_pivot=False)), path, [])


def turned_at(x: float, y: float, *, is_about: bool = False, **more: Any) -> tuple[PlanWish, Segments]:
    """Return a path that ends its first row at a place, northbound, and turns there on the spot: about, or eastward."""
    asked = wish(angle_rad=0.0, home=None, **more)
    turn = {
        "kind": "turn",
        "points": [[x, y], [x, y - 6.0] if is_about else [x + 6.0, y]],
        "pivot": True,
        "tool_on": False,
        "row": 0,
    }
    row = {"kind": "row", "points": [[x, 12.0], [x, y]], "pivot": False, "tool_on": True, "row": 1}
    usual = {"speed_mps": 0.3, "dose": 1.0, "is_continued": False, "is_backward": False}
    return asked, [{**usual, **row}, {**usual, **turn}]


REACH_M = RobotProfile().reach_m
BESIDE = 0.9  # metres from a border: half the outline's width fits, its corners do not


@pytest.mark.parametrize(
    ("place", "stone", "says"),
    [
        ((BESIDE, 25.0), None, f"leave the field by {REACH_M - BESIDE - 0.02:.2f} m"),
        ((20.0, 25.0), (21.08, 24.0), "swing into a hole of the field or an obstacle by 0."),
        ((20.0, 25.0), (18.95, 26.05), "swing into a hole of the field or an obstacle by 0."),
    ],
    ids=["the border", "an obstacle ahead", "an obstacle behind"],
)
def test_a_turn_on_the_spot_is_judged_by_the_ground_it_sweeps(
    place: tuple[float, float], stone: tuple[float, float] | None, says: str
) -> None:
    corner = {"type": "Point", "coordinates": lon_lat(stone)[0]} if stone else None
    around = Surroundings(((corner, 0.1),)) if corner else Surroundings()
    asked, path = turned_at(*place, is_about=stone is None, surroundings=around)
    job = job_of(asked)
    field = checked_field(job)
    # before and after, and all along, the outline is on the field: only the turn swings it out
    for leg in legs_of(path):
        outlines = job.machine.outline_polygons(poses_along(leg.points, 0.1))
        assert shapely.covers(field, outlines).all()
    with pytest.raises(PathUnfit) as refused:
        checked_mission(asked, path, [])
    assert refused.value.code == "outside"
    assert says in refused.value.text
    assert f"{place[0]:.1f} m east and {place[1]:.1f} m north" in refused.value.text
    farther, clear = turned_at(20.0, 25.0)
    with pytest.raises(PathUnfit, match="of the ground to be treated only"):  # it drives, and does too little
        checked_mission(farther, clear, [])


def test_a_path_that_does_little_of_the_work_is_refused(usual: tuple[PlanWish, Segments]) -> None:
    asked, path = usual
    third = [k for k, one in enumerate(path) if one["kind"] == "row"][2]
    begun = [one for one in path[:third] if one["kind"] != "exit"]
    with pytest.raises(PathUnfit, match="of the ground to be treated only"):
        checked_mission(asked, begun, [])


def test_rows_over_one_another_are_refused(usual: tuple[PlanWish, Segments]) -> None:
    asked, path = usual
    rows = [one for one in path if one["kind"] == "row"]
    a = rows[0]
    back = {**a, "points": a["points"][::-1], "row": 2, "pivot": True}
    again = {**a, "row": 3, "pivot": True}
    with pytest.raises(PathUnfit) as refused:
        checked_mission(asked, [{**a, "pivot": False}, back, again], [])
    assert refused.value.code == "twice"


def test_the_words_of_a_service_stay_words(usual: tuple[PlanWish, Segments]) -> None:
    asked, path = usual
    found = checked_mission(asked, path, ["One\n<b>two</b>\x07", "x" * 5000, *["n"] * 50])
    notes = found.statistics["notes"]
    assert notes[0] == "One<b>two</b>"
    assert max(map(len, notes)) <= 300
    assert len(notes) <= 21


CHANGES = st.one_of(
    st.tuples(st.just("move"), st.floats(3.0, 500.0), st.floats(0, 2 * math.pi)),
    st.tuples(st.just("turn"), st.floats(0.3, 2.8), st.none()),
    st.tuples(st.just("stretch"), st.floats(1.3, 5.0), st.none()),
    st.tuples(st.just("drop"), st.floats(0.1, 0.9), st.none()),
    st.tuples(st.just("swap"), st.floats(0.1, 0.9), st.none()),
    st.tuples(st.just("corner"), st.floats(0.0, 1.0), st.floats(2.0, 50.0)),
    st.tuples(st.just("speed"), st.floats(0.0, 1.0), st.floats(3.1, 20.0)),
)


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(CHANGES)
@pytest.mark.slow
def test_a_mutated_path_is_never_taken(usual: tuple[PlanWish, Segments], change: tuple[str, Any, Any]) -> None:
    asked, path = usual
    with pytest.raises(PathUnfit):
        checked_mission(asked, mutated(path, *change), [])


def mutated(path: Segments, kind: str, value: Any, other: Any) -> Segments:
    """Return a path that no honest planner makes of the wish."""
    made = copy.deepcopy(path)
    number = int(value * (len(made) - 1)) if 0 <= value <= 1 else 0
    if kind == "move":
        return moved(made, value * math.cos(other), value * math.sin(other))
    if kind == "turn":
        cos, sin = math.cos(value), math.sin(value)
        return [{**one, "points": [[cos * x - sin * y, sin * x + cos * y] for x, y in one["points"]]} for one in made]
    if kind == "stretch":
        return [{**one, "points": [[value * x, value * y] for x, y in one["points"]]} for one in made]
    if kind == "drop":
        return made[:number] + made[number + 1 :] if made[number]["kind"] == "row" else made[: number // 6]
    if kind == "swap":
        return [*made[number:], *made[:number]]
    if kind == "corner":
        made[number]["points"][0][1] += other
        return made
    made[number]["speed_mps"] = other
    return made

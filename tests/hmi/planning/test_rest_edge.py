"""The rest of a mission whose field got a new edge: worked as far as a new plan would, and said where it is not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from hmi.domain.mission_document import Document
from hmi.domain.mission_plan import PlannedMission, PlanRefused, PlanWish, Surroundings, TreatedArea, Treatment
from hmi.domain.mission_rest import PlannedRest, Progress, RestWish, cut, is_work, length_m
from hmi.planning import rest as rest_module
from hmi.planning.machine import RobotProfile
from hmi.planning.mission import plan_mission
from hmi.planning.plan import GENTLE_RAD, poses_along, turn_between
from hmi.planning.rest import plan_rest
from hmi.planning.rest_work import leg_of
from tests.hmi.missions.rig import FRAME, lon_lat
from tests.hmi.planning.grounds import union_of, worked_strips
from tests.hmi.presenters.robots import SHEET

WIDTH_M = 3.0
EVERYWHERE = Treatment()
STEERED = replace(
    SHEET, can_pivot=False, turning_radius_m=1.5, length_m=3.0, width_m=1.5, base_to_front_m=2.4, path_reverse_mps=0.5
)
FIELD = shapely.box(0, 0, 60, 50)
CORNER = Polygon([(42, 51), (61, 51), (61, 32)])
NEW_EDGES = {
    "across a corner": CORNER,
    "across a tip": Polygon([(55, 51), (61, 51), (61, 45)]),
    "along a side": shapely.box(57, -1, 61, 51),
    "a little of a side": shapely.box(-1, 49.7, 61, 51),
    "a bay": shapely.box(50, 20, 61, 28),
    "a hole": shapely.Point(44, 25).buffer(3.0, quad_segs=4),
}


def geometry(polygon: Polygon) -> dict[str, Any]:
    rings = [lon_lat(*ring.coords) for ring in (polygon.exterior, *polygon.interiors)]
    return {"type": "Polygon", "coordinates": rings}


@cache
def planned(
    field: Polygon = FIELD, *, is_steered: bool = False, treatment: Treatment = EVERYWHERE, width_m: float = WIDTH_M
) -> PlannedMission:
    return plan_mission(
        PlanWish(
            "m-1", "Home field", "weeder-01", "Home field", geometry(field), width_m, FRAME.lat_deg, FRAME.lon_deg,
            angle_rad=math.pi / 2, robot=STEERED if is_steered else None, treatment=treatment,
        )
    )  # fmt: skip


def rest(base: PlannedMission, now: Polygon, number: int, s_m: float, **more: Any) -> PlannedRest:
    progress = Progress(base.sha256, number, s_m)
    usual: dict[str, Any] = {"revision": 2, "field_now": geometry(now)}
    return plan_rest(RestWish(base=base.document, base_sha256=base.sha256, progress=progress, **{**usual, **more}))


def worked(segments: Sequence[Document]) -> shapely.Geometry:
    return union_of(worked_strips([leg_of(one) for one in segments], WIDTH_M))


def number_of(base: PlannedMission, kind: str, row: int = 0) -> int:
    segments = base.document["segments"]
    return next(k for k, one in enumerate(segments) if one["kind"] == kind and one["row"] == row and one["tool_on"])


def new_part(made: PlannedRest) -> list[Document]:
    found: list[Document] = made.document["segments"][made.document["continues"]["segments"] :]
    return found


def check_drives_inside(made: PlannedRest, now: Polygon, machine: RobotProfile) -> None:
    """Outline and turns on the spot stay on the field as it is now; every turn on the spot is declared."""
    ground = now.buffer(0.02)
    legs = [leg_of(one) for one in made.document["segments"]]
    for number in range(made.document["continues"]["segments"], len(legs)):
        leg = legs[number]
        outlines = machine.outline_polygons(poses_along(leg.points, 0.1, is_backward=leg.is_backward))
        assert shapely.covers(ground, outlines).all(), number
        if number == 0 or made.document["segments"][number].get("jump"):
            continue
        turn = turn_between(legs[number - 1], leg)
        assert leg.pivot or abs(turn) <= GENTLE_RAD + 0.02
        if leg.pivot:
            headings = legs[number - 1].last_heading_rad + np.linspace(0, turn, 30)
            swept = machine.outline_polygons(np.column_stack([np.tile(leg.points[0], (30, 1)), headings]))
            assert shapely.covers(ground, swept).all(), number


@pytest.mark.parametrize("is_steered", [False, True], ids=["pivots", "steers"])
@pytest.mark.parametrize("lost", NEW_EDGES.values(), ids=NEW_EDGES)
def test_the_rest_of_a_field_with_a_new_edge_is_worked_as_a_new_plan_would(lost: Polygon, is_steered: bool) -> None:
    base, now = planned(is_steered=is_steered), FIELD.difference(lost)
    number = number_of(base, "row", 2)
    # rows begin at one side or the other: it stands well away from what is new
    if base.document["segments"][number]["points"][0][0] > 30:
        number = (
            max(k for k, one in enumerate(base.document["segments"]) if one["row"] and one["points"][0][0] > 30) + 2
        )
    made = rest(base, now, number, 0.0, robot=STEERED if is_steered else None)
    done, _, _ = cut(base.document["segments"], number, 0.0)
    anew = plan_mission(
        PlanWish("m", "n", "weeder-01", "f", geometry(now), WIDTH_M, FRAME.lat_deg, FRAME.lon_deg,
                 angle_rad=math.pi / 2, robot=STEERED if is_steered else None)
    )  # fmt: skip
    best_m2 = worked([*done, *anew.document["segments"]]).intersection(now).area
    assert worked(made.document["segments"]).intersection(now).area > 0.985 * best_m2
    check_drives_inside(made, now, RobotProfile.from_factsheet(STEERED) if is_steered else RobotProfile())


def test_what_stays_unworked_is_told_before_one_confirms() -> None:
    base = planned()
    now = FIELD.difference(CORNER)
    made = rest(base, now, number_of(base, "row", 2), 5.0, leave_out=(number_of(base, "row", 4),))
    left_out = [base.document["segments"][number_of(base, "row", 4)]]
    could = worked(base.document["segments"]).intersection(now).difference(worked(left_out))
    missed_m2 = could.difference(worked(made.document["segments"])).area
    assert made.difference["missed_m2"] == pytest.approx(missed_m2, abs=0.5)
    notes = " ".join(made.difference["notes"])
    assert "headland laps are laid anew along the edge of the field as it is now" in notes
    assert ("stay unworked that were to be worked" in notes) == (missed_m2 >= 1)
    assert missed_m2 < 0.01 * now.area


@pytest.mark.parametrize("s_m", [0.0, 3.333, 17.01])
def test_a_rest_that_changes_nothing_misses_nothing(s_m: float) -> None:
    base = planned()
    made = rest(base, FIELD, number_of(base, "row", 3), s_m)
    assert (made.difference["missed_m2"], made.difference["notes"]) == (0.0, [])


def test_a_field_that_falls_apart_into_a_narrow_part_says_what_it_loses() -> None:
    base = planned()
    now = FIELD.difference(shapely.box(50.0, 4.0, 61.0, 51.0))  # a strip stays in which no lap fits twice
    made = rest(base, now, number_of(base, "row", 2), 5.0)
    could = worked(base.document["segments"]).intersection(now)
    missed_m2 = could.difference(worked(made.document["segments"])).area
    assert made.difference["missed_m2"] == pytest.approx(missed_m2, abs=0.5)
    assert missed_m2 < 1 or "stay unworked" in " ".join(made.difference["notes"])


@pytest.mark.parametrize("much", [0.0, 0.5])
def test_where_much_stays_unworked_a_new_plan_is_named_as_the_way_out(
    much: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rest_module, "MUCH_MISSED", much)
    base = planned()
    made = rest(base, FIELD.difference(shapely.box(50.0, 4.0, 61.0, 51.0)), number_of(base, "row", 2), 5.0)
    [told] = [note for note in made.difference["notes"] if "stay unworked" in note]
    assert ("A new plan of the field may work more of it." in told) == (much == 0.0)


def test_of_a_lap_half_done_only_the_other_half_is_driven() -> None:
    base = planned()
    segments = base.document["segments"]
    laps = [k for k, one in enumerate(segments) if one["kind"] == "headland" and one["tool_on"]]
    number = next(k for k in laps if segments[k]["points"][0] != segments[laps[0]]["points"][0])
    done, left, _ = cut(segments, number, 0.0)
    x, y = shapely.LineString(left[0]["points"]).interpolate(0.5, normalized=True).coords[0]
    near = shapely.Point(x, y).buffer(6).difference(FIELD.buffer(-0.4, join_style="mitre"))
    now = FIELD.difference(near)  # a little of the border, where it has not been yet
    made = rest(base, now, number, 0.0)
    again_m2 = worked(done).buffer(-0.05).intersection(worked(new_part(made))).area
    assert again_m2 < 0.05 * worked(done).area
    assert worked(made.document["segments"]).intersection(now).area > 0.99 * worked(segments).intersection(now).area
    check_drives_inside(made, now, RobotProfile())


def test_laps_laid_anew_treat_nothing_that_was_not_to_be_treated() -> None:
    off = shapely.box(20.0, -1.0, 40.0, 12.0)
    base = planned.__wrapped__(treatment=Treatment((TreatedArea(geometry(off), 0.0),), lead_in_m=0.0, lead_out_m=0.0))
    now = shapely.box(0, 0.5, 60, 50)
    made = rest(base, now, number_of(base, "row", 2), 5.0)
    assert any("laid anew" in note for note in made.difference["notes"])
    # a lap's tool is off where its middle is in the area: half its width reaches in from the side
    lines = [shapely.LineString(one["points"]) for one in new_part(made) if one["tool_on"]]
    assert sum(line.intersection(off.buffer(-WIDTH_M)).length for line in lines) < 0.5
    assert sum(line.intersection(off.buffer(-0.5)).length for line in lines) < 6.0


def test_a_turn_on_the_spot_that_would_swing_into_something_new_is_not_driven() -> None:
    base, machine = planned(shapely.box(0, 0, 30, 30), width_m=0.9), RobotProfile()
    segments = base.document["segments"]
    legs = [leg_of(one) for one in segments]
    ends = [k for k, one in enumerate(legs[:-1]) if one.kind.value == "row" and legs[k + 1].pivot]
    place, heading = legs[ends[6]].points[-1], legs[ends[6]].last_heading_rad
    turn = turn_between(legs[ends[6]], legs[ends[6] + 1])
    bearing = heading + turn / 2
    aside = place + (machine.reach_m - 0.1) * np.array([math.cos(bearing), math.sin(bearing)])
    stone = shapely.Point(aside).buffer(0.05)
    post = {"type": "Point", "coordinates": lon_lat(tuple(aside))[0]}
    poses = np.array([(*place, heading), (*place, heading + turn)])
    assert not shapely.intersects(machine.outline_polygons(poses), stone).any(), "only on the way from one to the other"
    field = shapely.box(0, 0, 30, 30)
    around = Surroundings(((post, 0.1),))
    made = rest(base, field, ends[0], 1.0, surroundings=around)
    check_drives_inside(made, field.difference(stone), machine)
    told: dict[str, Any] = {"surroundings": around, "around_before": Surroundings(), "is_running": True}
    with pytest.raises(PlanRefused, match=r"No known way leads from where it stands.*Pause the robot"):
        rest(base, field, ends[6], 1.0, **told)
    with pytest.raises(PlanRefused, match=r"is on the path before the new one begins.*Pause the robot"):
        rest(base, field, ends[6], 20.0, **told)  # it is nearer to that turn than the new path could be
    behind = {"type": "Point", "coordinates": lon_lat(tuple(2 * place - aside))[0]}
    told["surroundings"] = Surroundings(((behind, 0.1),))
    with pytest.raises(PlanRefused, match=r"is on the path before the new one begins.*Pause the robot"):
        rest(base, field, ends[6], 20.0, **told)  # the machine passed it, its rear swings there


def test_a_robot_that_stands_over_the_new_edge_is_to_be_driven_back_by_hand() -> None:
    base = planned()
    number = number_of(base, "row", 3)
    x, y = base.document["segments"][number]["points"][0]
    with pytest.raises(PlanRefused, match=r"Drive it (back|away) by hand, then choose Resume later"):
        rest(base, FIELD.difference(shapely.box(x - 5, y - 9, x + 5, y + 9)), number, 1.0)


@settings(max_examples=30, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    at=st.floats(0, 1), depth_m=st.floats(0.1, 15), angle=st.floats(-0.8, 0.8), place=st.floats(0, 0.95),
    share=st.floats(0, 1), is_steered=st.booleans(), is_reversed=st.booleans(),
)  # fmt: skip
@pytest.mark.slow
def test_wherever_the_new_edge_lies_the_outline_stays_inside_and_what_is_lost_is_told(
    at: float, depth_m: float, angle: float, place: float, share: float, is_steered: bool, is_reversed: bool
) -> None:
    base = planned(is_steered=is_steered)
    spot = np.array(FIELD.exterior.interpolate(at, normalized=True).coords[0])
    inward = np.array([30.0, 25.0]) - spot
    edge = shapely.affinity.rotate(
        shapely.box(-200, -200, 200, depth_m), math.degrees(math.atan2(*inward[::-1]) + angle) - 90, origin=(0, 0)
    )
    now = FIELD.difference(shapely.affinity.translate(edge, *spot))
    assume(isinstance(now, Polygon) and now.area > 1000)
    segments = base.document["segments"]
    works = [k for k, one in enumerate(segments) if is_work(one)]
    number = works[int(place * len(works))]
    robot = STEERED if is_steered else None
    try:
        made = rest(base, now, number, share * length_m(segments[number]), is_reversed=is_reversed, robot=robot)
    except PlanRefused as refused:
        event(refused.code)
        return
    first = made.document["continues"]["segments"]
    start = leg_of(made.document["segments"][first])
    machine = RobotProfile.from_factsheet(STEERED) if is_steered else RobotProfile()
    stands = machine.outline_polygons(np.array([(*start.points[0], start.first_heading_rad)]))
    if shapely.covers(now, stands).all():  # it was paused on the field as it is now
        check_drives_inside(made, now, machine)
    could = worked(segments).intersection(now)
    assert made.difference["missed_m2"] == pytest.approx(
        could.difference(worked(made.document["segments"])).area, abs=1
    )

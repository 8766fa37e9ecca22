"""The rest of a mission planned anew: nothing done twice, nothing lost, one path without gaps."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

from backend_clients.edge import messages_down as down
from hmi.domain.mission_document import mission_sha256
from hmi.domain.mission_plan import PlannedMission, PlanRefused, PlanWish, Surroundings
from hmi.domain.mission_rest import PlannedRest, Progress, RestWish, cut, is_work, length_m, pieces_of
from hmi.planning.ground import Ground
from hmi.planning.machine import RobotProfile
from hmi.planning.mission import plan_mission
from hmi.planning.rest import AHEAD_M, plan_rest
from tests.hmi.missions.rig import FRAME, lon_lat, parcel_geometry

SIDE_M = 40.0
HOME = (-8.0, 20.0)
FIELD_AND_ROAD = shapely.union_all(
    [shapely.box(0, 0, SIDE_M, SIDE_M), shapely.box(-15, 16.9, 7, 23.1), shapely.Point(HOME).buffer(4.1)]
)
ROAD = {"type": "LineString", "coordinates": lon_lat((-12.0, 20.0), (4.0, 20.0))}


@cache
def planned() -> PlannedMission:
    return plan_mission(
        PlanWish(
            mission_id="m-1",
            name="Home field",
            robot_id="weeder-01",
            field_name="Home field",
            parcel=parcel_geometry(SIDE_M),
            width_m=3.0,
            datum_lat_deg=FRAME.lat_deg,
            datum_lon_deg=FRAME.lon_deg,
            angle_rad=math.pi / 2,
            home=tuple(lon_lat(HOME)[0]),  # type: ignore[arg-type]
            returns_home=True,
            surroundings=ways(),
        )
    )


def ways(*obstacles: tuple[float, float, float]) -> Surroundings:
    solid = tuple(({"type": "Point", "coordinates": lon_lat((x, y))[0]}, 2 * r) for x, y, r in obstacles)
    return Surroundings(solid, ((ROAD, 6.0),))


def published(x: float, y: float, r: float, name: str = "Open ditch") -> Surroundings:
    """Return the map with one more obstacle."""
    return replace(ways((x, y, r)), names=(name,))


def at(segment: int, s_m: float) -> Progress:
    return Progress(planned().sha256, segment, s_m)


def rest(progress: Progress, **more: Any) -> PlannedRest:
    usual: dict[str, Any] = {"surroundings": ways(), "revision": 2}
    base = planned()
    return plan_rest(RestWish(base=base.document, base_sha256=base.sha256, progress=progress, **{**usual, **more}))


def standing(x_m: float, y_m: float) -> tuple[float, float, float]:
    lon, lat = lon_lat((x_m, y_m))[0]
    return lon, lat, 0.3


def segments() -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = planned().document["segments"]
    return found


def number_of(row: int) -> int:
    return next(i for i, one in enumerate(segments()) if one["row"] == row)


def work_m(parts: Sequence[Mapping[str, Any]]) -> dict[tuple[str, int], float]:
    found: dict[tuple[str, int], float] = defaultdict(float)
    for one in parts:
        if is_work(one):
            found[one["kind"], one["row"]] += length_m(one)
    return found


def check_is_whole(made: PlannedRest) -> None:
    """The kept path is the old one, the new one joins it, and a robot would take the document."""
    document = made.document
    kept = document["continues"]["segments"]
    assert document["segments"][: max(kept - 1, 0)] == planned().document["segments"][: max(kept - 1, 0)]
    for before, after in zip(document["segments"], document["segments"][1:], strict=False):
        if not after.get("jump"):
            assert math.dist(before["points"][-1], after["points"][0]) < 0.003
    wire = msgspec.convert(document, down.Mission)
    assert wire.continues != msgspec.UNSET
    assert all(len(one["points"]) >= 2 for one in document["segments"])


places = st.tuples(st.integers(0, 200), st.floats(0.0, 1.0))


def placed(place: tuple[int, float]) -> Progress:
    number = place[0] % (len(segments()) - 1)
    return at(number, round(place[1] * length_m(segments()[number]), 2))


@settings(max_examples=60, deadline=None)
@given(place=places)
def test_a_cut_path_is_the_same_path(place: tuple[int, float]) -> None:
    progress = placed(place)
    head, tail, first = cut(segments(), progress.segment, progress.segment_s_m)
    assert len(head) - first in (0, 1)
    assert sum(map(length_m, head)) + sum(map(length_m, tail)) == pytest.approx(
        sum(map(length_m, segments())), abs=0.01
    )


@settings(max_examples=40, deadline=None)
@given(place=places, x=st.floats(4.0, 36.0), y=st.floats(4.0, 36.0))
@pytest.mark.slow
def test_taken_up_from_anywhere_in_the_field_all_work_is_there_once(
    place: tuple[int, float], x: float, y: float
) -> None:
    progress = placed(place)
    assume(pieces_of(planned().document, progress))
    made = rest(progress, stand=standing(x, y))
    check_is_whole(made)
    was, now = work_m(segments()), work_m(made.document["segments"])
    assert set(now) == set(was)
    for piece, length in was.items():
        assert now[piece] == pytest.approx(length, abs=0.02)
    jumps = [i for i, one in enumerate(made.document["segments"]) if one.get("jump")]
    assert jumps == [made.document["continues"]["segments"]]


@settings(max_examples=40, deadline=None)
@given(
    place=places, chosen=st.sets(st.integers(0, 40), max_size=6), is_running=st.booleans(), is_reversed=st.booleans()
)
@pytest.mark.slow
def test_a_changed_rest_keeps_what_is_done_and_leaves_out_only_what_was_said(
    place: tuple[int, float], chosen: set[int], is_running: bool, is_reversed: bool
) -> None:
    progress = placed(place)
    left = pieces_of(planned().document, progress)
    assume(left)
    out = {one.number for i, one in enumerate(left) if i in chosen}
    try:
        made = rest(progress, leave_out=tuple(out), is_running=is_running, is_reversed=is_reversed)
    except PlanRefused as error:
        event(error.code)
        return
    check_is_whole(made)
    kept = made.document["continues"]["segments"]
    new = made.document["segments"][kept:]
    done, _, _ = cut(segments(), progress.segment, progress.segment_s_m)
    stays = made.document["segments"][:kept]
    assert sum(map(length_m, stays)) >= sum(map(length_m, done)) - 0.01
    if is_running:
        assert sum(map(length_m, stays)) >= sum(map(length_m, done)) + AHEAD_M - 0.01
    wanted = work_m([one for one in segments() if is_work(one)])
    for piece, length in work_m([*stays, *new]).items():
        assert length <= wanted[piece] + 0.02, "worked twice"
    skipped = {(one.kind, one.row) for one in left if one.number in out and one.row}
    there = work_m([*stays, *new])
    for piece, length in wanted.items():
        if piece not in skipped and piece[1]:
            assert there[piece] == pytest.approx(length, abs=0.02), "left out"


def test_two_rows_left_out_are_gone_and_the_numbers_say_so() -> None:
    progress = at(number_of(2), 5.0)
    made = rest(progress, leave_out=(number_of(4), number_of(5)))
    rows = {one["row"] for one in made.document["segments"]}
    assert {4, 5}.isdisjoint(rows)
    assert {1, 2, 3, 6, 7} <= rows
    assert made.difference["left_out"] == ["Row 4", "Row 5"]
    assert made.difference["after"]["area_m2"] < made.difference["before"]["area_m2"]
    assert made.difference["after"]["duration_s"] < made.difference["before"]["duration_s"]
    assert made.document["area_m2"] < planned().document["area_m2"]


def test_the_present_row_can_be_left_inside_when_it_is_paused() -> None:
    number = number_of(3)
    made = rest(at(number, 5.0), leave_out=(number,))
    assert work_m(made.document["segments"])["row", 3] == pytest.approx(5.0, abs=0.02)


@pytest.mark.parametrize("s_m", [0.0, 2.0, 5.0])
def test_on_the_way_from_home_the_first_row_can_be_left_out_or_come_last(s_m: float) -> None:
    assert segments()[0]["kind"] == "approach"
    left_out = rest(at(0, s_m), leave_out=(number_of(1),))
    turned = rest(at(0, s_m), is_reversed=True)
    for made in (left_out, turned):
        check_is_whole(made)
        ways_there = [one for one in made.document["segments"] if one["kind"] == "approach"]
        assert math.dist(ways_there[0]["points"][0], HOME) < 0.01
        inside = Ground(FIELD_AND_ROAD, RobotProfile())
        assert all(inside.outside_m(np.asarray(one["points"])) == 0 for one in ways_there)
    assert {one["row"] for one in left_out.document["segments"]} == {one["row"] for one in segments()} - {1}
    assert work_m(turned.document["segments"]).keys() == work_m(segments()).keys()


def test_a_running_robot_finishes_its_row_first() -> None:
    number = number_of(3)
    made = rest(at(number, 5.0), leave_out=(number, number_of(4)), is_running=True)
    assert made.document["continues"]["segments"] == number + 1
    assert "too near row 3" in " ".join(made.difference["notes"])
    assert 4 not in {one["row"] for one in made.document["segments"]}


def test_a_slower_rest_keeps_the_speed_of_what_is_driven_already() -> None:
    made = rest(at(number_of(2), 5.0), row_speed_mps=0.2)
    kept = made.document["continues"]["segments"]
    assert {one["speed_mps"] for one in made.document["segments"][kept:] if is_work(one)} == {0.2}
    assert made.document["segments"][number_of(1)]["speed_mps"] == segments()[number_of(1)]["speed_mps"]
    assert made.difference["after"]["duration_s"] > made.difference["before"]["duration_s"]


def test_a_new_obstacle_is_driven_around() -> None:
    row = next(one for one in segments() if one["row"] == 6)
    x, y = row["points"][0][0], 20.0
    made = rest(at(number_of(2), 5.0), surroundings=ways((x, y, 1.0)))
    for one in made.document["segments"][made.document["continues"]["segments"] :]:
        for point in one["points"]:
            assert math.dist(point, (x, y)) > 1.5
    assert any("Row 6" in note for note in made.difference["notes"])
    assert sum(one["row"] == 6 for one in made.document["segments"]) == 2


def test_it_can_stay_in_the_field_or_go_home_at_the_end() -> None:
    stays = rest(at(number_of(2), 5.0), end="stay")
    assert (stays.document["at_end"], stays.document["segments"][-1]["kind"]) == ("stay", "headland")
    other = rest(at(number_of(2), 5.0), end="home", home=tuple(lon_lat((-6.0, 20.0))[0]))
    assert other.document["at_end"] == "return_home"
    assert math.dist(other.document["segments"][-1]["points"][-1], (-6.0, 20.0)) < 0.01


def test_a_place_without_a_way_is_refused_with_the_way_out() -> None:
    with pytest.raises(PlanRefused, match="Drive it nearer"):
        rest(at(number_of(2), 5.0), stand=standing(500.0, 500.0))


def test_leaving_out_everything_is_refused() -> None:
    progress = at(number_of(2), 5.0)
    everything = tuple(one.number for one in pieces_of(planned().document, progress))
    with pytest.raises(PlanRefused) as caught:
        rest(progress, leave_out=everything)
    assert caught.value.code == "nothing_left"


def test_a_lap_stays_one_lap_through_the_loops_in_its_corners() -> None:
    laps = [one.lap for one in pieces_of(planned().document, at(0, 0.0)) if one.kind == "headland"]
    assert set(laps) == set(range(1, planned().statistics["headland_passes"] + 1))
    assert len(laps) > len(set(laps)), "corners are worked to the tip"


def test_a_lap_goes_on_where_its_corner_is_turned_on_the_spot_and_another_lap_is_another() -> None:
    def lap(*, is_on: bool, pivot: bool) -> dict[str, Any]:
        return {"kind": "headland", "row": 0, "tool_on": is_on, "pivot": pivot, "points": [[0.0, 0.0], [9.0, 0.0]]}

    corner = [lap(is_on=True, pivot=False), lap(is_on=False, pivot=True), lap(is_on=True, pivot=True)]
    pieces = pieces_of({"segments": [*corner, lap(is_on=True, pivot=True)]}, at(0, 0.0))
    assert [one.lap for one in pieces] == [1, 1, 2]


def taken_up_at(row: int, s_m: float, **more: Any) -> PlannedRest:
    """Return a rest of a mission that was taken up at the beginning of a row, where the robot stood."""
    number = number_of(row)
    document = {**planned().document, "segments": [dict(one) for one in segments()]}
    document["segments"][number] |= {"jump": True, "pivot": False}
    # whatever lay before: it ended elsewhere
    points = [[x - 4.0, y] for x, y in document["segments"][number - 1]["points"]]
    document["segments"][number - 1] = {**document["segments"][number - 1], "points": points}
    sha256 = mission_sha256(document)
    progress = Progress(sha256, number, s_m)
    return plan_rest(
        RestWish(base=document, base_sha256=sha256, progress=progress, surroundings=ways(), revision=3, **more)
    )


@pytest.mark.parametrize("s_m", [0.0, 3.0])
@pytest.mark.parametrize("more", [{"is_reversed": True}, {"row_speed_mps": 0.3}, {"leave_out": "this"}, {}])
def test_a_place_where_it_was_taken_up_stays_the_first_of_the_rest_or_goes(s_m: float, more: dict[str, Any]) -> None:
    number = number_of(3)
    made = taken_up_at(3, s_m, **({"leave_out": (number,)} if "leave_out" in more else more))
    new = made.document["segments"][made.document["continues"]["segments"] :]
    # only where nothing of it was driven does the new path begin away from the end of what was
    assert [k for k, one in enumerate(new) if one.get("jump")] == ([0] if s_m == 0 else [])
    assert new[0]["points"][0] == pytest.approx(cut(segments(), number, s_m)[1][0]["points"][0], abs=0.002)
    for before, after in pairwise(new):
        assert math.dist(before["points"][-1], after["points"][0]) < 0.003


def test_of_a_lap_beside_a_new_obstacle_only_what_is_too_near_is_left_out() -> None:
    solid = shapely.Point(38.5, 20).buffer(1.0)
    made = rest(at(number_of(1), 1.0), surroundings=ways((38.5, 20.0, 1.0)))
    check_is_whole(made)
    outer = max((one for one in segments() if one["kind"] == "headland"), key=length_m)
    lost = work_m(segments())["headland", 0] - work_m(made.document["segments"])["headland", 0]
    assert 5 < lost < 0.2 * length_m(outer)
    width_m = RobotProfile().width_m
    new = made.document["segments"][made.document["continues"]["segments"] :]
    assert all(shapely.LineString(one["points"]).distance(solid) > width_m / 2 for one in new)

"""The rest of a mission whose tool has areas of its own: several pieces a row, each with its dose."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import pairwise
from typing import Any

import pytest
import shapely
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

from hmi.domain.mission_document import Document
from hmi.domain.mission_plan import PlannedMission, PlanRefused, PlanWish, Surroundings, TreatedArea, Treatment
from hmi.domain.mission_rest import PlannedRest, Progress, RestWish, is_work, length_m, pieces_of
from hmi.planning.machine import RobotProfile
from hmi.planning.mission import plan_mission
from hmi.planning.rest import _Rest, plan_rest
from tests.hmi.missions.rig import FRAME, lon_lat, parcel_geometry
from tests.hmi.planning.test_rest import places, standing

SHIFT_M = RobotProfile().lead_in_m - RobotProfile().lead_out_m
Place = tuple[float, float, int, float]
"""From and to along a row, the row, the dose."""


def base() -> PlannedMission:
    return planned(None)


@cache
def planned(leads: tuple[float, float] | None) -> PlannedMission:
    """Return a mission; ``leads``: how long the tool is on before and after treated ground."""
    lead_in, lead_out = leads or (None, None)
    return plan_mission(
        PlanWish(
            mission_id="m-1",
            name="Home field",
            robot_id="weeder-01",
            field_name="Home field",
            parcel=parcel_geometry(40.0),
            width_m=3.0,
            datum_lat_deg=FRAME.lat_deg,
            datum_lon_deg=FRAME.lon_deg,
            angle_rad=math.pi / 2,
            treatment=Treatment(
                (area(8, 8, 20, 16, 0.0), area(8, 20, 32, 26, 2.0), area(20, 26, 32, 30, 0.5)),
                lead_in_m=lead_in,
                lead_out_m=lead_out,
            ),
        )
    )


def area(x0: float, y0: float, x1: float, y1: float, dose: float) -> TreatedArea:
    ring = lon_lat((x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0))
    return TreatedArea({"type": "Polygon", "coordinates": [ring]}, dose)


def segments() -> list[Document]:
    found: list[Document] = base().document["segments"]
    return found


def progress_at(place: tuple[int, float]) -> Progress:
    number = place[0] % (len(segments()) - 1)
    return Progress(base().sha256, number, round(place[1] * length_m(segments()[number]), 2))


def rest(progress: Progress, **more: Any) -> PlannedRest:
    return plan_rest(
        RestWish(base=base().document, base_sha256=base().sha256, progress=progress, **{"revision": 2, **more})
    )


def doses_m(parts: Sequence[Mapping[str, Any]]) -> dict[tuple[int, float], float]:
    """Return the metres worked of each row with each dose."""
    found: dict[tuple[int, float], float] = defaultdict(float)
    for one in parts:
        if is_work(one):
            found[one["row"], one.get("dose", 1.0)] += length_m(one)
    return found


def worked_twice_m(parts: Sequence[Mapping[str, Any]]) -> float:
    lines = [shapely.LineString(one["points"]) for one in parts if is_work(one)]
    return sum(line.length for line in lines) - shapely.union_all(lines, grid_size=0.001).length


def same(
    found: Mapping[tuple[int, float], float], wanted: Mapping[tuple[int, float], float], spare: float = 0.0
) -> bool:
    keys = {*found, *wanted}
    return all(math.isclose(found.get(key, 0.0), wanted.get(key, 0.0), abs_tol=0.05 + spare) for key in keys)


def test_the_rows_of_this_mission_have_pieces_with_doses_and_gaps() -> None:
    rows = [one for one in segments() if one["row"] == 5]
    assert {one.get("dose", 1.0) for one in rows} >= {1.0, 2.0}
    assert any(not one["tool_on"] for one in segments() if one["row"])


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(place=places, is_reversed=st.booleans(), is_running=st.booleans())
def test_every_piece_is_done_once_with_its_dose(place: tuple[int, float], is_reversed: bool, is_running: bool) -> None:
    progress = progress_at(place)
    assume(pieces_of(base().document, progress))
    try:
        made = rest(progress, is_reversed=is_reversed, is_running=is_running)
    except PlanRefused as error:
        event(error.code)
        return
    # driven the other way round, each border of the tool lies elsewhere by what it is on longer before than after
    spare = 2 * SHIFT_M if is_reversed else 0.0
    assert same(doses_m(made.document["segments"]), doses_m(segments()), spare)
    assert worked_twice_m(made.document["segments"]) == pytest.approx(worked_twice_m(segments()), abs=0.1)


def toggles(parts: Sequence[Mapping[str, Any]]) -> list[tuple[int, bool, float, float]]:
    """Return row, whether it goes on, way along y (1 or -1) and y of each place where the tool changes in a row."""
    found = []
    for one, then in pairwise(parts):
        is_row = one["row"] and one["row"] == then["row"]
        if is_row and math.dist(one["points"][-1], then["points"][0]) < 0.01 and one["tool_on"] != then["tool_on"]:
            (_, y0), (_, y1) = one["points"][0], one["points"][-1]
            found.append((one["row"], bool(then["tool_on"]), math.copysign(1, y1 - y0), y1))
    return found


@pytest.mark.parametrize("is_reversed", [False, True])
@pytest.mark.parametrize("leads", [None, (0.0, 0.0), (1.0, 0.25), (0.1, 0.4)])
def test_the_tool_is_on_as_long_before_and_after_whichever_way_a_row_is_driven(
    is_reversed: bool, leads: tuple[float, float] | None
) -> None:
    plan = planned(leads)
    lead_in, lead_out = leads or (RobotProfile().lead_in_m, RobotProfile().lead_out_m)
    wish = RestWish(plan.document, plan.sha256, 2, Progress(plan.sha256, 0, 0.0), is_reversed=is_reversed, lead_m=leads)
    places = toggles(plan_rest(wish).document["segments"])
    assert len(places) >= 4
    for _row, is_on, way, y in places:
        border = (8.0 if way < 0 else 16.0) if is_on else (8.0 if way > 0 else 16.0)
        assert y == pytest.approx(border - way * lead_in if is_on else border + way * lead_out, abs=0.01)


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(place=places, x=st.floats(6.0, 34.0), y=st.floats(6.0, 34.0))
def test_taken_up_later_every_piece_is_done_once_with_its_dose(place: tuple[int, float], x: float, y: float) -> None:
    progress = progress_at(place)
    assume(pieces_of(base().document, progress))
    made = rest(progress, stand=standing(x, y))
    assert same(doses_m(made.document["segments"]), doses_m(segments()))


@pytest.mark.parametrize("is_reversed", [False, True])
def test_the_pieces_of_a_row_are_driven_in_one_line(is_reversed: bool) -> None:
    """Between them the tool is off or its dose changes; there is no way around."""
    made = rest(progress_at((0, 0.0)), is_reversed=is_reversed)
    first = made.document["continues"]["segments"]
    parts = made.document["segments"][first:]
    row_5 = [k for k, one in enumerate(parts) if one["row"] == 5]
    assert row_5 == list(range(row_5[0], row_5[-1] + 1))
    driven = sum(length_m(parts[k]) for k in row_5)
    assert driven == pytest.approx(sum(length_m(one) for one in segments() if one["row"] == 5), abs=0.02)


def test_another_speed_keeps_the_dose() -> None:
    made = rest(progress_at((0, 0.0)), row_speed_mps=0.4)
    speeds = {one.get("dose", 1.0): one["speed_mps"] for one in made.document["segments"] if is_work(one)}
    assert speeds == {0.5: 0.4, 1.0: 0.4, 2.0: 0.2}


def test_the_numbers_count_rows_not_pieces() -> None:
    made = rest(progress_at((0, 0.0)))
    assert made.statistics["turns"] == base().statistics["turns"]
    assert made.statistics["energy_j"] == pytest.approx(base().statistics["energy_j"], rel=0.01)


def test_one_piece_left_out_is_driven_through_with_the_tool_off() -> None:
    number = next(i for i, one in enumerate(segments()) if one["row"] == 5 and one.get("dose") == 2.0)
    made = rest(progress_at((0, 0.0)), leave_out=(number,))
    row = [one for one in made.document["segments"] if one["row"] == 5]
    through = [one for one in row if one["points"] == segments()[number]["points"]]
    assert [(one["tool_on"], one.get("dose")) for one in through] == [(False, None)]


def test_the_pieces_of_a_lap_are_told_to_be_of_one_lap() -> None:
    def piece(kind: str, x: float, *, tool_on: bool = True, row: int = 0, pivot: bool = False) -> Document:
        points = [[x, 0.0], [x + 1.0, 0.0]]
        return {"kind": kind, "points": points, "speed_mps": 0.4, "tool_on": tool_on, "row": row, "pivot": pivot}

    lap = [piece("headland", 3), piece("headland", 4, tool_on=False), piece("headland", 5)]
    other = [piece("turn", 6, tool_on=False), piece("headland", 7), piece("headland", 8, pivot=True)]
    path = [piece("row", 1, row=1), piece("turn", 2, tool_on=False), *lap, *other]
    found = pieces_of({"segments": path}, Progress("a" * 64, 0, 0.0))
    assert [(one.row, one.lap) for one in found] == [(1, 0), (0, 1), (0, 1), (0, 2), (0, 3)]


@pytest.mark.parametrize(("aside_m", "along_m"), [(0.0, 1.3), (0.8, 1.3), (0.8, 2.5)])
def test_turned_around_a_piece_cut_by_a_new_obstacle_has_no_gap(aside_m: float, along_m: float) -> None:
    number = next(k for k, one in enumerate(segments()) if one["row"] and not one["tool_on"])
    cut_one, idle = segments()[number - 1 : number + 1]
    assert cut_one["row"] == idle["row"]
    assert cut_one["tool_on"]
    (_, far), (x, y) = cut_one["points"][0], cut_one["points"][-1]
    # the piece loses the end that the idle one goes on from, and the idle one itself is free
    there = lon_lat((x + aside_m, y + math.copysign(along_m, far - y)))[0]
    solid = Surroundings((({"type": "Point", "coordinates": there}, 0.4),))
    made = rest(Progress(base().sha256, 0, 1.0), is_reversed=True, surroundings=solid)
    assert any(f"Row {idle['row']}" in note for note in made.difference["notes"])
    path = made.document["segments"]
    assert all(math.dist(a["points"][-1], b["points"][0]) < 0.003 for a, b in pairwise(path))


def test_a_path_with_a_gap_is_refused_before_it_is_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_Rest, "_way", lambda *_, **__: [])
    with pytest.raises(PlanRefused, match=r"gap of \d+\.\d\d m ") as caught:
        rest(Progress(base().sha256, 0, 1.0), is_reversed=True)
    assert caught.value.code == "gap"

"""The rest of a mission whose rows follow a curved line: rows stay curved, cut pieces too."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from backend_clients.edge import messages_down as down
from backend_clients.simulator.route import Route
from hmi.domain.mission_plan import PlannedMission, PlanWish, RowLine, Rows, Surroundings, TreatedArea, Treatment
from hmi.domain.mission_rest import Progress, RestWish, is_work, length_m, pieces_of
from hmi.planning.mission import plan_mission
from hmi.planning.plan import GENTLE_RAD, headings
from hmi.planning.rest import plan_rest
from tests.backend_clients.simulator.test_path_following import drive
from tests.hmi.missions.rig import FRAME, lon_lat, parcel_geometry
from tests.hmi.planning.lines import wave
from tests.hmi.planning.test_rest import places, standing

WET = [(12.0, 12.0), (20.0, 12.0), (20.0, 20.0), (12.0, 20.0), (12.0, 12.0)]


@cache
def planned() -> PlannedMission:
    line = lon_lat(*((float(x), float(y)) for x, y in wave(-2.0, 42.0, 18.0, high_m=5.0, long_m=15.0)))
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
            treatment=Treatment((TreatedArea({"type": "Polygon", "coordinates": [lon_lat(*WET)]}, 0.0),)),
            rows=Rows.GUIDE_LINE,
            row_lines=(RowLine("Guide", tuple((lon, lat) for lon, lat in line)),),
        )
    )


def segments() -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = planned().document["segments"]
    return found


def work_m(parts: list[dict[str, Any]]) -> dict[int, float]:
    found: dict[int, float] = {}
    for one in parts:
        if is_work(one) and one["row"]:
            found[one["row"]] = found.get(one["row"], 0.0) + length_m(one)
    return found


def sharpest_rad(parts: list[dict[str, Any]]) -> float:
    turns = [np.diff(headings(np.asarray(one["points"]))) for one in parts if len(one["points"]) > 2]
    return float(np.abs(np.angle(np.exp(1j * np.concatenate(turns)))).max())


def rest(progress: Progress, **more: Any) -> list[dict[str, Any]]:
    base = planned()
    usual: dict[str, Any] = {"surroundings": Surroundings(), "revision": 2}
    made = plan_rest(RestWish(base=base.document, base_sha256=base.sha256, progress=progress, **{**usual, **more}))
    found: list[dict[str, Any]] = made.document["segments"]
    return found


def test_the_mission_has_curved_rows_with_the_tool_off_in_an_area() -> None:
    rows = [one for one in segments() if one["kind"] == "row"]
    assert sum(len(one["points"]) > 4 for one in rows) > len(rows) / 2
    assert any(not one["tool_on"] for one in rows)
    assert planned().statistics["rows_along"] == "guide_line"
    assert sharpest_rad(segments()) <= GENTLE_RAD


@settings(max_examples=12, deadline=None)
@given(place=places, x=st.floats(5.0, 35.0), y=st.floats(5.0, 35.0), is_reversed=st.booleans())
@pytest.mark.slow
def test_taken_up_anywhere_all_work_is_there_once_along_the_same_curves(
    place: tuple[int, float], x: float, y: float, is_reversed: bool
) -> None:
    number = place[0] % (len(segments()) - 1)
    progress = Progress(planned().sha256, number, round(place[1] * length_m(segments()[number]), 2))
    assume(pieces_of(planned().document, progress))
    now = rest(progress, stand=standing(x, y), is_reversed=is_reversed)
    was = work_m(segments())
    assert work_m(now) == pytest.approx(was, abs=0.4)  # a border of the tool moves when driven the other way round
    assert sharpest_rad(now) <= GENTLE_RAD
    rows = shapely.MultiLineString([one["points"] for one in segments() if one["kind"] == "row"])
    driven = shapely.points([p for one in now if one["kind"] == "row" for p in one["points"]])
    assert shapely.distance(driven, rows).max() < 0.01


def test_a_new_obstacle_cuts_curved_rows_and_the_ways_go_around_it() -> None:
    stone = {"type": "Point", "coordinates": lon_lat((28.0, 25.0))[0]}
    start = Progress(planned().sha256, 0, 0.0)
    now = rest(start, stand=standing(20.0, 3.0), surroundings=Surroundings(((stone, 2.0),)))
    path = shapely.MultiLineString([one["points"] for one in now])
    assert path.distance(shapely.Point(28.0, 25.0)) > 1.5
    assert sum(work_m(now).values()) < sum(work_m(segments()).values()) - 4
    assert sharpest_rad(now) <= GENTLE_RAD


@pytest.mark.slow
def test_a_simulated_robot_keeps_to_the_curves_and_takes_the_time_that_was_planned() -> None:
    planned_s = planned().statistics["duration_s"]
    route = Route(msgspec.convert(planned().document, down.Mission).segments)
    (x, y), (ahead_x, ahead_y) = segments()[0]["points"][:2]
    _, seconds, errors = drive(route, x, y, math.atan2(ahead_y - y, ahead_x - x), 2 * planned_s)
    assert max(errors) < 0.05
    assert seconds == pytest.approx(planned_s, rel=0.05)

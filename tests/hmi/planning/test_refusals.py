"""What cannot be planned is refused with what is wrong and what to change, never with an error of the planner."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
import shapely

from hmi.domain.mission_plan import PlanRefused, RowLine, Rows, Surroundings
from hmi.domain.robot import Factsheet
from hmi.planning.mission import plan_mission
from tests.hmi.missions.rig import lon_lat
from tests.hmi.missions.test_document import wish
from tests.hmi.presenters.robots import SHEET

NAN = math.nan
STEERED = replace(SHEET, can_pivot=False, turning_radius_m=1.5)


def box(*bounds: float) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": [lon_lat(*shapely.box(*bounds).exterior.coords)]}


def stone(place: list[float], wide_m: float) -> Surroundings:
    return Surroundings((({"type": "Point", "coordinates": place}, wide_m),))


@pytest.mark.parametrize(
    "around",
    [stone(lon_lat((20, 20))[0], NAN), stone([NAN, NAN], 1.0), stone([math.inf, 51.78], 1.0)],
    ids=["size", "place", "infinite"],
)
def test_an_obstacle_that_is_nowhere_is_not_left_out(around: Surroundings) -> None:
    with pytest.raises(PlanRefused, match="not a number") as refused:
        plan_mission(wish(surroundings=around))
    assert refused.value.code == "bad_map"


@pytest.mark.parametrize("most_mps", [NAN, 0.0, -1.0])
def test_a_slow_zone_has_a_speed(most_mps: float) -> None:
    with pytest.raises(PlanRefused, match="no speed above 0"):
        plan_mission(wish(surroundings=Surroundings(slow=((box(5, 5, 9, 9), most_mps),))))


@pytest.mark.parametrize(
    "sheet",
    [replace(SHEET, battery_wh=0.0), replace(SHEET, battery_wh=NAN), replace(SHEET, tool_width_m=-1.0)],
    ids=["empty", "unknown", "narrower than nothing"],
)
def test_a_machine_that_cannot_be_is_refused(sheet: Factsheet) -> None:
    with pytest.raises(PlanRefused, match="must be positive"):
        plan_mission(wish(robot=sheet))


def test_a_row_distance_of_the_map_that_is_none_is_refused() -> None:
    lines = tuple(RowLine(str(x), (*map(tuple, lon_lat((x, -1), (x, 41))),)) for x in range(2, 40, 3))  # type: ignore[arg-type]
    with pytest.raises(PlanRefused, match="row distance of the field"):
        plan_mission(wish(rows=Rows.RECORDED_ROWS, row_lines=lines, row_spacing_m=NAN))


def test_a_field_that_is_all_headland_says_with_how_many_laps_it_can_be_worked() -> None:
    with pytest.raises(PlanRefused, match="Choose 0 headland passes") as refused:
        plan_mission(wish(parcel=box(0, 0, 200, 4)))
    assert refused.value.field == "headland_passes"
    assert plan_mission(wish(parcel=box(0, 0, 200, 4), headland_passes=0)).statistics["rows"] == 1
    with pytest.raises(PlanRefused, match="Choose 3 headland passes"):
        plan_mission(wish(headland_passes=9, width_m=5.0, parcel=box(0, 0, 31, 31)))
    assert plan_mission(wish(headland_passes=3, width_m=5.0, parcel=box(0, 0, 31, 31))).statistics["rows"] >= 1


def test_a_field_too_narrow_to_turn_in_asks_for_another_robot() -> None:
    with pytest.raises(PlanRefused, match="too narrow for this machine to turn in: choose another robot"):
        plan_mission(wish(parcel=box(0, 0, 200, 2.5)))
    with pytest.raises(PlanRefused, match="needs it to turn: choose another robot, or a smaller working width"):
        plan_mission(wish(parcel=box(0, 0, 30, 7), robot=STEERED))
    with pytest.raises(PlanRefused, match="fits nowhere on this field"):
        plan_mission(wish(parcel=box(0, 0, 30, 1.8)))

"""A UAV is planned as what it is: quick, straight to its field, over what is low enough, around all that may not be."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely

from hmi.commands.plan_wish import PlanOrder, surroundings_of, wish_for
from hmi.domain.mission_plan import PlannedMission, PlanRefused, StartPlace
from hmi.domain.mission_rest import Progress, RestWish
from hmi.domain.robot import Factsheet, Family
from hmi.planning.coverage import plan_coverage
from hmi.planning.flight import HEIGHT_UNKNOWN
from hmi.planning.given_path import checked_candidate, segments_of
from hmi.planning.machine import RobotProfile
from hmi.planning.mission import job_of, plan_candidate, plan_mission
from hmi.planning.projection import LocalFrame
from hmi.planning.rest import plan_rest
from hmi.store.features import Feature
from tests.hmi.missions.rig import FARM, FRAME, farm_map, lon_lat
from tests.hmi.presenters.robots import SHEET

KITE = replace(
    SHEET,
    family=Family.UAV,
    datum_lat_deg=FRAME.lat_deg,
    datum_lon_deg=FRAME.lon_deg,
    length_m=0.9,
    width_m=0.9,
    base_to_front_m=0.45,
    max_speed_mps=8.0,
    max_accel_mps2=2.0,
    max_yaw_rate_radps=1.5,
    tool_kind="camera",
    tool_width_m=20.0,
    path_height_m=30.0,
)
WEEDER = replace(SHEET, datum_lat_deg=FRAME.lat_deg, datum_lon_deg=FRAME.lon_deg)
ORDER = PlanOrder("field-1", "uav-01", 10.0)
ZONE = shapely.box(10, 12, 16, 18)


def box(left: float, low: float, right: float, high: float) -> dict[str, Any]:
    ring = ((left, low), (right, low), (right, high), (left, high), (left, low))
    return {"type": "Polygon", "coordinates": [lon_lat(*ring)]}


def feature(kind: str, geometry: dict[str, Any], name: str = "", **properties: Any) -> Feature:
    return Feature(f"new-{kind}", FARM, kind, name, geometry, properties)


def low_map() -> list[Feature]:
    """Return the map with nothing on it that stands in the air."""
    good = (one for one in farm_map() if one.id != "bow-tie")
    return [replace(one, properties={**one.properties, "height_m": 8.0}) for one in good]


def planned(*more: Feature, sheet: Factsheet = KITE) -> PlannedMission:
    features = low_map()
    field = next(one for one in features if one.id == ORDER.field_id)
    return plan_mission(wish_for(ORDER, "m-1", field, [*features, *more], sheet))


def path_of(document: dict[str, Any]) -> list[shapely.LineString]:
    frame = LocalFrame(document["datum"]["lat_deg"], document["datum"]["lon_deg"])
    return [
        shapely.LineString(FRAME.to_local(frame.to_lon_lat(np.asarray(one["points"])))) for one in document["segments"]
    ]


def test_it_is_planned_with_the_speeds_of_what_flies_and_never_above_its_own() -> None:
    usual = RobotProfile.from_factsheet(KITE)
    assert (usual.row_speed_mps, usual.turn_speed_mps, usual.transit_speed_mps) == (5.0, 3.0, 7.0)
    slow = RobotProfile.from_factsheet(replace(KITE, max_speed_mps=2.0, max_accel_mps2=0.5, max_yaw_rate_radps=0.4))
    assert (slow.row_speed_mps, slow.turn_speed_mps, slow.transit_speed_mps) == (2.0, 2.0, 2.0)
    assert (slow.accel_mps2, slow.yaw_rate_radps) == (0.5, 0.4)
    weeder = RobotProfile.from_factsheet(SHEET)
    assert (weeder.row_speed_mps, weeder.turn_speed_mps, weeder.flies) == (0.45, 0.3, False)
    rows = [one for one in planned().document["segments"] if one["kind"] == "row"]
    assert {one["speed_mps"] for one in rows} == {5.0}


def test_it_takes_no_headland_and_flies_straight_to_the_field() -> None:
    document = planned().document
    assert not any(one["kind"] == "headland" for one in document["segments"])
    ways = [one for one in document["segments"] if one["kind"] == "approach"]
    assert all(len(one["points"]) == 2 or one["speed_mps"] > 0.6 for one in ways)
    (first, *_), last = path_of(document)[0].coords, path_of(document)[len(ways) - 1].coords[-1]
    flown = sum(shapely.LineString(line).length for line in path_of(document)[: len(ways)])
    assert flown < 1.1 * shapely.Point(first).distance(shapely.Point(last)) + 5


@pytest.mark.parametrize(
    ("kind", "height_m"),
    [("obstacle", 24.9), ("building", 8.0), ("hedge", 3.0), ("tree", 12), ("water", None), ("hole", None)],
)
def test_it_flies_over_what_is_lower_than_it_flies_by_the_clearance(kind: str, height_m: float | None) -> None:
    over = planned(feature(kind, box(10, 12, 16, 18), height_m=height_m))
    assert over.document["segments"] == planned().document["segments"]
    assert over.statistics["notes"] == planned().statistics["notes"]
    assert "It flies 30 m above the ground, over water and what is lower than 25 m" in over.statistics["notes"][-1]


@pytest.mark.parametrize("kind", ["obstacle", "building", "hedge", "tree"])
@pytest.mark.parametrize("height_m", [25.0, 80, None, "12", True, -3, float("nan")])
def test_it_flies_around_what_reaches_its_height_or_has_none_that_is_one(kind: str, height_m: Any) -> None:
    found = planned(feature(kind, box(10, 12, 16, 18), "Silo", height_m=height_m))
    assert all(line.distance(ZONE) > 2.0 for line in path_of(found.document))
    told = "Flown around, for the map has no height of it: Silo. Enter its height on the map to fly over it."
    assert (told in found.statistics["notes"]) == (height_m not in (25.0, 80))


def test_its_ways_keep_off_too_and_a_road_through_trees_is_no_gap_in_the_air() -> None:
    wall = box(-12, -30, -8, 60)
    found = planned(feature("tree", wall, "Poplars", height_m=28))
    assert any(one["kind"] == "approach" for one in found.document["segments"])
    assert all(line.distance(shapely.box(-12, -30, -8, 60)) > 2.0 for line in path_of(found.document))


def test_what_lies_neither_over_the_field_nor_on_the_way_is_not_named() -> None:
    aside = planned(feature("building", box(300, 300, 310, 310), "Far barn"))
    assert not any("Far barn" in note for note in aside.statistics["notes"])
    many = [replace(feature("tree", box(x, 12, x + 1, 13), f"Tree {x}"), id=f"t-{x}") for x in (8, 14, 20, 26, 32)]
    [told] = [note for note in planned(*many).statistics["notes"] if "Flown around" in note]
    assert "Tree 8, Tree 14, Tree 20 and 2 more. Enter their heights on the map to fly over them." in told


def test_a_robot_that_does_not_say_how_high_it_flies_flies_around_everything() -> None:
    silent = replace(KITE, path_height_m=None)
    found = planned(feature("hedge", box(10, 12, 16, 18), "Low hedge", height_m=1.0), sheet=silent)
    assert all(line.distance(ZONE) > 2.0 for line in path_of(found.document))
    assert HEIGHT_UNKNOWN in found.statistics["notes"]
    assert not any("Enter its height" in note for note in found.statistics["notes"])


def test_a_refusal_names_what_has_no_height() -> None:
    ring = shapely.Point(-30, 10).buffer(60).difference(shapely.Point(-30, 10).buffer(12))
    outline = [lon_lat(*ring.exterior.coords), *(lon_lat(*one.coords) for one in ring.interiors)]
    with pytest.raises(PlanRefused, match=r"no height of it: Yard wall\. Enter its height"):
        planned(feature("obstacle", {"type": "Polygon", "coordinates": outline}, "Yard wall"))
    with pytest.raises(PlanRefused, match="no height of it: Glasshouse"):
        planned(feature("building", box(-100, -100, 200, 200), "Glasshouse"), sheet=KITE)


def test_it_keeps_out_of_a_zone_with_room_for_its_fix_in_the_field_and_on_the_way() -> None:
    assert any(line.intersects(ZONE) for line in path_of(planned().document))
    found = planned(feature("no-go", box(10, 12, 16, 18)))
    assert all(line.distance(ZONE) > 2.0 for line in path_of(found.document))
    wall = feature("no-go", box(-12, -30, -8, 60))
    assert all(line.distance(shapely.box(-12, -30, -8, 60)) > 2.0 for line in path_of(planned(wall).document))


def test_where_a_zone_shuts_home_in_it_says_so_and_asks_for_no_road() -> None:
    ring = shapely.Point(-30, 10).buffer(60).difference(shapely.Point(-30, 10).buffer(12))
    outline = [lon_lat(*ring.exterior.coords), *(lon_lat(*one.coords) for one in ring.interiors)]
    with pytest.raises(PlanRefused, match="keep-out zone or something that stands lies around home") as caught:
        planned(feature("no-go", {"type": "Polygon", "coordinates": outline}))
    assert "road" not in caught.value.text


def test_the_picture_has_no_road_as_wide_as_the_sky() -> None:
    features = farm_map()
    wish = wish_for(ORDER, "m-1", features[0], [one for one in features if one.id != "bow-tie"], KITE)
    assert plan_candidate(wish).drawing["places"]["roads"] == []


def test_a_rest_flies_over_and_around_the_same() -> None:
    base = planned()
    row = next(k for k, one in enumerate(base.document["segments"]) if one["row"] == 1)
    field = farm_map()[0]
    zone = feature("no-go", box(30, 12, 36, 18))
    low, high = feature("hedge", box(20, 0, 21, 40), height_m=2.5), feature("tree", box(30, 24, 36, 28), "Poplars")
    around = surroundings_of([zone, low, high], field.geometry, field.id, KITE)
    wish = RestWish(base.document, base.sha256, 2, Progress(base.sha256, row, 1.0), robot=KITE, surroundings=around)
    made = plan_rest(wish)
    lines = path_of(made.document)[made.document["continues"]["segments"] :]
    assert all(line.distance(shapely.box(30, 12, 36, 18)) > 2.0 for line in lines)
    assert all(line.distance(shapely.box(30, 24, 36, 28)) > 2.0 for line in lines)
    assert any(line.intersects(shapely.box(20, 0, 21, 40)) for line in lines)
    assert any("no height of it: Poplars" in note for note in made.difference["notes"])


def test_its_own_path_keeps_the_rules_asked_of_paths_from_elsewhere() -> None:
    features = low_map()
    wish = wish_for(ORDER, "m-1", features[0], [*features, feature("no-go", box(10, 12, 16, 18))], KITE)
    plan = plan_coverage(job_of(wish))
    found = checked_candidate(wish, segments_of(plan.legs), ())
    assert found.statistics["duration_s"] == pytest.approx(plan.figures.duration_s)
    assert any("It flies 30 m above the ground" in note for note in found.statistics["notes"])


@pytest.mark.parametrize(("sheet", "laps"), [(KITE, None), (WEEDER, 0)], ids=["uav", "weeder without laps"])
@pytest.mark.parametrize("is_reversed", [False, True], ids=["a row left out", "turned around"])
def test_a_rest_can_be_changed_where_rows_end_on_the_border(
    sheet: Factsheet, laps: int | None, is_reversed: bool
) -> None:
    field = farm_map()[0]
    order = replace(ORDER, width_m=4.0, row_bearing_deg=17.0, headland_passes=laps, starts_at=StartPlace.FIELD)
    base = plan_mission(wish_for(order, "m-1", field, [field], sheet))
    assert not any(one["kind"] == "headland" for one in base.document["segments"])
    rows = [k for k, one in enumerate(base.document["segments"]) if one["kind"] == "row"]
    left_out = () if is_reversed else (rows[2],)
    around = surroundings_of([], field.geometry, field.id, sheet)
    progress = Progress(base.sha256, rows[0], 1.0)
    wish = RestWish(base.document, base.sha256, 2, progress, robot=sheet, surroundings=around)
    made = plan_rest(replace(wish, leave_out=left_out, is_reversed=is_reversed))
    numbers = list(dict.fromkeys(one["row"] for one in made.document["segments"] if one["row"]))
    usual = [base.document["segments"][k]["row"] for k in rows]
    assert numbers == ([usual[0], *usual[:0:-1]] if is_reversed else [*usual[:2], *usual[3:]])

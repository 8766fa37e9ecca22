"""What of the map is closed to a machine, and how far around a field it is looked for."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely

from hmi.commands.plan_wish import PlanOrder, surroundings_of, wish_for
from hmi.domain.mission_document import Document
from hmi.domain.mission_plan import PlanRefused, StartPlace
from hmi.planning.mission import plan_mission
from hmi.store.errors import NotFound
from hmi.store.features import Feature
from tests.hmi.missions.rig import FARM, FRAME, farm_map, lon_lat

ORDER = PlanOrder("field-1", "weeder-01", 3.0)
SQUARE = ((15, 24), (25, 24), (25, 34), (15, 34), (15, 24))


def polygon(*corners: tuple[float, float]) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": [lon_lat(*corners)]}


def line(*places: tuple[float, float]) -> dict[str, Any]:
    return {"type": "LineString", "coordinates": lon_lat(*places)}


def point(*place: float) -> dict[str, Any]:
    return {"type": "Point", "coordinates": lon_lat((place[0], place[1]))[0]}


def feature(kind: str, geometry: dict[str, Any], **properties: Any) -> Feature:
    return Feature(f"new-{kind}", FARM, kind, "", geometry, properties)


def planned(*more: Feature, order: PlanOrder = ORDER) -> Document:
    features = [one for one in farm_map() if one.id not in ("pylon-1", "bow-tie")]
    field = next(one for one in features if one.id == order.field_id)
    return plan_mission(wish_for(order, "m-1", field, [*features, *more], None)).document


def metres_over(document: Document, area: shapely.Geometry) -> float:
    """Return how much of a path lies on an area given in metres of the farm."""
    from hmi.planning.projection import LocalFrame

    frame = LocalFrame(document["datum"]["lat_deg"], document["datum"]["lon_deg"])
    paths = (FRAME.to_local(frame.to_lon_lat(np.asarray(one["points"]))) for one in document["segments"])
    return sum(shapely.LineString(path).intersection(area).length for path in paths)


@pytest.mark.parametrize("kind", ["water", "hedge", "tree", "obstacle", "building", "no-go"])
def test_no_path_leads_over_ground_that_is_closed(kind: str) -> None:
    assert metres_over(planned(), shapely.Polygon(SQUARE)) > 25
    assert metres_over(planned(feature(kind, polygon(*SQUARE))), shapely.Polygon(SQUARE)) == 0


@pytest.mark.parametrize(
    ("one", "closed"),
    [
        (feature("water", line((0, 20), (40, 20))), shapely.box(0, 18, 40, 22)),
        (feature("hedge", line((0, 20), (40, 20))), shapely.box(0, 17.5, 40, 22.5)),
        (feature("hedge", line((0, 20), (40, 20)), width_m=1.0), shapely.box(0, 19.5, 40, 20.5)),
        (feature("tree", point(20, 20)), shapely.Point(20, 20).buffer(2.4)),
        (feature("tree", point(20, 20), radius_m=6.0), shapely.Point(20, 20).buffer(5.9)),
    ],
)
def test_what_has_no_width_is_as_wide_as_it_is_drawn(one: Feature, closed: shapely.Geometry) -> None:
    assert metres_over(planned(one), closed) == 0


def kinds(document: Document) -> set[str]:
    return {one["kind"] for one in document["segments"]}


def test_a_road_drawn_across_a_ditch_is_a_bridge_and_across_a_keep_out_zone_it_is_closed() -> None:
    ditch = feature("water", line((-10, -30), (-10, 60)))
    document = planned(ditch)
    assert {"approach", "exit"} <= kinds(document)
    beside = shapely.box(-12, -30, -8, 60).difference(shapely.box(-30, 7, 4, 13))
    assert metres_over(document, beside) == 0
    zone = feature("no-go", polygon((-12, -30), (-8, -30), (-8, 60), (-12, 60), (-12, -30)))
    with pytest.raises(PlanRefused, match="No known way leads from home"):
        planned(zone)


def test_a_zone_counts_wherever_its_first_corner_is() -> None:
    far = polygon((-9000, 30), (20, 30), (20, 36), (-9000, 36), (-9000, 30))
    assert metres_over(planned(feature("no-go", far)), shapely.box(0, 30, 20, 36)) == 0
    road = feature("road", line((-3500, 10), (-30, 10)), width_m=4.0)
    field = farm_map()[0]
    assert len(surroundings_of([road], field.geometry, field.id).ways) == 1


def test_what_lies_beyond_three_kilometres_of_the_field_is_another_site() -> None:
    field = farm_map()[0]
    beyond = feature("obstacle", point(-3010, 20), radius_m=1.0)
    assert surroundings_of([beyond], field.geometry, field.id).obstacles == ()


def test_a_field_at_longitude_180_has_neighbours_on_both_sides() -> None:
    ring = [[179.999, 10.0], [179.9999, 10.0], [179.9999, 10.001], [179.999, 10.0]]
    across = feature("obstacle", {"type": "Point", "coordinates": [-179.9999, 10.0]}, radius_m=1.0)
    found = surroundings_of([across], {"type": "Polygon", "coordinates": [ring]}, "field-1")
    assert len(found.obstacles) == 1


def test_a_mission_that_starts_at_the_field_has_no_way_from_home_and_back() -> None:
    from_home = planned()
    assert [from_home["segments"][end]["kind"] for end in (0, -1)] == ["approach", "exit"]
    at_field = planned(order=replace(ORDER, starts_at=StartPlace.FIELD))
    assert {one["kind"] for one in at_field["segments"]} & {"approach", "exit"} == set()
    assert (at_field["home"], at_field["at_end"]) == (None, "stay")


def test_a_home_that_is_not_on_the_map_is_not_replaced_by_another() -> None:
    with pytest.raises(NotFound, match="no home 'gone'"):
        planned(order=replace(ORDER, home_id="gone"))

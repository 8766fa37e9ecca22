"""What changed, in sentences."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given

from hmi.mapping.diff import compare
from hmi.mapping.feature import MapFeature, parse_feature
from tests.hmi.mapping.farms import area, box, degrees, do, draft, fields, line, point, raw

NORTH = area("north", box(0, 0, 120, 100), name="North", crop="Wheat", row_bearing_deg=11.5, row_spacing_m=0.5)


def texts(old: MapFeature, new: MapFeature) -> list[tuple[str, str]]:
    return [(one.what, one.text) for one in compare([old], [new])]


def test_nothing_changed_is_nothing() -> None:
    assert compare([NORTH], [NORTH]) == []


@given(fields())
def test_a_map_does_not_differ_from_itself(north: MapFeature) -> None:
    assert compare([north], [north]) == []


def test_added_and_removed_features_are_named_with_their_size() -> None:
    lane = line("lane", [(0, 0), (80, 0)], name="Lane")
    home = point("home", (0, 0), name="Home")
    found = compare([NORTH], [lane, home])
    assert [(one.id, one.name, one.kind, one.what, one.text) for one in found] == [
        ("lane", "Lane", "road", "added", "Added, 80 m"),
        ("home", "Home", "home", "added", "Added"),
        ("north", "North", "parcel", "removed", "Removed, 1.20 ha"),
    ]
    assert found[0].as_json() == {"id": "lane", "name": "Lane", "kind": "road", "what": "added", "text": "Added, 80 m"}


def test_a_corner_that_moved_is_numbered_and_measured() -> None:
    new = area("north", [(0, 0), (121.4, 0), (120, 100), (0, 100), (0, 0)], name="North", **NORTH.properties)
    assert texts(NORTH, new) == [("moved", "Corner 2 moved 1.4 m"), ("changed", "Area 1.20 ha to 1.21 ha")]


def test_corners_that_moved_are_counted() -> None:
    new = area("north", [(0, 0), (121.4, 0), (122, 100), (0, 100), (0, 0)], name="North", **NORTH.properties)
    assert texts(NORTH, new)[0] == ("moved", "2 corners moved, up to 2.0 m")


def test_a_feature_that_moved_as_a_whole_says_how_far() -> None:
    after = do("shift", draft(NORTH), ["north"], east_m=3, north_m=4)["north"]
    assert texts(NORTH, after) == [("moved", "Moved 5.0 m")]
    home = point("home", (0, 0))
    assert texts(home, point("home", (0, 0.05))) == [("moved", "Moved 5.0 cm")]
    assert texts(home, point("home", (0, 2500))) == [("moved", "Moved 2.5 km")]


def test_added_and_removed_corners_are_counted() -> None:
    more = area("north", [(0, 0), (60, -1), (120, 0), (120, 100), (0, 100), (0, 0)], name="North", **NORTH.properties)
    assert texts(NORTH, more)[0] == ("moved", "Corner 2 added")
    assert texts(more, NORTH)[0] == ("moved", "Corner 2 removed")


def test_holes_added_and_removed_are_told() -> None:
    holed = do("add_hole", draft(NORTH), ["north"], ring=degrees(box(10, 10, 30, 30)))["north"]
    assert texts(NORTH, holed) == [("changed", "Hole added"), ("changed", "Area 1.20 ha to 1.16 ha")]
    assert texts(holed, NORTH) == [("changed", "Hole removed"), ("changed", "Area 1.16 ha to 1.20 ha")]
    wider = area("north", box(0, 0, 120, 100), box(10, 10, 32, 30)[::-1], name="North", **NORTH.properties)
    assert texts(holed, wider)[0] == ("moved", "2 corners moved, up to 2.0 m (hole 1)")


def test_a_turned_outline_is_no_move() -> None:
    wrong = area("north", box(0, 0, 120, 100)[::-1], name="North", **NORTH.properties)
    assert texts(wrong, NORTH) == [("moved", "Direction turned round")]


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        ("row_bearing_deg", 9, "Row direction 11.5 to 9.0 degrees"),
        ("row_bearing_deg", 11.52, "Row direction 11.5 to 11.52 degrees"),
        ("row_spacing_m", 0.45, "Row spacing 0.50 to 0.45 m"),
        ("row_spacing_m", None, "Row spacing removed, was 0.5 m"),
        ("headland_m", 6, "Headland set to 6 m"),
        ("crop", "Maize", "Crop Wheat to Maize"),
        ("crop", None, "Crop removed, was Wheat"),
        ("seeded", "2026-04-08", "Seeded set to 2026-04-08"),
        ("status", "BBCH 14", "Growth stage set to BBCH 14"),
        ("note", {"a": 1}, "note set to other values"),
    ],
)
def test_attributes_are_told_in_words(key: str, value: Any, text: str) -> None:
    properties = {k: v for k, v in {**NORTH.properties, key: value}.items() if v is not None}
    assert texts(NORTH, replace(NORTH, properties=properties)) == [("changed", text)]


def test_name_kind_and_type_of_shape_are_told() -> None:
    assert texts(NORTH, replace(NORTH, name="Nordfeld")) == [("changed", "Name North to Nordfeld")]
    assert texts(NORTH, replace(NORTH, kind="no-go")) == [("changed", "Kind parcel to keep-out zone")]
    tree = parse_feature(raw("tree", "tree", {"type": "Point", "coordinates": degrees([(0, 0)])[0]}))
    assert texts(tree, area("tree", box(0, 0, 5, 5), kind="tree")) == [("changed", "Shape Point to Polygon")]

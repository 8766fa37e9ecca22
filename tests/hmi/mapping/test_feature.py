"""What is a feature, and what is told about one that is not."""

from __future__ import annotations

import json
import math
import pickle
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.demo import farm
from hmi.mapping.coordinates import MOST_VERTICES
from hmi.mapping.errors import BadFeature, BadWalk, MappingError, OperationRefused
from hmi.mapping.feature import MapFeature, as_geojson, collection, parse_feature
from hmi.mapping.kinds import KINDS
from tests.hmi.mapping.farms import box, degrees, fields, raw, scribbles

SQUARE = [[4.2, 51.7], [4.21, 51.7], [4.21, 51.71], [4.2, 51.71], [4.2, 51.7]]
POLYGON = {"type": "Polygon", "coordinates": [SQUARE]}
ROAD = {"type": "LineString", "coordinates": SQUARE[:2]}
POINT = {"type": "Point", "coordinates": [4.2, 51.7]}
SHAPES = {
    "Polygon": POLYGON,
    "LineString": ROAD,
    "Point": POINT,
    "MultiLineString": {"type": "MultiLineString", "coordinates": [SQUARE[:2], SQUARE[2:4]]},
}


def refusal(feature: Any) -> BadFeature:
    with pytest.raises(BadFeature) as caught:
        parse_feature(feature)
    assert caught.value.text.endswith(".")
    return caught.value


def test_every_kind_takes_its_shapes_and_no_other() -> None:
    for kind, rule in KINDS.items():
        for name, geometry in SHAPES.items():
            feature = raw("one", kind, geometry, **({"radius_m": 2} if kind == "obstacle" else {}))
            if name in rule.geometries:
                assert parse_feature(feature).geometry["type"] == name
            else:
                assert refusal(feature).code == "wrong_geometry"


def test_id_kind_and_name_are_not_among_the_properties() -> None:
    feature = parse_feature(raw("north", "parcel", POLYGON, crop="Maize", site="polder"))
    assert feature == MapFeature("north", "parcel", "North", POLYGON, {"crop": "Maize", "site": "polder"})


def test_the_demo_farm_is_a_map() -> None:
    for one in farm.features():
        feature = parse_feature(raw(one.id, one.kind, one.geometry, name=one.name, **one.properties))
        assert feature.properties == one.properties


def test_a_feature_survives_the_way_out_and_in() -> None:
    feature = parse_feature(raw("north", "parcel", POLYGON, crop="Maize", note={"a": [1, None, True]}))
    again = json.loads(json.dumps(collection([feature])))["features"][0]
    assert parse_feature(again) == feature


@pytest.mark.slow
@given(st.one_of(fields(), scribbles()))
def test_any_drawn_feature_survives_the_way_out_and_in(feature: MapFeature) -> None:
    assert parse_feature(json.loads(json.dumps(as_geojson(feature)))) == feature


def test_coordinates_are_kept_to_the_millimetre() -> None:
    feature = parse_feature(raw("home", "home", {"type": "Point", "coordinates": [4.1234567891, -0.000000001]}))
    assert feature.geometry["coordinates"] == [4.12345679, 0.0]
    assert math.copysign(1, feature.geometry["coordinates"][1]) == 1


def test_an_open_ring_is_closed_and_a_height_dropped() -> None:
    ring = [[*p, 12.5] for p in SQUARE[:-1]]
    assert parse_feature(raw("north", "parcel", {"type": "Polygon", "coordinates": [ring]})).geometry == POLYGON


def test_crossing_edges_are_let_in_for_the_checks_to_show() -> None:
    bow = [SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3], SQUARE[0]]
    assert parse_feature(raw("north", "parcel", {"type": "Polygon", "coordinates": [bow]}))


def with_corner(*corner: Any) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": [[*SQUARE[:2], list(corner), *SQUARE[3:]]]}


@pytest.mark.parametrize(
    ("geometry", "code", "words"),
    [
        (with_corner(math.nan, 51.7), "bad_coordinates", "Corner 3 has no position"),
        (with_corner(4.2, math.inf), "bad_coordinates", "Corner 3 has no position"),
        (with_corner(51.7, 94.2), "bad_coordinates", "Corner 3 has latitude 94.2, beyond 90 degrees"),
        (with_corner(181, 51.7), "bad_coordinates", "Corner 3 has longitude 181, beyond 180 degrees"),
        (with_corner(604712.2, 5721004.0), "bad_coordinates", "Metres of a grid"),
        (with_corner(10**400, 51.7), "bad_coordinates", "Corner 3 has no position"),
        (with_corner("4.2", 51.7), "bad_coordinates", "Corner 3 is not a pair"),
        (with_corner(True, 51.7), "bad_coordinates", "Corner 3 is not a pair"),
        (with_corner(4.2), "bad_coordinates", "Corner 3 is not a pair"),
        ({"type": "Polygon", "coordinates": []}, "bad_coordinates", "no coordinates"),
        ({"type": "Polygon", "coordinates": [[]]}, "bad_coordinates", "no coordinates"),
        ({"type": "Polygon"}, "bad_coordinates", "no coordinates"),
        ({"type": "Polygon", "coordinates": [[SQUARE[0], SQUARE[1], SQUARE[0]]]}, "too_few_corners", "three different"),
        ({"type": "MultiPolygon", "coordinates": [[SQUARE]]}, "wrong_geometry", "MultiPolygon"),
        ({"type": "GeometryCollection", "geometries": []}, "wrong_geometry", "GeometryCollection"),
        (None, "no_geometry", "no shape"),
        ({"coordinates": [SQUARE]}, "no_geometry", "no shape"),
    ],
)
def test_a_bad_shape_is_refused_with_what_is_wrong(geometry: Any, code: str, words: str) -> None:
    error = refusal(raw("north", "parcel", geometry))
    assert error.code == code
    assert words in error.text
    assert error.text.startswith("North: ")
    assert error.feature_id == "north"


def test_a_line_of_one_place_is_refused() -> None:
    line = {"type": "LineString", "coordinates": [[4.2, 51.7], [4.200000001, 51.7]]}
    assert refusal(raw("lane", "road", line, width_m=3)).code == "too_few_corners"


def test_a_shape_of_too_many_corners_is_refused() -> None:
    ring = [[4 + n / 1e6, 51 + n % 7 / 1e6] for n in range(MOST_VERTICES + 1)]
    error = refusal(raw("north", "parcel", {"type": "Polygon", "coordinates": [ring]}))
    assert error.code == "too_many_corners"
    assert "100,001 corners" in error.text


@pytest.mark.parametrize(
    ("kind", "key", "value", "words"),
    [
        ("parcel", "row_spacing_m", 0, "Row spacing is 0 m. Give a number above 0, at most 10 m."),
        ("parcel", "row_spacing_m", 10.5, "Row spacing is 10.5 m."),
        ("parcel", "row_spacing_m", "0.5", "Row spacing is '0.5'."),
        ("parcel", "row_spacing_m", True, "Row spacing is True."),
        ("parcel", "row_spacing_m", math.nan, "Row spacing is nan."),
        ("parcel", "row_spacing_m", 10**400, "Row spacing is far too large."),
        ("parcel", "row_bearing_deg", -1, "Row direction is -1 degrees. Give a number from 0"),
        ("parcel", "row_bearing_deg", 361, "Row direction is 361 degrees"),
        ("parcel", "headland_m", -0.1, "Headland is -0.1 m"),
        ("parcel", "seeded", "08.04.2026", "Seeded is '08.04.2026'. Give a date such as 2026-04-08."),
        ("parcel", "seeded", "2026-02-30", "Give a date"),
        ("parcel", "seeded", "20260408", "Give a date"),
        ("parcel", "seeded", "0026-04-08", "Check the year"),
        ("parcel", "seeded", 20260408, "Give a date"),
        ("parcel", "crop", 7, "Crop is 7. Give a text"),
        ("parcel", "status", "x" * 201, "Growth stage is"),
        ("slow", "speed_mps", 0, "Speed is 0 m/s. Give a number above 0, at most 20 m/s."),
        ("slow", "speed_mps", 21, "Speed is 21 m/s"),
        ("road", "width_m", 0, "Width is 0 m"),
        ("obstacle", "radius_m", -2, "Radius is -2 m"),
        ("home", "heading_deg", 400, "Heading is 400 degrees"),
        ("home", "type", "barn", "Type is 'barn'. Choose home, garage or charging."),
        ("home", "robot", "Weeder 1", "Robot is 'Weeder 1'. Give an id"),
        ("rows", "type", "straight", "Choose a-b, curve or recorded."),
        ("rows", "parcel_id", "", "Parcel is ''. Give an id"),
    ],
)
def test_a_bad_attribute_is_refused_with_what_it_may_be(kind: str, key: str, value: Any, words: str) -> None:
    geometry = SHAPES[KINDS[kind].geometries[0]]
    error = refusal(raw("one", kind, geometry, **{key: value}))
    assert error.code == f"bad_{key}"
    assert words in error.text


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("row_spacing_m", 10),
        ("row_bearing_deg", 0),
        ("row_bearing_deg", 360),
        ("headland_m", 0),
        ("seeded", "2024-02-29"),
    ],
)
def test_the_ends_of_a_range_are_allowed(key: str, value: Any) -> None:
    assert parse_feature(raw("one", "parcel", POLYGON, **{key: value})).properties == {key: value}


def test_an_attribute_without_a_value_is_left_out() -> None:
    feature = parse_feature(raw("one", "parcel", POLYGON, crop=None, note=None))
    assert feature.properties == {"note": None}


def test_a_point_obstacle_without_a_radius_is_refused() -> None:
    assert refusal(raw("pole", "obstacle", POINT)).code == "bad_radius_m"
    assert parse_feature(raw("pole", "obstacle", POINT, radius_m=1.5))


@pytest.mark.parametrize("value", [object(), {1, 2}, math.nan, [math.inf], b"x", {"a": {1: object()}}, "\ud800"])
def test_an_unknown_property_that_is_no_json_is_refused(value: Any) -> None:
    assert refusal(raw("one", "parcel", POLYGON, note=value)).code == "bad_attribute"


def test_properties_are_bounded_in_size_depth_and_name() -> None:
    deep: Any = 1
    for _ in range(20):
        deep = [deep]
    assert refusal(raw("one", "parcel", POLYGON, note="x" * 40_000)).code == "too_large"
    assert refusal(raw("one", "parcel", POLYGON, note=deep)).code == "too_large"
    assert refusal(raw("one", "parcel", POLYGON, **{"x" * 65: 1})).code == "bad_attribute"


def test_a_feature_shares_nothing_with_what_was_read() -> None:
    given_feature = raw("one", "parcel", POLYGON, note={"a": [1]})
    feature = parse_feature(given_feature)
    given_feature["properties"]["note"]["a"].append(2)
    assert feature.properties == {"note": {"a": [1]}}


@pytest.mark.parametrize("given_id", [None, "", "North 2", "-x", "x" * 65, 7, "nord\n"])
def test_a_bad_id_is_refused(given_id: Any) -> None:
    feature = raw("one", "parcel", POLYGON)
    feature["id"] = feature["properties"]["id"] = given_id
    assert refusal(feature).code == "bad_id"


def test_two_different_ids_are_refused() -> None:
    feature = raw("one", "parcel", POLYGON)
    feature["properties"]["id"] = "two"
    assert refusal(feature).code == "bad_id"


@pytest.mark.parametrize("name", [7, "x" * 201, "two\nlines", "bell\x07"])
def test_a_bad_name_is_refused(name: Any) -> None:
    assert refusal(raw("one", "parcel", POLYGON, name=name)).code == "bad_name"


def test_a_feature_without_a_name_is_called_unnamed() -> None:
    assert parse_feature(raw("one", "no-go", POLYGON, name="")).title == "Unnamed keep-out zone"


@pytest.mark.parametrize("kind", ["field", "", None, 7, ["parcel"]])
def test_an_unknown_kind_is_refused_with_those_there_are(kind: Any) -> None:
    error = refusal(raw("one", kind, POLYGON))
    assert error.code == "unknown_kind"
    assert "parcel, obstacle, road" in error.text


@pytest.mark.parametrize("nothing", [None, 7, [], {}, {"type": "Feature"}, {"type": "Polygon", "properties": {}}])
def test_what_is_no_feature_is_refused(nothing: Any) -> None:
    assert refusal(nothing).code == "not_a_feature"


junk = st.recursive(
    st.one_of(st.none(), st.booleans(), st.floats(), st.integers(), st.text(max_size=8)),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=8), inner, max_size=4)),
    max_leaves=12,
)


@given(
    st.sampled_from(sorted(KINDS)), st.sampled_from(sorted(SHAPES)), junk, st.dictionaries(st.text(max_size=12), junk)
)
@pytest.mark.slow
def test_junk_is_refused_and_never_breaks_anything(kind: str, shape: str, junk: Any, more: dict[str, Any]) -> None:
    feature = raw("one", kind, {"type": shape, "coordinates": junk})
    feature["properties"] = {**more, **feature["properties"]}
    try:
        parsed = parse_feature(feature)
    except BadFeature:
        return
    json.dumps(as_geojson(parsed), allow_nan=False)


def test_the_errors_are_one_tree_that_survives_another_process() -> None:
    for error in (BadFeature("a", "b.", "c"), OperationRefused("a", "b."), BadWalk("a", "b.")):
        assert isinstance(error, MappingError)
        again = pickle.loads(pickle.dumps(error))
        assert (again.code, again.text, str(again)) == ("a", "b.", "a: b.")
    assert pickle.loads(pickle.dumps(BadFeature("a", "b.", "c"))).feature_id == "c"


def test_a_metre_drawn_is_a_metre_on_the_map() -> None:
    assert degrees(box(0, 0, 1, 1))[0] == pytest.approx([4.2, 51.7], abs=1e-9)

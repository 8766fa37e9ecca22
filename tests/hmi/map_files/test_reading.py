"""What a farmer gets from files of other programs."""

from __future__ import annotations

import json

import pytest

from hmi.map_files.errors import BadMapFile
from hmi.map_files.imported import Imported, MapItem
from hmi.map_files.kind_guess import KINDS_OF, possible
from hmi.map_files.reader import read_map
from hmi.mapping.feature import parse_feature
from hmi.mapping.kinds import KINDS
from tests.hmi.map_files import samples


def read(name: str, data: bytes | None = None) -> Imported:
    return read_map(samples.file(name) if data is None else data, name)


def named(imported: Imported, name: str) -> MapItem:
    return next(item for item in imported.items if item.name == name)


def collection(*features: object, **members: object) -> bytes:
    return json.dumps({"type": "FeatureCollection", "features": features, **members}).encode()


def shape(kind: str, coordinates: object, **properties: object) -> dict[str, object]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


@pytest.mark.parametrize("name", sorted(samples.good()))
def test_every_item_can_be_taken_as_it_is(name: str) -> None:
    imported = read_map(samples.good()[name], name)
    assert imported.items
    for n, item in enumerate(imported.items):
        assert item.n == n
        assert item.kind == item.kinds[0]
        head = {"id": "x", "kind": item.kind, "name": item.name}
        feature = {"type": "Feature", "properties": {**item.properties, **head}, "geometry": item.geometry}
        assert parse_feature(feature).geometry == item.geometry


@pytest.mark.parametrize("name", sorted(samples.good()))
def test_the_name_of_the_file_does_not_matter_where_its_content_tells(name: str) -> None:
    data = samples.good()[name]
    assert read_map(data, "file.bin").items == read_map(data, name).items


def test_the_possible_kinds_are_those_of_the_map() -> None:
    allowed = {shape: {kind for kind, rule in KINDS.items() if shape in rule.geometries} for shape in KINDS_OF}
    assert {shape: set(possible(shape)) for shape in KINDS_OF} == allowed


def test_a_name_that_is_too_long_is_cut_and_said_so() -> None:
    square = [[[4.0, 51.0], [4.001, 51.0], [4.001, 51.001], [4.0, 51.0]]]
    parts = [square, [[[x + 0.01, y] for x, y in square[0]]]]
    features = [shape("Polygon", square, name="L" * 90), shape("MultiPolygon", parts, name="M" * 90)]
    data = json.dumps({"type": "FeatureCollection", "features": features}).encode()
    items = read_map(data, "long.geojson").items
    assert [one.name for one in items] == ["L" * 80, "M" * 76 + " (1)", "M" * 76 + " (2)"]
    assert all("Its name is longer than 80 letters; the rest was left out." in one.problems for one in items)


def test_geojson_of_2008_is_moved_from_its_coordinate_system() -> None:
    imported = read("fields-2008.geojson")
    assert imported.crs == "ETRS89 / UTM zone 32N (EPSG:25832)"
    first = imported.items[0]
    assert first.geometry["coordinates"][0][0] == pytest.approx([9.0, 52.350], abs=1e-3)


def test_a_multipolygon_becomes_an_item_a_part() -> None:
    imported = read("fields-2008.geojson")
    assert [item.name for item in imported.items] == ["Hinterm Haus (1)", "Hinterm Haus (2)"]
    assert all(item.geometry["type"] == "Polygon" for item in imported.items)


def test_attributes_of_others_get_the_names_and_units_of_the_map() -> None:
    assert read("fields-2008.geojson").items[0].properties == {
        "FLIK": "DENILI0512", "crop": "Zuckerrübe", "row_spacing_m": 0.45, "seeded": "2026-04-08",
    }  # fmt: skip


def test_a_feature_without_a_shape_is_skipped_and_named() -> None:
    (skipped,) = read("fields-2008.geojson").skipped
    assert (skipped.which, skipped.why) == ("Schlaege: shape 2", "It has no shape.")


def test_outer_rings_run_counter_clockwise_and_holes_clockwise() -> None:
    clockwise = [ring[::-1] for ring in samples.SQUARE]
    hole = [[5.662, 51.982], [5.664, 51.982], [5.664, 51.984], [5.662, 51.982]]
    (item,) = read("a.json", collection(shape("Polygon", [*clockwise, hole]))).items
    assert item.geometry["coordinates"] == [*samples.SQUARE, hole[::-1]]


def test_a_broken_line_of_newline_delimited_geojson_leaves_the_others() -> None:
    imported = read("fields.ndjson")
    assert [(item.name, item.kind, item.id) for item in imported.items] == [
        ("North", "parcel", "north"), ("Lane", "road", None),
    ]  # fmt: skip
    assert [skipped.which for skipped in imported.skipped] == ["line 2"]


def test_bad_shapes_are_skipped_with_reasons_and_good_ones_stay() -> None:
    imported = read("bad-shapes.geojson")
    assert [item.name for item in imported.items] == ["good", "open", "bow"]
    assert named(imported, "open").problems == ("A ring was open and was closed.",)
    assert named(imported, "bow").problems[0].startswith("An edge crosses")
    whys = {skipped.which.split("(")[-1].rstrip(")"): skipped.why for skipped in imported.skipped}
    assert whys["nan"] == "A coordinate is not a number on earth (NaN or infinite)."
    assert whys["swapped"] == "Latitude 105.66 is beyond 90: latitude and longitude are likely exchanged."
    assert whys["metres"] == "500000, 5.8e+06 is not a longitude and latitude."
    assert whys["flat"] == "The polygon has no area: its corners lie in one line."
    assert whys["date line"].startswith("It crosses the 180° meridian")
    assert len(imported.skipped) == 15
    assert all(skipped.mend.endswith(".") for skipped in imported.skipped)


def test_two_loops_of_equal_size_are_told_from_a_line() -> None:
    bow = [[[5.71, 52.55], [5.713, 52.552], [5.713, 52.55], [5.71, 52.552], [5.71, 52.55]]]
    (skipped,) = read("a.json", collection(shape("Polygon", bow), shape("Point", [5.7, 52.5]))).skipped
    assert skipped.why == "The polygon has no area: its edge crosses itself."


def test_an_item_with_exchanged_axes_stands_out_among_the_others() -> None:
    points = [shape("Point", [5.66, 51.98]), shape("Point", [5.67, 51.98]), shape("Point", [51.98, 5.66])]
    items = read("a.json", collection(*points)).items
    assert [any("exchanged" in problem for problem in item.problems) for item in items] == [False, False, True]


def test_features_may_each_name_their_own_coordinate_system() -> None:
    utm = {"type": "name", "properties": {"name": "EPSG:25832"}}
    mixed = collection(shape("Point", [9.0, 52.35]), {**shape("Point", [500000, 5800000]), "crs": utm})
    imported = read("a.json", mixed)
    assert imported.items[1].geometry["coordinates"] == pytest.approx([9.0, 52.35], abs=1e-3)
    assert imported.crs == "WGS84, ETRS89 / UTM zone 32N (EPSG:25832)"


def test_epsg_4326_keeps_longitude_first() -> None:
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::4326"}}
    (item,) = read("a.json", collection(shape("Point", [5.66, 51.98]), crs=crs)).items
    assert item.geometry["coordinates"] == [5.66, 51.98]


def test_a_linked_coordinate_system_is_not_fetched() -> None:
    crs = {"type": "link", "properties": {"href": "http://example.com/crs"}}
    with pytest.raises(BadMapFile, match="nothing is fetched"):
        read("a.json", collection(shape("Point", [5.66, 51.98]), crs=crs))


def test_degrees_without_a_coordinate_system_are_assumed_to_be_wgs84() -> None:
    (item,) = read("a.json", collection(shape("Point", [5.66, 51.98]), crs=None)).items
    assert item.problems[0].startswith("The file does not name its coordinate system")


def test_metres_without_a_coordinate_system_are_refused() -> None:
    with pytest.raises(BadMapFile, match="its numbers are not degrees") as caught:
        read("a.json", collection(shape("Point", [500000, 5800000]), crs=None))
    assert caught.value.code == "no_coordinate_system"


def test_a_point_obstacle_without_a_radius_gets_one_and_says_so() -> None:
    (item,) = read("a.json", collection(shape("Point", [5.66, 51.98], type="obstacle"))).items
    assert (item.kind, item.properties["radius_m"]) == ("obstacle", 1.0)
    assert "The file gives no radius; 1 m was assumed. Check it." in item.problems


def test_a_value_that_cannot_be_is_put_aside() -> None:
    (item,) = read("a.json", collection(shape("Polygon", samples.SQUARE, row_spacing=75))).items
    assert item.properties == {"row_spacing_m_as_given": 75}
    assert item.problems == ("Row spacing is 75 m. It was put aside.",)


def test_long_texts_are_cut_and_it_says_so() -> None:
    (item,) = read("a.json", collection(shape("Polygon", samples.SQUARE, notes="x" * 900))).items
    assert len(item.properties["notes"]) == 500
    assert item.problems == ("notes was cut to 500 characters.",)


def test_kml_folders_names_and_attributes_are_read() -> None:
    imported = read("farm.kml")
    found = {item.name: (item.kind, item.geometry["type"]) for item in imported.items}
    assert found == {
        "Oben & unten": ("parcel", "Polygon"), "Barn": ("building", "Polygon"), "AB lines": ("rows", "MultiLineString"),
        "Drive": ("road", "LineString"), "Charging station": ("home", "Point"),
    }  # fmt: skip
    field = named(imported, "Oben & unten")
    assert field.properties == {"crop": "onion", "description": "clay"}
    assert len(field.geometry["coordinates"]) == 2


def test_kml_links_and_pictures_are_skipped_and_not_fetched() -> None:
    assert [skipped.which for skipped in read("farm.kml").skipped] == [
        "link (Parcels online)", "picture (Drone picture)", "Stuff: shape 5 (Nowhere)",
    ]  # fmt: skip


def test_a_gpx_walk_that_closes_is_an_outline_and_one_that_does_not_is_a_road() -> None:
    imported = read("walk.gpx")
    found = {item.name: (item.kind, item.geometry["type"]) for item in imported.items}
    assert found == {
        "Gate south": ("gate", "Point"), "Big stone": ("obstacle", "Point"), "To town": ("road", "LineString"),
        "Around": ("parcel", "Polygon"), "Lane": ("road", "LineString"),
    }  # fmt: skip
    assert [skipped.which for skipped in imported.skipped] == ["waypoint 3"]


def test_task_data_gives_fields_with_holes_and_what_lies_in_them() -> None:
    imported = read("task.zip", samples.task_data())
    field = named(imported, "Home field")
    assert field.properties == {"crop": "Carrot", "species": "Nairobi", "field_code": "0815"}
    assert [len(ring) for ring in field.geometry["coordinates"]] == [5, 4]
    assert named(imported, "Pylon").kind == "obstacle"
    assert (named(imported, "Tram").kind, named(imported, "Tram").properties) == ("road", {"width_m": 3.0})
    assert named(imported, "Gate").kind == "gate"


def test_guidance_lines_are_rows() -> None:
    imported = read("task.zip", samples.task_data())
    rows = {item.name: item for item in imported.items if item.kind == "rows"}
    assert {name: item.properties["type"] for name, item in rows.items()} == {
        "AB 1": "a-b",
        "A+": "a-b",
        "Bend": "curve",
    }
    start, end = rows["A+"].geometry["coordinates"]
    assert end[0] > start[0]
    assert end[1] == pytest.approx(start[1], abs=1e-6)
    assert any("pivot" in skipped.why for skipped in imported.skipped)


def test_external_files_of_task_data_are_read_and_missing_ones_named() -> None:
    imported = read("task.zip", samples.task_data())
    assert named(imported, "Far field (1)").geometry["coordinates"][0][0] == [5.66, 52.08]
    assert "PFD00002.XML" in {skipped.which for skipped in imported.skipped}


PLN = (
    '<PLN A="1"><LSG A="1"><PNT A="2" C="51.98" D="5.66"/><PNT A="2" C="51.98" D="5.67"/>'
    '<PNT A="2" C="51.99" D="5.67"/></LSG></PLN>'
)


def task(inside: str) -> bytes:
    return f'<ISO11783_TaskData VersionMajor="4">{inside}</ISO11783_TaskData>'.encode()


def test_of_several_task_data_the_others_are_named() -> None:
    fields = {year: task(f'<PFD A="PFD1" C="Field {year}">{PLN}</PFD>') for year in (2025, 2026)}
    imported = read("t.zip", samples.packed({f"{year}/TASKDATA.XML": data for year, data in fields.items()}))
    assert [item.name for item in imported.items] == ["Field 2025"]
    assert [(skipped.which, skipped.mend) for skipped in imported.skipped] == [
        ("2026/TASKDATA.XML", "Pack its folder into a zip of its own.")
    ]


@pytest.mark.parametrize("broken", [b"<XFC><PFD", b"<html/>"])
def test_a_broken_external_file_is_named_and_the_good_ones_are_taken(broken: bytes) -> None:
    external = f'<XFC><PFD A="PFD2" C="Far">{PLN}</PFD></XFC>'.encode()
    near = f'<XFR A="PFD00000" B="1"/><XFR A="PFD00001" B="1"/><PFD A="PFD1" C="Near">{PLN}</PFD>'
    files = {"TASKDATA.XML": task(near), "PFD00000.XML": broken, "PFD00001.XML": external}
    imported = read("t.zip", samples.packed(files))
    assert [item.name for item in imported.items] == ["Near", "Far"]
    assert [skipped.which for skipped in imported.skipped] == ["PFD00000.XML"]


def test_patterns_without_names_are_one_shape_only_where_they_are_of_one_type() -> None:
    straight = '<PNT A="6" C="51.98" D="5.66"/><PNT A="7" C="51.99" D="5.66"/>'
    bent = '<PNT A="6" C="51.98" D="5.66"/><PNT A="9" C="51.98" D="5.67"/><PNT A="7" C="51.99" D="5.66"/>'
    lines = [("1", straight), ("3", bent), ("1", straight)]
    patterns = "".join(f'<GPN A="GPN{n}" C="{c}"><LSG A="5">{line}</LSG></GPN>' for n, (c, line) in enumerate(lines))
    imported = read("TASKDATA.XML", task(f'<PFD A="PFD1" C="F"><GGP A="GGP1" B="Lines">{patterns}</GGP></PFD>'))
    assert [(item.properties["type"], item.geometry["type"]) for item in imported.items] == [
        ("a-b", "MultiLineString"), ("curve", "LineString"),
    ]  # fmt: skip


def test_corners_in_a_binary_file_are_said_to_be_there() -> None:
    binary = '<PLN A="1"><LSG A="1"><PNT A="2" I="PNT00001" J="40"/></LSG></PLN>'
    xml = task(f'<PFD A="PFD1" C="F">{PLN}{binary}</PFD>')
    imported = read("t.zip", samples.packed({"TASKDATA.XML": xml, "PNT00001.bin": bytes(40)}))
    assert len(imported.items) == 1
    (skipped,) = imported.skipped
    assert skipped.which == "field 1 (F): area 2"
    assert skipped.why == "Its corners are in a binary file (PNT00001.bin), which is not read."
    assert skipped.mend == "Export the task data with the corners as XML."


def test_one_map_in_an_ordinary_zip_is_read() -> None:
    assert read("a.zip", samples.packed({"x/walk.gpx": samples.file("walk.gpx")})).format == "gpx"


@pytest.mark.parametrize(
    ("data", "code", "words"),
    [
        (b"", "empty", "empty"),
        (b" \n\0", "empty", "empty"),
        (b"name;lon;lat\nA;1;2\n", "not_a_map", "Export it as"),
        (b"%PDF-1.7", "not_a_map", "PDF"),
        (b"\x1f\x8b\x08", "not_a_map", "gzip"),
        (b"\x00\x00\x27\x0a" + bytes(96), "not_a_map", "Pack .shp, .shx, .dbf and .prj"),
        (b'{"type": "Topology"}', "not_a_map", "TopoJSON"),
        (b'{"type": "FeatureCollection", "features": {}}', "not_a_map", "no list of features"),
        (b'{"type": "FeatureCollection", "features": []}', "nothing_in_it", "no shapes"),
        (b'{"type": "FeatureCollection", "feat', "broken_json", "line 1"),
        (b"[" * 100_000, "broken_json", "nested"),
        (b"<kml><Document>", "broken_xml", "cut off"),
        (b"<svg/>", "not_a_map", "svg"),
        (b"<ISO11783_TaskData/>", "nothing_in_it", "PFD"),
        (b"\xff\xfe<\0k\0m\0l\0/\0>\0", "nothing_in_it", "no shapes"),
    ],
)
def test_a_file_that_is_no_map_is_refused_with_what_to_do(data: bytes, code: str, words: str) -> None:
    with pytest.raises(BadMapFile) as caught:
        read_map(data, "map.geojson")
    assert caught.value.code == code
    assert words in caught.value.text


@pytest.mark.long
def test_too_many_shapes_and_corners_are_refused() -> None:
    with pytest.raises(BadMapFile, match="20,000"):
        read("a.json", collection(*[shape("Point", [5, 52])] * 20_001))
    with pytest.raises(BadMapFile, match="1,000,000"):
        read("a.json", collection(shape("LineString", [[5, 52], [5, 53]] * 500_001)))


SMALL = [[[4.0, 51.0], [4.001, 51.0], [4.001, 51.001], [4.0, 51.0]]]


@pytest.mark.parametrize(
    ("given", "height_m"),
    [
        ({"height": "12.5 m"}, 12.5),
        ({"HEIGHT": 12}, 12),
        ({"building:height": "9,5"}, 9.5),
        ({"Tree Height (cm)": 850}, 8.5),
        ({"height": "40 ft"}, None),
        ({"height": 0}, None),
        ({"ele": 12}, None),
        ({"elevation": 12, "altitude": 12, "höhe": 12}, None),
    ],
)
def test_the_height_of_a_building_is_taken_with_a_note_and_one_above_the_sea_is_not(
    given: dict[str, object], height_m: float | None
) -> None:
    [item] = read("a.geojson", collection(shape("Polygon", SMALL, building="yes", **given))).items
    assert (item.kind, item.properties.get("height_m")) == ("building", height_m)
    said = [one for one in item.problems if "height above the ground" in one]
    assert len(said) == (height_m is not None)
    if height_m is None:
        assert given.items() <= item.properties.items()


def test_a_height_that_no_building_has_is_put_aside_and_a_field_has_none() -> None:
    barn = shape("Polygon", SMALL, building="yes", height_m=450)
    field = shape("Polygon", SMALL, landuse="farmland", height=0.8)
    high, crop = read("a.geojson", collection(barn, field)).items
    assert high.properties["height_m_as_given"] == 450
    assert "Height is 450 m. It was put aside." in high.problems
    assert crop.properties["height"] == 0.8


def called(*names: str) -> str:
    return "".join(PLN.replace("<PLN ", f'<PLN B="{name}" ') for name in names)


@pytest.mark.parametrize(
    ("field", "names"),
    [
        (f'<PFD A="PFD1" C="Acre">{called("Boundary")}</PFD>', ["Acre"]),
        (f'<PFD A="PFD1">{called("West")}</PFD>', ["West"]),
        (f'<PFD A="PFD1" C="Acre">{called("N", "S")}</PFD>', ["Acre, N", "Acre, S"]),
    ],
)
def test_a_field_of_task_data_has_the_name_of_the_field_and_not_of_its_boundary(field: str, names: list[str]) -> None:
    assert [one.name for one in read("TASKDATA.XML", task(field)).items] == names


def test_fields_of_task_data_without_a_boundary_are_named() -> None:
    line = '<LSG A="5"><PNT A="6" C="51.9" D="4.6"/><PNT A="7" C="51.91" D="4.6"/></LSG>'
    lines = f'<GGP A="GGP1"><GPN A="GPN1" B="AB" C="1">{line}</GPN></GGP>'
    fields = f'<PFD A="PFD1" C="Drawn">{PLN}</PFD><PFD A="PFD2" C="Empty"/><PFD A="PFD3" C="Lines">{lines}</PFD>'
    imported = read("TASKDATA.XML", task(fields))
    assert [one.kind for one in imported.items] == ["parcel", "rows"]
    assert {one.which: one.why for one in imported.skipped} == {
        "field 2 (Empty)": "It has no boundary in the file; it is a name only.",
        "field 3 (Lines)": "It has no boundary in the file; what lies in it was read.",
    }


ROUND = [[4.0, 51.0], [4.002, 51.0], [4.002, 51.001], [4.0, 51.001], [4.0, 51.0]]


def test_an_empty_part_of_a_shape_does_not_spoil_the_file() -> None:
    shapes = [
        shape("MultiPolygon", [[ROUND], []], name="Two parts"),
        shape("Polygon", [], name="Empty"),
        {"type": "Feature", "properties": {}, "geometry": {"type": "GeometryCollection", "geometries": []}},
        shape("Polygon", [ROUND], name="Whole"),
    ]
    imported = read("a.geojson", collection(*shapes))
    assert [one.name for one in imported.items] == ["Two parts", "Whole"]
    assert [one.why for one in imported.skipped] == ["It has no coordinates."] * 2 + ["It has no shape."]


def test_a_field_is_not_lost_for_a_hole_that_is_a_line() -> None:
    line = [[4.0005, 51.0005], [4.001, 51.0005], [4.0015, 51.0005], [4.0005, 51.0005]]
    hole = [[4.0005, 51.0006], [4.0005, 51.0008], [4.001, 51.0008], [4.0005, 51.0006]]
    [item] = read("a.geojson", collection(shape("Polygon", [ROUND, line, hole], name="Acre"))).items
    assert len(item.geometry["coordinates"]) == 2
    assert item.problems == ("A hole without area was left out.",)


@pytest.mark.parametrize(
    ("own", "kind"),
    [({"name": "Acre"}, "parcel"), ({"name": "Ring road"}, "road"), ({"barrier": "hedge"}, "hedge"), ({}, "parcel")],
)
def test_a_line_around_a_field_is_the_field_unless_it_is_called_something_else(
    own: dict[str, object], kind: str
) -> None:
    [item] = read("a.geojson", collection(shape("LineString", ROUND, **own))).items
    assert (item.kind, item.geometry["type"]) == (kind, "Polygon" if kind == "parcel" else "LineString")
    told = "The line ends where it began and was taken as an outline."
    assert (told in item.problems) == (kind == "parcel")


def test_a_line_that_is_open_or_goes_around_next_to_nothing_stays_a_line() -> None:
    small = [[4 + (x - 4) / 100, 51 + (y - 51) / 100] for x, y in ROUND]
    items = read("a.geojson", collection(shape("LineString", ROUND[:-1]), shape("LineString", small))).items
    assert [one.geometry["type"] for one in items] == ["LineString"] * 2


def test_corners_are_counted_as_people_count_them() -> None:
    square = [[4.0, 51.0], [4.001, 51.0], [4.001, 51.001], [4.0, 51.001], [4.0, 51.0]]
    hole = [[4.0004, 51.0004], [4.0004, 51.0006], [4.0006, 51.0005], [4.0004, 51.0004]]
    field, lane, gate = shape("Polygon", [square, hole]), shape("LineString", square[:3]), shape("Point", square[0])
    assert [one.corners for one in read("farm.geojson", collection(field, lane, gate)).items] == [4 + 3, 3, 1]

"""What is written can be read again, and is the same as far as the format can hold it."""

from __future__ import annotations

import io
import zipfile
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmi.map_files.imported import Imported
from hmi.map_files.reader import read_map
from hmi.map_files.writer import FORMATS, write_map
from hmi.mapping.feature import MapFeature
from tests.hmi.map_files.features import features, maps

LOSSLESS = ("geojson", "kml", "kmz", "shapefile", "gpx", "isoxml")


def again(written: list[MapFeature], format_: str) -> Imported:
    file = write_map(written, format_, "hof", "Hof Älmhult & Söhne")
    return read_map(file.data, file.file_name)


def as_features(imported: Imported) -> dict[str | None, MapFeature]:
    return {i.id: MapFeature(i.id or "", i.kind, i.name, i.geometry, i.properties) for i in imported.items}


@pytest.mark.parametrize("format_", LOSSLESS)
@given(written=maps)
@settings(max_examples=25, deadline=None)
@pytest.mark.slow
def test_a_map_comes_back_whole(format_: str, written: list[MapFeature]) -> None:
    imported = again(written, format_)
    assert imported.format == format_
    assert imported.skipped == ()
    assert as_features(imported) == {feature.id: feature for feature in written}


@given(written=maps)
@settings(max_examples=25, deadline=None)
@pytest.mark.slow
def test_fiware_brings_back_what_it_does_not_list_as_left_out(written: list[MapFeature]) -> None:
    file = write_map(written, "fiware", "hof", "Hof")
    found = as_features(read_map(file.data, file.file_name)) if len(file.left_out) < len(written) else {}
    kept = {feature.id: feature for feature in written}
    assert found.items() <= kept.items(), "what comes back is what was written"
    lost = sorted(feature.title for feature in written if feature.id not in found)
    assert sorted(file.left_out) == lost, "and what does not is told"


def test_attributes_that_find_no_column_in_a_shapefile_are_told() -> None:
    far_too_many = {f"attribute_{n:03d}": n for n in range(300)} | {"note": "long " * 400}
    geometry = {"type": "Point", "coordinates": [5.0, 52.0]}
    gate = MapFeature("gate-1", "gate", "Gate", geometry, far_too_many)
    assert as_features(again([gate], "geojson")) == {"gate-1": gate}
    file = write_map([gate], "shapefile", "hof", "Hof")
    [back] = read_map(file.data, file.file_name).items
    lost = {line.split(" of ")[0] for line in file.cut}
    assert lost
    assert set(back.properties) == set(far_too_many) - lost


def test_names_kinds_and_attributes_of_every_kind_come_back_from_isoxml() -> None:
    polygon = {"type": "Polygon", "coordinates": [[[5.0, 52.0], [5.01, 52.0], [5.01, 52.01], [5.0, 52.0]]]}
    point = {"type": "Point", "coordinates": [5.001, 52.001]}
    long = "The field behind the third hedge on the left, as my grandfather called it"
    written = [
        MapFeature("p", "parcel", long, polygon, {"species": "no crop", "soil": {"clay": 12.5}, "headland_m": 6.0}),
        MapFeature("slow-1", "slow", long, polygon, {"speed_mps": 0.4}),
        MapFeature("pylon", "obstacle", long, point, {"radius_m": 2.5, "owner": "TenneT"}),
        MapFeature("home-1", "home", long, point, {"type": "garage", "heading_deg": 90.0}),
        MapFeature("rows-1", "rows", "", {"type": "MultiLineString", "coordinates": [[[5.0, 52.0], [5.0, 52.01]]]}, {}),
    ]
    assert as_features(again(written, "isoxml")) == {one.id: one for one in written}


def guidance(type_: str, *lines: list[list[float]]) -> list[dict[str, str]]:
    """Return the attributes of the guidance patterns that rows are written as."""
    geometry = {"type": "MultiLineString", "coordinates": list(lines)}
    file = write_map([MapFeature("r", "rows", "Rows", geometry, {"type": type_})], "isoxml", "hof", "Hof")
    with zipfile.ZipFile(io.BytesIO(file.data)) as archive:
        root = ElementTree.fromstring(archive.read("TASKDATA/TASKDATA.XML"))
    return [pattern.attrib for pattern in root.iter("GPN")]


def test_guidance_lines_say_to_other_programs_what_they_are() -> None:
    straight, bent = [[5.0, 52.0], [5.0, 52.01]], [[5.0, 52.0], [5.001, 52.005], [5.0, 52.01]]
    assert guidance("a-b", straight) == [{"A": "GPN1", "B": "Rows", "C": "1", "E": "1", "F": "1"}]
    assert guidance("a-b", bent) == [{"A": "GPN1", "B": "Rows", "C": "3", "E": "1", "F": "1"}]
    rows = guidance("recorded", straight, bent)  # driven as they are: not beside, not beyond their ends
    assert rows == [{"A": f"GPN{n}", "C": "3", "E": "4", "F": "4"} for n in (1, 2)]


def test_what_another_program_changed_in_the_task_data_is_taken_over() -> None:
    polygon = {"type": "Polygon", "coordinates": [[[5.0, 52.0], [5.01, 52.0], [5.01, 52.01], [5.0, 52.0]]]}
    field = MapFeature(
        "p", "parcel", "A name longer than thirty-two letters", polygon, {"crop": "Maize", "soil": "clay"}
    )
    file = write_map([field], "isoxml", "hof", "Hof")
    changed = repacked(file.data, {b'B="Maize"': b'B="Oats"', b'C="A name longer': b'C="A field longer'})
    [item] = read_map(changed, "isoxml.zip").items
    assert (item.id, item.kind, item.properties) == ("p", "parcel", {"crop": "Oats", "soil": "clay"})
    assert item.name == "A field longer than thirty-two le"


def repacked(data: bytes, replaced: dict[bytes, bytes]) -> bytes:
    """Return an archive with other words in its task data, and everything else as it was."""
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(stream, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            for was, now in replaced.items() if name.endswith("TASKDATA.XML") else ():
                assert was in content
                content = content.replace(was, now)
            new.writestr(name, content)
    return stream.getvalue()


@pytest.mark.slow
@given(written=st.lists(features(is_plain=True), min_size=1, max_size=4, unique_by=lambda f: f.id))
@settings(max_examples=25, deadline=None)
def test_isoxml_brings_back_as_many_shapes_where_they_were(written: list[MapFeature]) -> None:
    imported = again(written, "isoxml")
    assert imported.skipped == ()
    assert len(imported.items) == len(written)
    shapes = [item.geometry for item in imported.items]
    kinds = {"parcel", "building", "water", "gate", "home", "no-go", "rows"}
    for feature in written:
        if feature.kind in kinds:
            item = next(i for i in imported.items if i.geometry == feature.geometry)
            assert item.kind == feature.kind
        elif feature.kind != "obstacle":
            assert feature.geometry in shapes


@pytest.mark.parametrize("format_", sorted(FORMATS))
@given(written=maps)
@settings(max_examples=10, deadline=None)
def test_the_same_map_is_the_same_file(format_: str, written: list[MapFeature]) -> None:
    first, second = (write_map(written, format_, "hof", "Hof") for _ in range(2))
    assert first == second

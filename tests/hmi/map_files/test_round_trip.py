"""What is written can be read again, and is the same as far as the format can hold it."""

from __future__ import annotations

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
def test_a_map_comes_back_whole(format_: str, written: list[MapFeature]) -> None:
    imported = again(written, format_)
    assert imported.format == format_
    assert imported.skipped == ()
    assert as_features(imported) == {feature.id: feature for feature in written}


@given(written=maps)
@settings(max_examples=25, deadline=None)
def test_fiware_brings_back_what_it_has_models_for(written: list[MapFeature]) -> None:
    kept = {
        f.id: f for f in written if f.kind in {"parcel", "building"} or (f.kind == "road" and "width_m" in f.properties)
    }
    kept = {k: f for k, f in kept.items() if f.geometry["type"] != "Polygon" or f.kind != "road"}
    if kept:
        found = as_features(again(list(kept.values()), "fiware"))
        assert found == kept


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

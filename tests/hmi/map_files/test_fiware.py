"""Exports to context brokers fit the published schemas; entities of others are read."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings

from hmi.map_files.reader import read_map
from hmi.map_files.writer import write_map
from hmi.mapping.feature import MapFeature
from tests.hmi.fiware.models import check
from tests.hmi.map_files.features import maps
from tests.hmi.map_files.samples import SQUARE


@given(written=maps)
@settings(max_examples=40, deadline=None)
@pytest.mark.slow
def test_every_entity_fits_its_schema(written: list[MapFeature]) -> None:
    file = write_map(written, "fiware", "hof", "Hof Älmhult")
    entities = json.loads(file.data)
    assert len({entity["id"] for entity in entities}) == len(entities)
    for entity in entities:
        check(entity)


@given(written=maps)
@settings(max_examples=20, deadline=None)
def test_what_has_no_model_is_named(written: list[MapFeature]) -> None:
    file = write_map(written, "fiware", "hof", "Hof")
    assert {f.title for f in written if f.kind in {"home", "gate", "obstacle", "no-go", "rows"}} <= set(file.left_out)


def test_entities_of_others_are_read_plain_and_normalized() -> None:
    polygon = {"type": "Polygon", "coordinates": SQUARE}
    entities = [
        {"id": "urn:ngsi-ld:AgriCrop:1", "type": "AgriCrop", "name": {"type": "Property", "value": "Wheat"}},
        {"id": "urn:ngsi-ld:AgriParcel:1", "type": "AgriParcel", "location": {"type": "GeoProperty", "value": polygon},
         "hasAgriCrop": {"type": "Relationship", "object": "urn:ngsi-ld:AgriCrop:1"}, "name": "North"},
        {"id": "b", "type": "Building", "location": polygon, "category": ["barn"]},
        {"id": "w", "type": "WeatherObserved"},
    ]  # fmt: skip
    imported = read_map(json.dumps(entities).encode(), "entities.json")
    assert imported.format == "fiware"
    parcel, building = imported.items
    assert (parcel.name, parcel.kind, parcel.properties["crop"]) == ("North", "parcel", "Wheat")
    assert (building.kind, building.properties["category"]) == ("building", "barn")

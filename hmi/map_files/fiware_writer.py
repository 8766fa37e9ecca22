"""The farm map as FIWARE smart data models, NGSI-LD simplified ("key-values") entities in a JSON array.

Source: ETSI GS CIM 009 on simplified representation; the models are those of ``hmi.fiware``. What the models have no
place for is kept in the attribute ``headland``. Kinds without a model are left out.
"""

from __future__ import annotations

from collections.abc import Sequence

from hmi.fiware.farm_map import map_entities
from hmi.map_files.exported import MapFile, json_bytes, stem, titles
from hmi.mapping.feature import MapFeature


def write(features: Sequence[MapFeature], farm_id: str, farm_name: str) -> MapFile:
    """Return the entities: the farm first, then crops, then the rest in the order of the map."""
    entities, without_model = map_entities(features, farm_id, farm_name)
    name = f"{stem(farm_id)}-fiware.json"
    return MapFile(json_bytes(entities), "application/json", name, titles(without_model))

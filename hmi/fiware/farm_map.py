"""The farm's map as entities: the farm first, then crops and soils, then the rest in the order of the map."""

from __future__ import annotations

from collections.abc import Sequence

from hmi.fiware.building import building_entity
from hmi.fiware.crop import crop_entities
from hmi.fiware.farm import farm_entity
from hmi.fiware.parcel import parcel_entity
from hmi.fiware.road import road_entities
from hmi.fiware.soil import soil_entities
from hmi.fiware.urn import KeyValues, Urns
from hmi.mapping.feature import MapFeature


def map_entities(
    features: Sequence[MapFeature], farm_id: str, farm_name: str
) -> tuple[list[KeyValues], list[MapFeature]]:
    """Return the entities, and the features that no model has a place for."""
    urns = Urns(farm_id)
    of = {kind: [one for one in features if one.kind == kind] for kind in ("farm", "parcel", "building", "road")}
    roads = [road for road in of["road"] if road.geometry["type"] == "LineString"]
    land = of["farm"][0] if of["farm"] else None
    entities = [
        farm_entity(urns, farm_name, land, of["parcel"], of["building"]),
        *crop_entities(urns, of["parcel"]),
        *soil_entities(urns, of["parcel"]),
        *(parcel_entity(urns, one) for one in of["parcel"]),
        *(building_entity(urns, one) for one in of["building"]),
        *(entity for road in roads for entity in road_entities(urns, road)),
    ]
    known = {one.id for one in [*of["farm"][:1], *of["parcel"], *of["building"], *roads]}
    return entities, [one for one in features if one.id not in known]

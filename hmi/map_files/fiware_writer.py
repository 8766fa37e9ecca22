"""The farm map as FIWARE smart data models, NGSI-LD simplified ("key-values") entities in a JSON array.

Source: dataModel.Agrifood AgriFarm 0.0.5, AgriParcel 1.0.2 and AgriCrop, dataModel.Building Building,
dataModel.Transportation RoadSegment; ETSI GS CIM 009 on simplified representation. What the models have no place for
is kept in the attribute ``headland``. Kinds without a model are left out.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from pyproj import Geod
from shapely.geometry import shape

from hmi.map_files.exported import MapFile, json_bytes, stem, titles
from hmi.map_files.fiware_reader import OWN
from hmi.mapping.feature import MapFeature

NO_CROP = "none"  # AgriParcel wants a crop even where nothing grows
_GEOD = Geod(ellps="WGS84")
_BUILDINGS = frozenset(
    {"barn", "bunker", "cabin", "carport", "conservatory", "cowshed", "digester", "farm", "farm_auxiliary", "garage",
     "garages", "greenhouse", "hangar", "house", "hut", "industrial", "office", "roof", "ruins", "service", "shed",
     "stable", "sty", "warehouse", "water_tower"}
)  # of the enumeration of Building  # fmt: skip
_USUAL_BUILDING = "farm_auxiliary"
_STATES = frozenset(("seeded", "justBorn", "growing", "maturing", "readyForHarvesting"))  # cropStatus of AgriParcel
Entity = dict[str, Any]


def write(features: Sequence[MapFeature], farm_id: str, farm_name: str) -> MapFile:
    """Return the entities: the farm first, then crops, then the rest in the order of the map."""
    urns = _Urns(farm_id)
    of = {kind: [f for f in features if f.kind == kind] for kind in ("farm", "parcel", "building", "road")}
    roads = [road for road in of["road"] if road.geometry["type"] == "LineString"]
    farms, written = _farms(of, urns, farm_name), [*of["farm"][:1], *of["parcel"], *of["building"], *roads]
    entities = [
        *farms,
        *_crops(of["parcel"], urns),
        *(_parcel(parcel, urns) for parcel in of["parcel"]),
        *(_building(building, urns) for building in of["building"]),
        *(_road(road, urns) for road in roads),
    ]
    known = {feature.id for feature in written}
    left_out = titles([feature for feature in features if feature.id not in known])
    return MapFile(json_bytes(entities), "application/json", f"{stem(farm_id)}-fiware.json", left_out)


class _Urns:
    def __init__(self, farm_id: str) -> None:
        self._farm = stem(farm_id)
        self.farm = self.of("AgriFarm", "")

    def of(self, model: str, feature_id: str) -> str:
        """Return the id of an entity (ETSI GS CIM 009, annex A)."""
        return ":".join(part for part in ("urn:ngsi-ld", model, self._farm, feature_id) if part)

    def crop(self, parcel: MapFeature) -> str:
        name = str(parcel.properties.get("crop") or NO_CROP)
        return self.of("AgriCrop", re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:64] or name.encode().hex()[:64])


def _farms(of: dict[str, list[MapFeature]], urns: _Urns, farm_name: str) -> list[Entity]:
    entity: Entity = {
        "id": urns.farm,
        "type": "AgriFarm",
        "name": farm_name,
        "hasAgriParcel": [urns.of("AgriParcel", parcel.id) for parcel in of["parcel"]],
        "hasBuilding": [urns.of("Building", building.id) for building in of["building"]],
    }
    if of["farm"]:
        entity |= {"landLocation": of["farm"][0].geometry, OWN: _own(of["farm"][0])}
    return [entity]


def _crops(parcels: list[MapFeature], urns: _Urns) -> list[Entity]:
    crops: dict[str, Entity] = {}
    for parcel in parcels:
        name = str(parcel.properties.get("crop") or NO_CROP)
        crops.setdefault(urns.crop(parcel), {"id": urns.crop(parcel), "type": "AgriCrop", "name": name})
    return [crops[key] for key in sorted(crops)]


def _parcel(feature: MapFeature, urns: _Urns) -> Entity:
    entity: Entity = {
        "id": urns.of("AgriParcel", feature.id),
        "type": "AgriParcel",
        "name": feature.name,
        "location": feature.geometry,
        "area": round(abs(_GEOD.geometry_area_perimeter(shape(feature.geometry))[0]), 1),
        "belongsTo": urns.farm,
        "hasAgriCrop": urns.crop(feature),
        OWN: _own(feature),
    }
    told = feature.properties
    if isinstance(told.get("category"), str):
        entity["category"] = told["category"]
    if told.get("status") in _STATES:
        entity["cropStatus"] = told["status"]
    if "seeded" in told:
        entity["lastPlantedAt"] = f"{told['seeded']}T00:00:00Z"
    return entity


def _building(feature: MapFeature, urns: _Urns) -> Entity:
    category = feature.properties.get("category")
    return {
        "id": urns.of("Building", feature.id),
        "type": "Building",
        "name": feature.name,
        "category": [category if category in _BUILDINGS else _USUAL_BUILDING],
        "address": {},  # wanted by the model; the map knows places, not addresses
        "location": feature.geometry,
        OWN: _own(feature),
    }


def _road(feature: MapFeature, urns: _Urns) -> Entity:
    line = feature.geometry["coordinates"]
    entity: Entity = {
        "id": urns.of("RoadSegment", feature.id),
        "type": "RoadSegment",
        "name": feature.name,
        "refRoad": urns.of("Road", feature.id),
        "startPoint": {"type": "Point", "coordinates": line[0]},
        "endPoint": {"type": "Point", "coordinates": line[-1]},
        "allowedVehicleType": ["agriculturalVehicle"],
        "length": round(_GEOD.geometry_length(shape(feature.geometry)) / 1000, 4),  # kilometres
        "location": feature.geometry,
        OWN: _own(feature),
    }
    if "width_m" in feature.properties:
        entity["width"] = feature.properties["width_m"]
    return entity


def _own(feature: MapFeature) -> Entity:
    return {"id": feature.id, "kind": feature.kind, "name": feature.name, "properties": feature.properties}

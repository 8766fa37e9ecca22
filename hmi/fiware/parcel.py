"""AgriParcel (dataModel.Agrifood 1.0.2): a field."""

from __future__ import annotations

from hmi.fiware.crop import crop_of
from hmi.fiware.farm import own_part
from hmi.fiware.size import area_m2
from hmi.fiware.soil import soil_of
from hmi.fiware.urn import OWN, KeyValues, Urns
from hmi.mapping.feature import MapFeature

_STATES = frozenset(("seeded", "justBorn", "growing", "maturing", "readyForHarvesting"))  # cropStatus


def parcel_entity(urns: Urns, feature: MapFeature) -> KeyValues:
    """Return a parcel; its area in m2, on the ellipsoid."""
    entity: KeyValues = {
        "id": urns.of("AgriParcel", feature.id),
        "type": "AgriParcel",
        "name": feature.name,
        "location": feature.geometry,
        "area": round(area_m2(feature.geometry), 1),
        "belongsTo": urns.farm,
        "hasAgriCrop": urns.crop(crop_of(feature)),
        OWN: own_part(feature),
    }
    told, soil = feature.properties, soil_of(feature)
    if soil is not None:
        entity["hasAgriSoil"] = urns.soil(soil)
    if isinstance(told.get("category"), str):
        entity["category"] = told["category"]
    if told.get("status") in _STATES:
        entity["cropStatus"] = told["status"]
    if "seeded" in told:
        entity["lastPlantedAt"] = f"{told['seeded']}T00:00:00.000Z"
    return entity

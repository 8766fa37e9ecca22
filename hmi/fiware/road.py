"""Road and RoadSegment (dataModel.Transportation): a farm road is one road of one segment."""

from __future__ import annotations

from hmi.fiware.farm import own_part
from hmi.fiware.size import length_m
from hmi.fiware.urn import OWN, KeyValues, Urns
from hmi.mapping.feature import MapFeature


def road_entities(urns: Urns, feature: MapFeature) -> list[KeyValues]:
    """Return the road and its segment; the feature is a line. Lengths in kilometres, as the models want."""
    length_km = round(length_m(feature.geometry) / 1000, 4)
    road: KeyValues = {
        "id": urns.of("Road", feature.id),
        "type": "Road",
        "name": feature.name,
        "roadClass": "service",
        "refRoadSegment": [urns.of("RoadSegment", feature.id)],
        "length": length_km,
    }
    return [road, _segment(urns, feature, length_km)]


def _segment(urns: Urns, feature: MapFeature, length_km: float) -> KeyValues:
    line = feature.geometry["coordinates"]
    entity: KeyValues = {
        "id": urns.of("RoadSegment", feature.id),
        "type": "RoadSegment",
        "name": feature.name,
        "refRoad": urns.of("Road", feature.id),
        "startPoint": {"type": "Point", "coordinates": line[0]},
        "endPoint": {"type": "Point", "coordinates": line[-1]},
        "allowedVehicleType": ["agriculturalVehicle"],
        "length": length_km,
        "location": feature.geometry,
        OWN: own_part(feature),
    }
    if "width_m" in feature.properties:
        entity["width"] = feature.properties["width_m"]
    return entity

"""Building (dataModel.Building)."""

from __future__ import annotations

from hmi.fiware.farm import own_part
from hmi.fiware.urn import OWN, KeyValues, Urns
from hmi.mapping.feature import MapFeature

_KINDS = frozenset(
    {"barn", "bunker", "cabin", "carport", "conservatory", "cowshed", "digester", "farm", "farm_auxiliary", "garage",
     "garages", "greenhouse", "hangar", "house", "hut", "industrial", "office", "roof", "ruins", "service", "shed",
     "stable", "sty", "warehouse", "water_tower"}
)  # of the enumeration of category  # fmt: skip
_USUAL = "farm_auxiliary"


def building_entity(urns: Urns, feature: MapFeature) -> KeyValues:
    """Return a building; one of no known kind is a ``farm_auxiliary``."""
    category = feature.properties.get("category")
    return {
        "id": urns.of("Building", feature.id),
        "type": "Building",
        "name": feature.name,
        "category": [category if category in _KINDS else _USUAL],
        "address": {},  # wanted by the model; the map knows places, not addresses
        "location": feature.geometry,
        OWN: own_part(feature),
    }

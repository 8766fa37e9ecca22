"""AgriFarm (dataModel.Agrifood 0.0.5): the farm, its land, what stands on it."""

from __future__ import annotations

from collections.abc import Sequence

from hmi.fiware.urn import OWN, KeyValues, Urns
from hmi.mapping.feature import MapFeature


def farm_entity(
    urns: Urns, name: str, land: MapFeature | None, parcels: Sequence[MapFeature], buildings: Sequence[MapFeature]
) -> KeyValues:
    """Return the farm; ``land`` is its outline, if one is drawn."""
    entity: KeyValues = {
        "id": urns.farm,
        "type": "AgriFarm",
        "name": name,
        "hasAgriParcel": [urns.of("AgriParcel", parcel.id) for parcel in parcels],
        "hasBuilding": [urns.of("Building", building.id) for building in buildings],
    }
    if land is not None:
        entity |= {"landLocation": land.geometry, OWN: own_part(land)}
    return entity


def own_part(feature: MapFeature) -> KeyValues:
    """Return the feature whole, but for its shape: what the models leave out is brought back from it."""
    return {"id": feature.id, "kind": feature.kind, "name": feature.name, "properties": feature.properties}

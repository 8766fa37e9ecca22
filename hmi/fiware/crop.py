"""AgriCrop (dataModel.Agrifood): what grows, one entity a crop."""

from __future__ import annotations

from collections.abc import Iterable

from hmi.fiware.urn import KeyValues, Urns
from hmi.mapping.feature import MapFeature

NO_CROP = "none"  # AgriParcel wants a crop even where nothing grows


def crop_of(parcel: MapFeature) -> str:
    """Return what grows on a parcel."""
    return str(parcel.properties.get("crop") or NO_CROP)


def crop_entities(urns: Urns, parcels: Iterable[MapFeature]) -> list[KeyValues]:
    """Return the crops of parcels, each once, by id."""
    crops: dict[str, KeyValues] = {}
    for name in map(crop_of, parcels):
        crops.setdefault(urns.crop(name), {"id": urns.crop(name), "type": "AgriCrop", "name": name})
    return [crops[key] for key in sorted(crops)]

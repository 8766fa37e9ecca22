"""The farm map as GeoJSON (RFC 7946); nothing is lost."""

from __future__ import annotations

from collections.abc import Sequence

from hmi.map_files.exported import MapFile, json_bytes, stem
from hmi.mapping.feature import MapFeature, collection


def write(features: Sequence[MapFeature], farm_id: str, farm_name: str) -> MapFile:
    """Return one feature collection; the farm's name is its foreign member ``name`` (section 6.1)."""
    root = collection(features)
    named = {"type": root["type"], "name": farm_name, "features": root["features"]}
    return MapFile(json_bytes(named), "application/geo+json", f"{stem(farm_id)}.geojson")

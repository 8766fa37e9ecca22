"""Sizes on the ellipsoid; shapely and pyproj come with the first question, not with the console."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def area_m2(geometry: Mapping[str, Any]) -> float:
    """Return the area of a GeoJSON polygon."""
    from pyproj import Geod
    from shapely.geometry import shape

    return abs(float(Geod(ellps="WGS84").geometry_area_perimeter(shape(geometry))[0]))


def length_m(geometry: Mapping[str, Any]) -> float:
    """Return the length of a GeoJSON line."""
    from pyproj import Geod
    from shapely.geometry import shape

    return float(Geod(ellps="WGS84").geometry_length(shape(geometry)))

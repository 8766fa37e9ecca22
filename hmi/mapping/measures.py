"""Measures of features: areas in m², lengths in metres, on the plane beside the feature."""

from __future__ import annotations

import math

import numpy as np

from hmi.mapping.coordinates import Position, is_ring, paths
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import frame_of, place, shape_of, sound


def area_m2(feature: MapFeature) -> float:
    """Return the area inside the outline without holes; 0 for lines, and for points the circle of their radius."""
    if not is_ring(feature.geometry):
        radius_m = feature.properties.get("radius_m", 0.0) if feature.geometry["type"] == "Point" else 0.0
        return math.pi * float(radius_m) ** 2
    return float(sound(shape_of(feature.geometry, frame_of([feature]))).area)


def edge_m(feature: MapFeature) -> float:
    """Return the length of all edges, holes included; 0 for points."""
    return float(sum(sum(edge_lengths_m(feature, number)) for number in range(len(paths(feature.geometry)))))


def edge_lengths_m(feature: MapFeature, path: int = 0) -> list[float]:
    """Return the length of each edge of a ring or line; edge n runs from corner n to the next.

    Raises:
        IndexError: the feature has no such ring or line.
    """
    corners = frame_of([feature]).to_local(paths(feature.geometry)[path])
    steps = np.diff(corners, axis=0)
    return [float(length) for length in np.hypot(steps[:, 0], steps[:, 1])]


def centroid(feature: MapFeature) -> Position:
    """Return the balance point as ``[longitude, latitude]``; it may lie outside a crooked outline."""
    frame = frame_of([feature])
    return place(shape_of(feature.geometry, frame).centroid.coords[0], frame)


def area_text(area: float) -> str:
    """Return an area of m² for people: ``1.4 m²``, ``14 m²``, ``1.22 ha``."""
    if area < 9.95:
        return f"{area:.1f} m²"
    return f"{area:.0f} m²" if area < 1000 else f"{area / 10_000:.2f} ha"

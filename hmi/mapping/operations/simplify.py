"""Leave out corners that change a shape by less than a tolerance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon

from hmi.mapping.coordinates import Geometry, is_ring, paths, with_paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import Shape, frame_of, line_geometry, polygon_geometry, shape_of
from hmi.mapping.kinds import POINT
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.selection import Selection, sound_polygon, title
from hmi.planning.projection import Floats

MOST_M = 50.0
LEAST_M = 0.001
_STEPS = 8  # where edges would cross, half the tolerance is tried, and so on


def simplify(selection: Selection, arguments: Arguments) -> Outcome:
    """Leave out corners as long as the edge stays within ``tolerance_m`` of where it was.

    Raises:
        OperationRefused: a point, an outline that crosses itself, or nothing to leave out.
    """
    tolerance_m = arguments.number("tolerance_m", LEAST_M, MOST_M)
    feature = selection.one()
    if feature.geometry["type"] == POINT:
        raise OperationRefused("no_edge", f"{title(feature)} is a point and has no edges. Choose an area or a line.")
    geometry = _simplified(feature, tolerance_m)
    before, after = _count(feature.geometry), _count(geometry)
    if after >= before:
        raise OperationRefused(
            "nothing_to_do", f"{title(feature)} has no corner to leave out. Allow a larger tolerance."
        )
    label = f"{title(feature)} simplified from {before:,} to {after:,} corners"
    return Outcome(label, (changed(feature, replace(feature, geometry=geometry)),))


def _simplified(feature: MapFeature, tolerance_m: float) -> Geometry:
    frame = frame_of([feature])
    if is_ring(feature.geometry):
        shape = sound_polygon(feature, frame)
        for step in range(_STEPS):
            polygon = _thinned(shape, tolerance_m / 2**step)
            geometry = None if polygon is None else polygon_geometry(polygon, frame)
            if geometry is not None:
                return geometry
        return feature.geometry
    lines = shapely.get_parts(shape_of(feature.geometry, frame).simplify(tolerance_m, preserve_topology=False))
    return with_paths(feature.geometry, [line_geometry(line.coords, frame)["coordinates"] for line in lines])


def _thinned(shape: Shape, tolerance_m: float) -> Shape | None:
    """Return the polygon with fewer corners; ``None`` if a ring would vanish or edges would cross."""
    rings = [_thinned_ring(np.array(ring.coords)[:-1], tolerance_m) for ring in (shape.exterior, *shape.interiors)]
    if min(map(len, rings)) < 4:
        return None
    polygon = Polygon(rings[0], rings[1:])
    return polygon if polygon.is_valid else None


def _thinned_ring(ring: Floats, tolerance_m: float) -> Floats:
    # begin at the corner furthest out: the first one stays
    start = int(np.argmax(np.hypot(*(ring - ring.mean(axis=0)).T)))
    turned = np.roll(ring, -start, axis=0)
    found: Floats = np.array(LineString([*turned, turned[0]]).simplify(tolerance_m, preserve_topology=False).coords)
    return found


def _count(geometry: Geometry) -> int:
    return sum(len(path) - (1 if is_ring(geometry) else 0) for path in paths(geometry))

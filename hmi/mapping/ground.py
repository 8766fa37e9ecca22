"""Features on a plane in metres: frames, shapes, and the way back to rounded degrees.

The frame of features is an ENU plane (``hmi.planning.projection``) at the middle of them. Its datum is rounded to
0.01 degrees, so that features that move a little keep their frame and projections are found ready.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import shapely
from shapely.geometry import LineString, MultiLineString, MultiPolygon, Point, Polygon

from hmi.domain.map_ground import WIDTHS_M
from hmi.mapping.coordinates import DECIMALS, Geometry, Position, paths, positions, rounded
from hmi.mapping.feature import MapFeature
from hmi.mapping.kinds import LINE, LINES, POINT, POLYGON
from hmi.planning.projection import Floats, LocalFrame

Shape = Any
"""A shapely geometry in metres."""

DATUM_DECIMALS = 2
GRID_M = 1e-5  # overlays snap to it: never unsound, and a hundredth of what is kept


def frame_at(lon_lat_deg: Iterable[Sequence[float]]) -> LocalFrame:
    """Return the frame in the middle of the box around positions.

    Raises:
        ValueError: no positions.
    """
    points = np.asarray(list(lon_lat_deg), dtype=np.float64).reshape(-1, 2)
    if not len(points):
        raise ValueError("no positions")
    lon, lat = (points.min(axis=0) + points.max(axis=0)) / 2
    return LocalFrame(round(float(lat), DATUM_DECIMALS), round(float(lon), DATUM_DECIMALS))


def frame_of(features: Iterable[MapFeature]) -> LocalFrame:
    """Return the frame in the middle of features."""
    return frame_at(p for one in features for p in positions(one.geometry))


def shape_of(geometry: Geometry, frame: LocalFrame) -> Shape:
    """Return a geometry as shapely's, metres east and north in ``frame``; it may be invalid, as drawn."""
    local = [frame.to_local(path) for path in paths(geometry)]
    kind = geometry["type"]
    if kind == POINT:
        return Point(local[0][0])
    if kind == LINE:
        return LineString(local[0])
    if kind == LINES:
        return MultiLineString(local)
    return Polygon(local[0], local[1:])


def covered_by(feature: MapFeature, frame: LocalFrame) -> Shape:
    """Return the ground a feature covers, metres: lines with their width, points with their radius."""
    return widened(feature, shape_of(feature.geometry, frame))


def widened(feature: MapFeature, shape: Shape) -> Shape:
    """Return the ground a feature covers whose shape is ``shape``, both in metres."""
    if feature.geometry["type"] == POLYGON:
        return sound(shape)
    if feature.geometry["type"] == POINT:
        return shape.buffer(feature.properties.get("radius_m", 0.0))
    return shape.buffer(half_width_m(feature), cap_style="flat", join_style="mitre")


def half_width_m(feature: MapFeature) -> float:
    """Return half the width of a line feature, metres; of one without a width what is drawn, of rows 0."""
    return float(feature.properties.get("width_m", WIDTHS_M.get(feature.kind, 0.0))) / 2


def polygons_in(shape: Shape) -> list[Polygon]:
    """Return the polygons of any shape, largest first."""
    parts = [part for part in shapely.get_parts(shapely.get_parts(shape)) if part.geom_type == "Polygon"]
    return sorted((part for part in parts if not part.is_empty), key=lambda part: -part.area)


def areas_in(shape: Shape) -> MultiPolygon:
    """Return the polygons of any shape as one, without the lines and points overlays may leave."""
    return MultiPolygon(polygons_in(shape))


def sound(shape: Shape) -> Shape:
    """Return polygons as they are, or cut where their edges cross; polygons only, perhaps none."""
    if shape.is_valid:
        return shape
    # GEOS may leave a collapsed line beside the polygons
    return areas_in(shapely.make_valid(shape, method="structure", keep_collapsed=False))


def polygon_geometry(polygon: Polygon, frame: LocalFrame) -> Geometry | None:
    """Return a polygon of ``frame`` in rounded degrees, outer ring counter-clockwise, holes clockwise.

    Rounding can fold what is thinner than 1 mm; that is taken away. ``None`` if nothing is left.
    """
    outer, *inner = (_degrees(ring.coords, frame) for ring in (polygon.exterior, *polygon.interiors))
    if not _is_area(outer):
        return None
    flat = Polygon(outer, [ring for ring in inner if _is_area(ring)])
    if not flat.is_valid:
        flat = next(iter(polygons_in(shapely.set_precision(sound(flat), 10**-DECIMALS))), Polygon())
    if flat.is_empty:
        return None
    flat = shapely.orient_polygons(flat)
    wound = [[rounded(*xy) for xy in ring.coords] for ring in (flat.exterior, *flat.interiors)]
    return {"type": POLYGON, "coordinates": wound}


def line_geometry(line_m: Floats, frame: LocalFrame) -> Geometry:
    """Return a line of ``frame`` in rounded degrees, points that fall together once."""
    return {"type": LINE, "coordinates": _degrees(line_m, frame)}


def place(xy_m: Sequence[float], frame: LocalFrame) -> Position:
    """Return one place of ``frame`` in rounded degrees."""
    return rounded(*frame.to_lon_lat([xy_m])[0])


def distance_m(a: Sequence[float], b: Sequence[float]) -> float:
    """Return metres between two positions on the sphere, good to 0.5 %; for what is far apart."""
    lon_a, lat_a, lon_b, lat_b = map(math.radians, (a[0], a[1], b[0], b[1]))
    h = math.sin((lat_b - lat_a) / 2) ** 2 + math.cos(lat_a) * math.cos(lat_b) * math.sin((lon_b - lon_a) / 2) ** 2
    return 2 * 6_371_000 * math.asin(min(1.0, math.sqrt(h)))


def _degrees(points_m: Any, frame: LocalFrame) -> list[Position]:
    found: list[Position] = []
    for lon, lat in frame.to_lon_lat(np.asarray(points_m)[:, :2]):
        at = rounded(lon, lat)
        if not found or at != found[-1]:
            found.append(at)
    return found


def _is_area(ring: list[Position]) -> bool:
    return len(ring) >= 4 and ring[0] == ring[-1]

"""A farm and a mission for the map: the real Dutch parcel, with rows, turns and surroundings laid in code."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

from pyproj import Transformer
from shapely import affinity
from shapely.geometry import LineString, Polygon, shape

PARCEL = Path(__file__).parent / "fixtures" / "nl-parcel.geojson"
"""Fields2Cover test data, BSD-3-Clause, Wageningen University."""

ROW_WIDTH_M = 6.0
HEADLAND_M = 14.0

_TO_M = Transformer.from_crs(4326, 32631, always_xy=True)


def _lonlat(points: Any) -> list[list[float]]:
    return [list(_TO_M.transform(x, y, direction="INVERSE")) for x, y in points]


def _feature(kind: str, kind_of: str, coordinates: Any, **properties: Any) -> dict[str, Any]:
    return {
        "type": "Feature",
        "properties": {"kind": kind, **properties},
        "geometry": {"type": kind_of, "coordinates": coordinates},
    }


def parcel_m() -> Polygon:
    """Return the parcel in UTM metres."""
    [feature] = json.loads(PARCEL.read_text("utf-8"))["features"]
    geometry = shape(feature["geometry"])
    outer = geometry.geoms[0] if geometry.geom_type == "MultiPolygon" else geometry
    return Polygon([to_m(lon, lat) for lon, lat in outer.exterior.coords])


@cache
def _rows() -> list[LineString]:
    parcel = parcel_m()
    inner = parcel.buffer(-HEADLAND_M)
    box = inner.minimum_rotated_rectangle
    corners = list(box.exterior.coords)
    angle = math.degrees(math.atan2(corners[1][1] - corners[0][1], corners[1][0] - corners[0][0]))
    level = affinity.rotate(inner, -angle, origin=box.centroid)
    left, low, right, high = level.bounds
    rows = []
    count = int((high - low) / ROW_WIDTH_M)
    for i in range(count):
        y = low + (i + 0.5) * ROW_WIDTH_M
        line = level.intersection(LineString([(left - 9, y), (right + 9, y)]))
        if line.geom_type == "LineString" and not line.is_empty:
            turned = affinity.rotate(line, angle, origin=box.centroid)
            rows.append(turned if len(rows) % 2 == 0 else LineString(list(turned.coords)[::-1]))
    return rows


def _turn(row: LineString, following: LineString) -> list[tuple[float, float]]:
    (x0, y0), (x1, y1) = row.coords[0], row.coords[-1]
    (p, q), (r, s) = (x1, y1), following.coords[0]
    along = math.atan2(y1 - y0, x1 - x0)
    points = []
    for k in range(13):
        t = k / 12
        bulge = 6.0 * math.sin(math.pi * t)
        points.append((p + (r - p) * t + bulge * math.cos(along), q + (s - q) * t + bulge * math.sin(along)))
    return points


def mission() -> dict[str, Any]:
    """Return mission GeoJSON in driving order: parcel, rows and turns, home."""
    features = [_feature("parcel", "Polygon", [_lonlat(parcel_m().exterior.coords)], name="Nordfeld 12")]
    rows = _rows()
    for number, row in enumerate(rows, start=1):
        features.append(_feature("row", "LineString", _lonlat(row.coords), row=number))
        if number < len(rows):
            features.append(_feature("turn", "LineString", _lonlat(_turn(row, rows[number])), row=0))
    return {"type": "FeatureCollection", "features": features}


def row_point(number: int, share: float) -> tuple[float, float, float]:
    """Return (lon, lat, heading in degrees) at ``share`` of row ``number``, counted from 1."""
    row = _rows()[number - 1]
    here = row.interpolate(share, normalized=True)
    (x0, y0), (x1, y1) = row.coords[0], row.coords[-1]
    [[lon, lat]] = _lonlat([(here.x, here.y)])
    [[lon0, lat0], [lon1, lat1]] = _lonlat([(x0, y0), (x1, y1)])
    heading = math.degrees(math.atan2((lon1 - lon0) * math.cos(math.radians(lat)), lat1 - lat0)) % 360
    return lon, lat, heading


def farm() -> dict[str, Any]:
    """Return the farm: the parcel, a neighbour, road, trees, ditch, barn, pylon and home."""
    parcel = parcel_m()
    left, low, right, high = parcel.bounds
    road = LineString([(left - 60, low - 40), (right + 80, low - 55)])
    neighbour = Polygon([(right + 40, low), (right + 300, low + 20), (right + 280, high), (right + 60, high - 40)])
    pylon = parcel.representative_point().buffer(6)
    ditch = LineString([(left - 200, high + 30), (right + 300, high + 10)])
    trees = [(right + 20, low + 30 + 22 * i) for i in range(20)]
    barn = Polygon([(left - 40, low - 30), (left - 10, low - 30), (left - 10, low - 12), (left - 40, low - 12)])
    features = [
        _feature("parcel", "Polygon", [_lonlat(parcel.exterior.coords)], name="Nordfeld 12", crop="sugar beet"),
        _feature("parcel", "Polygon", [_lonlat(neighbour.exterior.coords)], name="Westschlag 3"),
        _feature("road", "LineString", _lonlat(road.coords), width_m=6),
        _feature("water", "LineString", _lonlat(ditch.coords), width_m=5),
        _feature("building", "Polygon", [_lonlat(barn.exterior.coords)]),
        _feature("obstacle", "Polygon", [_lonlat(pylon.exterior.coords)], name="pylon"),
        _feature("home", "Point", _lonlat([(left - 25, low - 5)])[0]),
        *[_feature("tree", "Point", _lonlat([tree])[0], radius_m=5) for tree in trees],
    ]
    return {"type": "FeatureCollection", "features": features}


def to_m(lon: float, lat: float) -> tuple[float, float]:
    """Return UTM metres of a point."""
    x, y = _TO_M.transform(lon, lat)
    return x, y

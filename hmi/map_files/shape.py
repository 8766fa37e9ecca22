"""Geometry from files made fit for the map: finite, closed, wound (RFC 7946 section 3.1.6), in WGS84."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain
from typing import Any

import numpy as np
from shapely import Polygon, is_valid

from hmi.map_files import limits
from hmi.map_files.coordinate_system import NOTABLE_ERROR_M, UNKNOWN_ERROR_M, CoordinateSystem, UnknownSystem
from hmi.map_files.imported import Geometry
from hmi.map_files.limits import Allowance

Line = list[list[float]]
_DEPTH_OF = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}
_SINGLE_OF = {"MultiPoint": "Point", "MultiPolygon": "Polygon"}
_NUMBERS = {int, float}
_DECIMALS = 8  # a millimetre, as hmi.mapping keeps it


class BadShape(Exception):
    """A shape that cannot be taken.

    Attributes:
        why, mend: sentences for the operator.
    """

    def __init__(self, why: str, mend: str) -> None:
        super().__init__(why, mend)
        self.why = why
        self.mend = mend


def simple_parts(raw: Any, depth: int = 0) -> list[Geometry]:
    """Return the points, lines and polygons of a GeoJSON geometry; a multi-line stays one.

    Raises:
        BadShape: it is not a geometry.
    """
    if raw is None:
        raise BadShape("It has no shape.", "Draw it, or take it out of the file.")
    kind = raw.get("type") if isinstance(raw, dict) else None
    if kind == "GeometryCollection" and isinstance(raw.get("geometries"), list) and depth < limits.DEPTH:
        if not raw["geometries"]:
            raise BadShape("It has no shape.", "Draw it, or take it out of the file.")
        return [part for inner in raw["geometries"] for part in simple_parts(inner, depth + 1)]
    if not isinstance(kind, str) or kind not in _DEPTH_OF:
        raise BadShape("Its geometry is not one of GeoJSON's.", "Export it as point, line or polygon.")
    coordinates = raw.get("coordinates")
    if not isinstance(coordinates, list) or not coordinates:
        raise BadShape("It has no coordinates.", "Draw it, or take it out of the file.")
    if kind in {"MultiPoint", "MultiPolygon"}:
        return [{"type": _SINGLE_OF[kind], "coordinates": part} for part in coordinates]
    return [{"type": kind, "coordinates": coordinates}]


def fit(part: Geometry, crs: CoordinateSystem, allowance: Allowance, problems: list[str]) -> Geometry:
    """Return one part of ``simple_parts`` in WGS84, closed and wound; append what was mended or should be looked at.

    Raises:
        BadShape: it cannot be taken.
        BadMapFile: the file has too many corners.
    """
    kind = part["type"]
    lines = [_finite(line, allowance) for line in _lines(part["coordinates"], _DEPTH_OF[kind])]
    lines = _converted(lines, crs, problems)
    _check_places([position for line in lines for position in line])
    if kind == "Point":
        return {"type": kind, "coordinates": lines[0][0]}
    if kind == "Polygon":
        rings = [_ring(lines[0], problems, is_hole=False), *_holes(lines[1:], problems)]
        if not is_valid(Polygon(np.array(rings[0]), [np.array(ring) for ring in rings[1:]])):
            problems.append("An edge crosses or touches itself, or a hole leaves the outline. Look at it before use.")
        return {"type": kind, "coordinates": rings}
    for line in lines:
        if all(position == line[0] for position in line):
            raise BadShape("It is a line of one place only.", "Draw it again with two points or more.")
    return {"type": kind, "coordinates": lines[0] if kind == "LineString" else lines}


def outline_of(line: Geometry) -> Geometry | None:
    """Return the polygon whose edge a fit line is; ``None`` if it does not end where it began or spans nothing."""
    places = line["coordinates"]
    if line["type"] != "LineString" or len(places) < 4 or places[0] != places[-1]:
        return None
    try:
        return {"type": "Polygon", "coordinates": [_ring(places, [], is_hole=False)]}
    except BadShape:
        return None


def lines_of(geometry: Geometry) -> list[Line]:
    """Return the lines or rings of a fit geometry; a point is a line of one position."""
    return _lines(geometry["coordinates"], _DEPTH_OF[geometry["type"]])


def _lines(coordinates: Any, depth: int) -> list[Any]:
    if depth == 0:
        return [[coordinates]]
    lines = [coordinates] if depth == 1 else coordinates
    if lines == []:
        raise BadShape("It has no coordinates.", "Draw it, or take it out of the file.")
    if not isinstance(lines, list) or not all(isinstance(line, list) and line for line in lines):
        raise BadShape("Its coordinates are not nested as its type wants.", "Export it again.")
    return lines


def _finite(line: list[Any], allowance: Allowance) -> Line:
    allowance.vertices(len(line))
    plain = _plain(line)
    return [_position(position) for position in line] if plain is None else plain


def _plain(line: list[Any]) -> Line | None:
    """Return a line of usable pairs of numbers all at once, ``None`` where one by one must be said what is wrong."""
    if set(map(type, line)) != {list} or not set(map(len, line)) <= {2}:
        return None
    if not set(map(type, chain.from_iterable(line))) <= _NUMBERS:
        return None
    try:
        xy = np.array(line, dtype=np.float64)
    except OverflowError:
        return None
    return line if bool((np.abs(xy) <= 1e9).all()) else None  # NaN is not below anything


def _position(raw: Any) -> list[float]:
    if not isinstance(raw, (list, tuple)) or len(raw) < 2:
        raise BadShape("A position has less than two numbers.", "Export it again.")
    for number in raw[:2]:
        if isinstance(number, bool) or not isinstance(number, (int, float)):
            raise BadShape(f"{str(number)[:20]!r} stands where a coordinate should be.", "Export it again.")
        if (isinstance(number, float) and not math.isfinite(number)) or abs(number) > 1e9:
            raise BadShape("A coordinate is not a number on earth (NaN or infinite).", "Draw this shape again.")
    return [float(raw[0]), float(raw[1])]


def _converted(lines: list[Line], crs: CoordinateSystem, problems: list[str]) -> list[Line]:
    if crs.is_wgs84:
        return [(np.round(np.array(line, dtype=np.float64), _DECIMALS) + 0.0).tolist() for line in lines]
    flat = [position for line in lines for position in line]
    try:
        lons, lats, error_m = crs.to_wgs84([p[0] for p in flat], [p[1] for p in flat])
    except UnknownSystem as error:
        raise BadShape(str(error), "Export the file again in WGS84 (EPSG:4326).") from error
    if not all(math.isfinite(n) for n in (*lons, *lats)):
        raise BadShape(f"A position lies outside of what {crs.label} covers.", "Check the coordinate system.")
    if math.isinf(error_m):
        off = f"positions may be off by {UNKNOWN_ERROR_M} m. Check them on the field."
        problems.append(f"How {crs.label} lies on the earth is not known: {off}")
    elif error_m > NOTABLE_ERROR_M:
        problems.append(f"Converted from {crs.label}: positions may be off by {error_m:g} m. Check them on the field.")
    places = iter(zip(lons, lats, strict=True))
    return [[_rounded(next(places)) for _ in line] for line in lines]


def _rounded(place: Sequence[float]) -> list[float]:
    return [round(place[0], _DECIMALS) + 0.0, round(place[1], _DECIMALS) + 0.0]  # no negative zero


def _check_places(places: Line) -> None:
    reach = np.abs(np.array(places, dtype=np.float64)).max(axis=0)
    for lon, lat in places if reach[0] > 180 or reach[1] > 90 else ():
        if abs(lon) <= 180 and abs(lat) <= 90:
            continue
        if abs(lat) <= 180 and abs(lon) <= 90:
            why = f"Latitude {lat:g} is beyond 90: latitude and longitude are likely exchanged."
            raise BadShape(why, "Export it with longitude first.")
        why = f"{lon:g}, {lat:g} is not a longitude and latitude."
        raise BadShape(why, "Export the file in WGS84 (EPSG:4326), or with its coordinate system.")
    lons = [lon for lon, _ in places]
    if max(lons) - min(lons) > 180:
        raise BadShape("It crosses the 180° meridian, which the map cannot show.", "Cut it there into two.")


def _ring(line: Line, problems: list[str], *, is_hole: bool) -> Line:
    ring = line
    if ring[0] != ring[-1]:
        problems.append("A ring was open and was closed.")
        ring = [*ring, list(ring[0])]
    if len(ring) < 4 or len({tuple(position) for position in ring}) < 3:
        raise BadShape("A polygon needs three corners or more.", "Draw it again.")
    area = _signed_area(ring)
    if area == 0:
        why = "its edge crosses itself" if _is_spread(ring) else "its corners lie in one line"
        raise BadShape(f"The polygon has no area: {why}.", "Draw it again.")
    return ring[::-1] if (area > 0) == is_hole else ring


def _holes(lines: list[Line], problems: list[str]) -> list[Line]:
    """Return the holes that are some; a field is not lost for one that is a line."""
    kept = []
    for line in lines:
        try:
            kept.append(_ring(line, problems, is_hole=True))
        except BadShape:
            problems.append("A hole without area was left out.")
    return kept


def _is_spread(ring: Line) -> bool:
    """Say whether three corners in a row span an area: then two loops of the ring take each other's away."""
    return any(_signed_area([*ring[k : k + 3], ring[k]]) != 0 for k in range(len(ring) - 2))


def _signed_area(ring: Line) -> float:
    """Return the area in square degrees, positive if counter-clockwise; seen from a corner to keep its digits."""
    x, y = (np.array(ring, dtype=np.float64) - ring[0]).T
    return float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum()) / 2

"""GeoJSON coordinates: read strictly, rounded to 8 decimals of a degree (1 mm), walked through ring by ring."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from hmi.mapping.errors import BadFeature
from hmi.mapping.kinds import LINE, LINES, POINT, POLYGON

Position = list[float]
"""``[longitude, latitude]``, degrees."""
Geometry = dict[str, Any]
"""A GeoJSON geometry: ``type`` and ``coordinates`` only."""

DECIMALS = 8  # 1e-8 degrees are 1.1 mm, a tenth of what RTK can tell apart
MOST_VERTICES = 100_000  # in one feature; a walk at 10 Hz is that long after almost three hours


def parse_geometry(raw: object) -> Geometry:
    """Return a geometry with rounded coordinates and closed rings; heights are dropped, the map is flat.

    Raises:
        BadFeature: not a Polygon, LineString, MultiLineString or Point of places on earth.
    """
    if not isinstance(raw, dict) or not isinstance(raw.get("type"), str):
        raise BadFeature("no_geometry", "It has no shape. Draw one, or leave it out.")
    kind, coordinates = raw["type"], raw.get("coordinates")
    count = _vertices(coordinates)
    if count > MOST_VERTICES:
        raise BadFeature(
            "too_many_corners", f"It has {count:,} corners, at most {MOST_VERTICES:,} are possible. Simplify it first."
        )
    if kind == POINT:
        return {"type": kind, "coordinates": parse_position(coordinates, "The point")}
    if kind == LINE:
        return {"type": kind, "coordinates": parse_line(coordinates)}
    if kind == LINES:
        return {"type": kind, "coordinates": [parse_line(line) for line in _list(coordinates, "The lines")]}
    if kind == POLYGON:
        return {"type": kind, "coordinates": [parse_ring(ring) for ring in _list(coordinates, "The outline")]}
    raise BadFeature(
        "wrong_geometry", f"Its shape is a {kind[:40]}. Use a Polygon, LineString, MultiLineString or Point."
    )


def parse_position(raw: object, what: str) -> Position:
    """Return ``[lon, lat]`` rounded; ``what`` names the place in the error's sentence.

    Raises:
        BadFeature: not two numbers, not finite, or not on earth.
    """
    if not isinstance(raw, (list, tuple)) or len(raw) < 2 or not all(map(_is_number, raw[:2])):
        raise BadFeature("bad_coordinates", f"{what} is not a pair of longitude and latitude. Draw it again.")
    # a whole number beyond any float is as far off as infinity
    lon, lat = (float(v) if abs(v) < 1e300 else math.inf for v in raw[:2])
    if not (math.isfinite(lon) and math.isfinite(lat)):
        raise BadFeature("bad_coordinates", f"{what} has no position. Draw it again.")
    if abs(lat) > 90:
        hint = "Longitude comes first; they may be exchanged." if abs(lon) <= 90 else "Metres of a grid are no degrees."
        raise BadFeature("bad_coordinates", f"{what} has latitude {lat:g}, beyond 90 degrees. {hint}")
    if abs(lon) > 180:
        raise BadFeature("bad_coordinates", f"{what} has longitude {lon:g}, beyond 180 degrees. Check the position.")
    return rounded(lon, lat)


def rounded(lon: float, lat: float) -> Position:
    """Return ``[lon, lat]`` as it is kept; negative zero becomes zero."""
    return [round(float(lon), DECIMALS) + 0.0, round(float(lat), DECIMALS) + 0.0]


def parse_line(raw: object) -> list[Position]:
    """Return a line of two or more different points.

    Raises:
        BadFeature: see ``parse_position``; too few points.
    """
    line = [parse_position(p, f"Point {n}") for n, p in enumerate(_list(raw, "The line"), 1)]
    if len({tuple(p) for p in line}) < 2:
        raise BadFeature("too_few_corners", "A line needs two different points. Draw it again.")
    return line


def parse_ring(raw: object) -> list[Position]:
    """Return a closed ring of three or more different corners; an open one is closed.

    Raises:
        BadFeature: see ``parse_position``; too few corners.
    """
    ring = [parse_position(p, f"Corner {n}") for n, p in enumerate(_list(raw, "The outline"), 1)]
    if len({tuple(p) for p in ring}) < 3:
        raise BadFeature("too_few_corners", "An outline needs three different corners. Add corners, or remove it.")
    return ring if ring[0] == ring[-1] else [*ring, list(ring[0])]


def paths(geometry: Geometry) -> list[list[Position]]:
    """Return the rings of a polygon (outer first), the lines of lines, or the one place of a point."""
    coordinates: Any = geometry["coordinates"]
    wrapped = {POINT: [[coordinates]], LINE: [coordinates]}
    found: list[list[Position]] = wrapped.get(geometry["type"], coordinates)
    return found


def with_paths(geometry: Geometry, new: Sequence[list[Position]]) -> Geometry:
    """Return the geometry with other rings, lines or place; the opposite of ``paths``."""
    unwrapped: dict[str, Callable[[], Any]] = {POINT: lambda: new[0][0], LINE: lambda: new[0]}
    return {"type": geometry["type"], "coordinates": unwrapped.get(geometry["type"], lambda: list(new))()}


def positions(geometry: Geometry) -> Iterator[Position]:
    """Yield every position, the closing one of each ring as well."""
    for path in paths(geometry):
        yield from path


def is_ring(geometry: Geometry) -> bool:
    """Say whether the paths of a geometry are closed rings."""
    return bool(geometry["type"] == POLYGON)


def _list(raw: object, what: str) -> Sequence[Any]:
    if not isinstance(raw, (list, tuple)) or not raw:
        raise BadFeature("bad_coordinates", f"{what} has no coordinates. Draw it again.")
    return raw


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _vertices(raw: object, depth: int = 0) -> int:
    if not isinstance(raw, (list, tuple)) or depth > 3:
        return 0
    if raw and _is_number(raw[0]):
        return 1
    return sum(_vertices(one, depth + 1) for one in raw)

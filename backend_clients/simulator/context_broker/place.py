"""Locations: the geo types of attributes, and the geo part of a query."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.errors import ShapelyError
from shapely.geometry import shape
from shapely.geometry.base import BaseGeometry

from backend_clients.simulator.context_broker.json_text import Json, stored
from backend_clients.simulator.context_broker.refusal import bad_request

EARTH_M = 6_378_100.0  # the sphere that the store behind Orion measures on
GEO_TYPES = ("geo:json", "geo:point", "geo:line", "geo:box", "geo:polygon")
RELATIONS = ("coveredBy", "intersects", "disjoint", "equals")
GEOMETRIES = ("point", "line", "box", "polygon")


def is_geo_type(kind: str) -> bool:
    """Say whether attributes of this type are locations."""
    return kind in GEO_TYPES


def kept_geometry(kind: str, value: Json) -> Json:
    """Return the value as it is kept: of a GeoJSON feature only its geometry stays."""
    if kind == "geo:json":
        value = _bare_geometry(value)
    geometry_of(kind, value)
    return stored(value)


def geometry_of(kind: str, value: Json) -> BaseGeometry:
    """Return the shape of a geo attribute, lon and lat in degrees."""
    try:
        if kind == "geo:json":
            return _geo_json(value)
        texts = [value] if isinstance(value, str) else value
        return _drawn(kind.removeprefix("geo:"), [_lon_lat(text) for text in texts])
    except (ValueError, TypeError, KeyError, AttributeError, IndexError, ShapelyError) as error:
        raise bad_request(f"error parsing location attribute: {error}"[:200].translate(_NO_QUOTES)) from error


_NO_QUOTES = str.maketrans("\"'<>", "    ")


@dataclass(frozen=True, slots=True)
class GeoFilter:
    """The geo part of a query: a relation to a shape, or a distance from a point, in metres."""

    relation: str
    shape: BaseGeometry
    min_m: float = 0.0
    max_m: float = math.inf

    def matches(self, place: BaseGeometry) -> bool:
        """Say whether an entity there is meant. Relations are planar in degrees, distances are on the sphere."""
        if self.relation == "near":
            return self.min_m <= self.distance_m(place) <= self.max_m
        if self.relation == "coveredBy":
            return bool(place.covered_by(self.shape))
        if self.relation == "intersects":
            return bool(place.intersects(self.shape))
        if self.relation == "disjoint":
            return bool(place.disjoint(self.shape))
        return bool(place.equals(self.shape))

    def distance_m(self, place: BaseGeometry) -> float:
        """Return how far it is from the point of a ``near`` query, in metres."""
        centre = np.radians([self.shape.centroid.x, self.shape.centroid.y])
        return float(shapely.transform(place, lambda at: _around(centre, at)).distance(shapely.Point(0, 0)))


def read_geo_filter(georel: str, geometry: str, coords: str) -> GeoFilter | None:
    """Return the geo part of a query; without ``georel`` the rest is ignored. ``coords`` is lat,lon."""
    if not georel:
        return None
    if not geometry:
        raise bad_request("Invalid query: geometry is missing")
    if not coords:
        raise bad_request("Invalid query: coordinates are missing")
    relation, *modifiers = georel.split(";")
    if geometry not in GEOMETRIES:
        raise bad_request("error parsing geo-filter: unsupported geometry")
    try:
        points = [_lon_lat(text) for text in coords.split(";")]
        drawn = _drawn(geometry, points)
    except (ValueError, IndexError) as error:
        raise bad_request("error parsing geo-filter: invalid coordinates") from error
    if relation == "near":
        return _near(modifiers, geometry, drawn)
    if relation not in RELATIONS or modifiers:
        raise bad_request("error parsing geo-filter: unknown georel")
    return GeoFilter(relation, drawn)


def _near(modifiers: list[str], geometry: str, point: BaseGeometry) -> GeoFilter:
    if geometry != "point":
        raise bad_request("Query not supported: near needs a point")
    limits = {"minDistance": 0.0, "maxDistance": math.inf}
    for modifier in modifiers:
        name, _, value = modifier.partition(":")
        try:
            limits[name if name in limits else ""] = float(value)
        except ValueError as error:
            raise bad_request(f"error parsing geo-filter: invalid {name}") from error
    if "" in limits or not modifiers or any(limit < 0 or math.isnan(limit) for limit in limits.values()):
        raise bad_request("Invalid query: near needs minDistance or maxDistance")
    return GeoFilter("near", point, limits["minDistance"], limits["maxDistance"])


def _bare_geometry(value: Json) -> Json:
    if isinstance(value, dict) and value.get("type") == "FeatureCollection":
        features = value.get("features")
        if not isinstance(features, list) or len(features) != 1:
            raise bad_request("error parsing location attribute: a FeatureCollection needs exactly one Feature")
        value = features[0]
    if isinstance(value, dict) and value.get("type") == "Feature":
        value = value.get("geometry")
    return value


def _geo_json(value: Json) -> BaseGeometry:
    if not isinstance(value, dict):
        raise ValueError("geo:json needs a JSON object")
    for ring in value["coordinates"] if value.get("type") == "Polygon" else []:
        if len(ring) < 4 or ring[0] != ring[-1]:
            raise ValueError("a polygon needs a closed ring of four points or more")
    found: BaseGeometry = shape(value)
    if found.is_empty:
        raise ValueError("empty geometry")
    _check_range(np.asarray(shapely.get_coordinates(found)))
    if found.geom_type == "GeometryCollection":
        raise ValueError("unsupported geometry")
    return found


def _drawn(geometry: str, points: list[tuple[float, float]]) -> BaseGeometry:
    if geometry == "point" and len(points) == 1:
        return shapely.Point(points[0])
    if geometry == "line" and len(points) > 1:
        return shapely.LineString(points)
    if geometry == "box" and len(points) == 2:
        (x1, y1), (x2, y2) = points
        return shapely.box(min(x1, x2), min(y1, y2), max(x1, x2), max(y1, y2))
    if geometry == "polygon" and len(points) > 3 and points[0] == points[-1]:
        return shapely.Polygon(points)
    raise ValueError(f"wrong number of points for a {geometry}, or not closed")


def _lon_lat(text: str) -> tuple[float, float]:
    lat, lon = (float(part) for part in text.split(","))
    _check_range(np.asarray([[lon, lat]]))
    return lon, lat


def _check_range(lon_lat: np.ndarray) -> None:
    if not np.isfinite(lon_lat).all() or (np.abs(lon_lat) > (180.0, 90.0)).any():
        raise ValueError("longitude or latitude out of range")


def _around(centre: np.ndarray, lon_lat_deg: np.ndarray) -> np.ndarray:
    """Project azimuthally: what lies at a distance from the centre lies there in the plane too, metres."""
    lon, lat = np.radians(lon_lat_deg).T
    step = lon - centre[0]
    east = np.cos(lat) * np.sin(step)
    north = np.cos(centre[1]) * np.sin(lat) - np.sin(centre[1]) * np.cos(lat) * np.cos(step)
    toward = np.sin(centre[1]) * np.sin(lat) + np.cos(centre[1]) * np.cos(lat) * np.cos(step)
    flat = np.hypot(east, north)
    angle = np.arctan2(flat, toward)
    scale = np.where(flat > 0, angle / np.where(flat > 0, flat, 1), 1) * EARTH_M
    return np.column_stack([east * scale, north * scale])

"""Places: GeoJSON is lon,lat; the coordinates of a query are lat,lon. The swap is here and nowhere else."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from pydantic import JsonValue
from shapely import Polygon
from shapely.validation import explain_validity

from backend_clients.ngsi.entity import Attribute, Metadatum
from backend_clients.ngsi.errors import BadInput

Relation = Literal["coveredBy", "intersects", "disjoint", "equals"]


class Position(NamedTuple):
    """A place on Earth, WGS84, in GeoJSON's order."""

    lon_deg: float
    lat_deg: float


def point(at: Position) -> Attribute:
    """Return a point as a geo attribute."""
    return _geo("Point", list(_checked(at)))


def line(along: Sequence[Position]) -> Attribute:
    """Return a line as a geo attribute."""
    if len(along) < 2:
        raise BadInput("a line needs two points or more")
    return _geo("LineString", [list(_checked(at)) for at in along])


def polygon(outline: Sequence[Position], holes: Sequence[Sequence[Position]] = ()) -> Attribute:
    """Return an area as a geo attribute; rings may be open or closed. Raises ``BadInput`` if it crosses itself."""
    rings = [_ring(outline), *(_ring(hole) for hole in holes)]
    drawn = Polygon(rings[0], rings[1:])
    if not drawn.is_valid:
        raise BadInput(f"not a valid area: {explain_validity(drawn)}")
    return _geo("Polygon", [[list(at) for at in ring] for ring in rings])


def second(place: Attribute) -> Attribute:
    """Return a geo attribute that geo queries ignore: an entity may have only one that they see."""
    return place.model_copy(update={"metadata": {**place.metadata, "ignoreType": Metadatum(value=True)}})


@dataclass(frozen=True, slots=True)
class GeoQuery:
    """The geo part of a query, as the broker's parameters."""

    georel: str
    geometry: str
    coords: str

    def parameters(self) -> dict[str, str]:
        """Return the three parameters."""
        return {"georel": self.georel, "geometry": self.geometry, "coords": self.coords}


def near(at: Position, *, max_m: float | None = None, min_m: float | None = None) -> GeoQuery:
    """Ask for what is at least and at most so far from a point; one limit is needed."""
    limits = {"maxDistance": max_m, "minDistance": min_m}
    given = {name: limit for name, limit in limits.items() if limit is not None}
    if not given or not all(math.isfinite(limit) and limit >= 0 for limit in given.values()):
        raise BadInput("near needs max_m or min_m, in metres, not negative")
    modifiers = "".join(f";{name}:{_decimal(limit)}" for name, limit in given.items())
    return GeoQuery(f"near{modifiers}", "point", _lat_lon(at))


def within(outline: Sequence[Position]) -> GeoQuery:
    """Ask for what lies wholly within an area."""
    return related("coveredBy", outline)


def related(relation: Relation, outline: Sequence[Position]) -> GeoQuery:
    """Ask for what stands in a relation to an area."""
    return GeoQuery(relation, "polygon", ";".join(_lat_lon(at) for at in _ring(outline)))


def read_point(attribute: Attribute) -> Position:
    """Return the place of a geo attribute that is a point; raises ``BadInput`` if it is none."""
    value = attribute.value
    if isinstance(value, dict) and value.get("type") == "Point":
        match value.get("coordinates"):
            case [float() | int() as lon, float() | int() as lat, *_]:
                return _checked(Position(float(lon), float(lat)))
    raise BadInput(f"not a point: {str(value)[:80]}")


def _geo(kind: str, coordinates: JsonValue) -> Attribute:
    return Attribute(type="geo:json", value={"type": kind, "coordinates": coordinates})


def _ring(outline: Sequence[Position]) -> list[Position]:
    ring = [_checked(at) for at in outline]
    closed = ring if ring and ring[0] == ring[-1] else [*ring, *ring[:1]]
    if len(closed) < 4:
        raise BadInput("an area needs three corners or more")
    return closed


def _checked(at: Position) -> Position:
    if not (-180 <= at.lon_deg <= 180 and -90 <= at.lat_deg <= 90):  # NaN fails it too
        raise BadInput(f"not a place on Earth: lon {at.lon_deg}, lat {at.lat_deg}")
    return at


def _lat_lon(at: Position) -> str:
    place = _checked(at)
    return f"{_decimal(place.lat_deg)},{_decimal(place.lon_deg)}"


def _decimal(value: float) -> str:
    """Return digits without an exponent."""
    return f"{value:.9f}".rstrip("0").rstrip(".")

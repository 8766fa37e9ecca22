"""Is a place inside a parcel? Good enough for a screen and a notice; no safety rule goes by it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Ring = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Parcel:
    """A parcel of the map; rings of longitude and latitude, the first of each polygon is its edge."""

    id: str
    name: str
    polygons: tuple[tuple[Ring, ...], ...]

    @classmethod
    def of(cls, parcel_id: str, name: str, geometry: Mapping[str, Any]) -> Parcel:
        """Return the parcel of a GeoJSON polygon or multi-polygon; another geometry encloses nothing."""
        shape, found = geometry.get("type"), geometry.get("coordinates", ())
        polygons = [found] if shape == "Polygon" else found if shape == "MultiPolygon" else ()
        return cls(parcel_id, name, tuple(tuple(_ring(ring) for ring in polygon) for polygon in polygons))

    def holds(self, lat_deg: float, lon_deg: float) -> bool:
        """Say whether a place lies inside, holes left out."""
        return any(
            bool(rings)
            and _is_inside(rings[0], lon_deg, lat_deg)
            and not any(_is_inside(hole, lon_deg, lat_deg) for hole in rings[1:])
            for rings in self.polygons
        )


def _ring(points: Sequence[Sequence[float]]) -> Ring:
    return tuple((float(one[0]), float(one[1])) for one in points)


def _is_inside(ring: Ring, x: float, y: float) -> bool:
    """Count the edges to the east of the point."""
    is_in = False
    for (x1, y1), (x2, y2) in zip(ring, ring[1:] + ring[:1], strict=True):
        if (y1 > y) != (y2 > y) and x < (x2 - x1) * (y - y1) / (y2 - y1) + x1:
            is_in = not is_in
    return is_in

"""What came out of a map file."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

Geometry = dict[str, Any]  # GeoJSON (RFC 7946 section 3.1), WGS84 longitude and latitude in degrees


@dataclass(frozen=True, slots=True)
class MapItem:
    """One shape that can be taken over.

    Attributes:
        n: number in this import, from 0.
        name: from the file; made from kind and number where the file has none.
        kind: what it most likely is; one of ``kinds``.
        kinds: what a shape of this geometry can be, likeliest first.
        geometry: GeoJSON, closed rings, outer counter-clockwise and holes clockwise.
        properties: known ones by the names of the farm map, the rest by their own.
        problems: sentences for the operator; the item can be taken nevertheless.
        id: the id that the file gives, where it gives a usable one.
        area_m2: inside the outline without holes; 0 for lines.
        site: number of the field of the file that it belongs to, where the file says it.
    """

    n: int
    name: str
    kind: str
    kinds: tuple[str, ...]
    geometry: Geometry
    properties: dict[str, Any]
    problems: tuple[str, ...] = ()
    id: str | None = None
    area_m2: float = 0.0
    site: int | None = None

    @property
    def vertices(self) -> int:
        """Return the number of positions; a ring counts its first one twice, as GeoJSON does."""
        return _positions(self.geometry["coordinates"])

    @property
    def corners(self) -> int:
        """Return the number of corners as people count them: a closed ring has its first one once."""
        return self.vertices - _rings(self.geometry)


@dataclass(frozen=True, slots=True)
class Skipped:
    """A shape that was left out.

    Attributes:
        which: layer, number and name, as the operator finds it in the file.
        why: a sentence.
        mend: what to do about it.
    """

    which: str
    why: str
    mend: str


@dataclass(frozen=True, slots=True)
class Imported:
    """The content of a map file.

    Attributes:
        format: one of ``geojson, kml, kmz, shapefile, isoxml, gpx, fiware``.
        crs: coordinate system of the file in words, for example ``ETRS89 / UTM zone 32N (EPSG:25832)``.
    """

    format: str
    crs: str
    items: tuple[MapItem, ...]
    skipped: tuple[Skipped, ...] = field(default=())


def _positions(coordinates: Any) -> int:
    if coordinates and isinstance(coordinates[0], (int, float)):
        return 1
    return sum(_positions(part) for part in coordinates)


def _rings(geometry: Geometry) -> int:
    parts = {"Polygon": [geometry["coordinates"]], "MultiPolygon": geometry["coordinates"]}.get(geometry["type"], [])
    return sum(len(rings) for rings in parts)

"""Which parcel lines of rows lie in: a mission follows only lines that name its field."""

from __future__ import annotations

from collections.abc import Iterable

import shapely

from hmi.mapping.coordinates import Geometry, positions
from hmi.mapping.ground import Shape, frame_at, shape_of, sound
from hmi.mapping.kinds import POLYGON


class Parcels:
    """Outlines to look lines up in, by id; the first of equals is found."""

    def __init__(self, outlines: Iterable[tuple[str, Geometry]]) -> None:
        self._outlines = [(key, geometry) for key, geometry in outlines if geometry["type"] == POLYGON]
        self._tree = shapely.STRtree([_box(geometry) for _, geometry in self._outlines])

    def holding(self, lines: Geometry) -> str | None:
        """Return the id of the parcel that holds most metres of a line or lines; ``None`` if none holds any."""
        frame = frame_at(positions(lines))
        shape = shape_of(lines, frame)
        best, most_m = None, 0.0
        for i in sorted(self._tree.query(_box(lines))):
            key, outline = self._outlines[i]
            held_m = sound(shape_of(outline, frame)).intersection(shape).length
            if held_m > most_m:
                best, most_m = key, held_m
        return best


def _box(geometry: Geometry) -> Shape:
    lons, lats = zip(*(place[:2] for place in positions(geometry)), strict=True)
    return shapely.box(min(lons), min(lats), max(lons), max(lats))

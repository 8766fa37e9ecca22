"""Features that lie together, on one plane: a farm may have fields a thousand kilometres apart."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import LineString, MultiLineString, Point, Polygon

from hmi.mapping.coordinates import Position, is_ring, paths, positions, rounded
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import DATUM_DECIMALS
from hmi.mapping.kinds import LINE, LINES, POINT
from hmi.planning.projection import Floats, LocalFrame

CELL_DEG = 0.1  # features in the same or neighbouring cells are one site
Cell = tuple[int, int]
_COLUMNS, _ROWS = 4000, 2000  # more than 360 and 180 degrees have cells


@dataclass(frozen=True, slots=True)
class Path:
    """One ring without its closing corner, or one line: corners ``start`` up to ``stop`` of the site.

    Args:
        feature: index of the feature in the site.
        number: of the ring or line in the feature; 0 is the outline, n hole n.
    """

    feature: int
    number: int
    start: int
    stop: int
    is_closed: bool


@dataclass(frozen=True, slots=True)
class Site:
    """Features on one plane.

    Args:
        frame: ENU plane amid the features.
        features: in the order given.
        corners_m: (N, 2) metres, every corner of every path.
        paths: where each path lies in ``corners_m``.
        shapes: one shapely geometry for each feature, as drawn, metres.
        is_valid: whether the shape is sound.
    """

    frame: LocalFrame
    features: tuple[MapFeature, ...]
    corners_m: Floats
    paths: tuple[Path, ...]
    shapes: NDArray[np.object_]
    is_valid: NDArray[np.bool_]

    def of_kind(self, kind: str) -> NDArray[np.intp]:
        """Return the indices of sound features of a kind."""
        return np.array([n for n, one in enumerate(self.features) if one.kind == kind and self.is_valid[n]], np.intp)

    def place(self, at: Any) -> Position:
        """Return a shapely point or metres as ``[longitude, latitude]``."""
        xy = at.coords[0] if hasattr(at, "coords") else at
        return rounded(*self.frame.to_lon_lat([xy])[0])

    def places(self, points: Any) -> list[Position]:
        """Return many shapely points as ``[longitude, latitude]``, in one go."""
        return [rounded(*p) for p in self.frame.to_lon_lat(shapely.get_coordinates(points))]


def site_of(features: Sequence[MapFeature]) -> Site:
    """Return features that lie together as a site; at least one."""
    degrees: list[Position] = []
    found: list[Path] = []
    for n, one in enumerate(features):
        closed = is_ring(one.geometry)
        for number, path in enumerate(paths(one.geometry)):
            corners = path[:-1] if closed else path
            found.append(Path(n, number, len(degrees), len(degrees) + len(corners), closed))
            degrees += corners
    lon_lat = np.asarray(degrees)
    lon, lat = np.median(lon_lat, axis=0)  # one corner drawn far away does not bend the plane of the others
    frame = LocalFrame(round(float(lat), DATUM_DECIMALS), round(float(lon), DATUM_DECIMALS))
    corners_m = frame.to_local(lon_lat)
    shapes = np.empty(len(features), dtype=object)
    for n, parts in _by_feature(found):
        shapes[n] = _shape(features[n].geometry["type"], [corners_m[one.start : one.stop] for one in parts])
    return Site(frame, tuple(features), corners_m, tuple(found), shapes, shapely.is_valid(shapes))


def grouped(features: Sequence[MapFeature]) -> list[list[int]]:
    """Return the indices of features that lie together, group by group."""
    parent: dict[Cell, Cell] = {}

    def root(cell: Cell) -> Cell:
        while parent[cell] != cell:
            parent[cell] = parent[parent[cell]]
            cell = parent[cell]
        return cell

    owned = _cells(features)
    for cells in owned:
        for cell in cells:
            parent.setdefault(cell, cell)
    for cells in owned:
        first, *others = cells
        for other in others:
            parent[root(other)] = root(first)
    for cell in list(parent):
        for step in ((1, -1), (1, 0), (1, 1), (0, 1)):
            neighbour = (cell[0] + step[0], cell[1] + step[1])
            if neighbour in parent:
                parent[root(neighbour)] = root(cell)
    groups: dict[Cell, list[int]] = defaultdict(list)
    for n, cells in enumerate(owned):
        groups[root(cells[0])].append(n)
    return list(groups.values())


def _cells(features: Sequence[MapFeature]) -> list[list[Cell]]:
    """Return the cells each feature has corners in, all corners looked at in one go."""
    counts = [sum(map(len, paths(one.geometry))) for one in features]
    every = np.array([p for one in features for p in positions(one.geometry)]).reshape(-1, 2)
    x, y = np.floor(every / CELL_DEG).astype(np.int64).T
    owner = np.repeat(np.arange(len(features)), counts)
    keys = np.unique((owner * _COLUMNS + x + _COLUMNS // 2) * _ROWS + y + _ROWS // 2)
    owned: list[list[Cell]] = [[] for _ in features]
    for n, x_n, y_n in zip(keys // _ROWS // _COLUMNS, keys // _ROWS % _COLUMNS, keys % _ROWS, strict=True):
        owned[int(n)].append((int(x_n) - _COLUMNS // 2, int(y_n) - _ROWS // 2))
    return owned


def _by_feature(found: Sequence[Path]) -> Iterator[tuple[int, list[Path]]]:
    of: dict[int, list[Path]] = defaultdict(list)
    for one in found:
        of[one.feature].append(one)
    yield from of.items()


def _shape(kind: str, local: list[Floats]) -> Any:
    if kind == POINT:
        return Point(local[0][0])
    if kind == LINE:
        return LineString(local[0])
    if kind == LINES:
        return MultiLineString(local)
    return Polygon(local[0], local[1:])

"""Rows cut out of lines that need not be straight: what of each lies over the inner field, in cells of neighbours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from hmi.planning.projection import Floats
from hmi.planning.spans import between
from hmi.planning.swaths import BLUNT, SKIP, Place, Swath, cells_of, fitted, merged

Span = tuple[float, float]
Geometries = NDArray[np.object_]


def lay_along(
    lines: Sequence[Sequence[Floats]], along: LineString, inner: BaseGeometry, room: BaseGeometry, width_m: float
) -> list[list[Swath]]:
    """Return rows over ``inner`` in cells: within a cell, rows are neighbours and may be driven one after another.

    Args:
        lines: line by line from one side to the other, each in pieces of (N, 2) metres.
        along: a line beside all of them; places along it say which rows lie beside one another.
        inner: area that the rows must cover.
        room: where row ends may reach to cover slanted edges; contains ``inner``.
        width_m: distance of the rows.
    """
    pieces = [(number, points) for number, line in enumerate(lines) for points in line]
    if not pieces:
        return []
    shapes = np.array([LineString(points) for _, points in pieces], dtype=object)
    needed, rooms = _needed(shapes, inner, width_m), _inside(shapes, room)
    found: list[list[tuple[Span, Swath]]] = [[] for _ in lines]
    for k, (number, points) in enumerate(pieces):
        for need in needed[k]:
            for begin, end in fitted(need, rooms[k]):
                row = _swath(number, between(points, begin, end))
                found[number].append((_beside(row, along), row))
    ordered = [sorted(line, key=lambda one: one[0]) for line in found]
    cells = cells_of([[span for span, _ in line] for line in ordered])
    return [[ordered[k][i][1] for k, i in cell] for cell in cells]


def _swath(number: int, points: Floats) -> Swath:
    a, *via, b = ((float(x), float(y)) for x, y in points)
    return Swath(number, a, b, tuple(via))


def _beside(row: Swath, along: LineString) -> Span:
    ends: list[Place] = [row.a, row.b]
    first, last = sorted(float(s) for s in shapely.line_locate_point(along, shapely.points(ends)))
    return first, last


def _needed(lines: Geometries, inner: BaseGeometry, width_m: float) -> list[list[Span]]:
    """Return for each line the stretches along which its strip meets the area."""

    def strips(skip: float) -> Geometries:
        return np.asarray(shapely.buffer(lines, width_m * (0.5 - skip), quad_segs=4, cap_style="flat"))

    parts, owner = shapely.get_parts(shapely.intersection(strips(SKIP), inner), return_index=True)
    is_area = shapely.area(parts) > 0
    parts, owner = parts[is_area], owner[is_area]
    # the tips of slanted ends are long and treat next to nothing
    blunt = shapely.intersection(parts, strips(BLUNT)[owner])
    spans = _extents(lines[owner], np.where(shapely.area(blunt) > 0, blunt, parts))
    worth = shapely.area(parts) > SKIP * width_m * (spans[:, 1] - spans[:, 0])
    return _by_line(len(lines), owner[worth], spans[worth])


def _inside(lines: Geometries, area: BaseGeometry) -> list[list[Span]]:
    """Return for each line the stretches of it inside the area."""
    parts, owner = shapely.get_parts(shapely.intersection(lines, area), return_index=True)
    is_line = shapely.length(parts) > 1e-6
    return _by_line(len(lines), owner[is_line], _extents(lines[owner[is_line]], parts[is_line]))


def _extents(lines: Geometries, parts: Geometries) -> Floats:
    """Return (N, 2): from where to where along its line each part lies."""
    if not len(parts):
        return np.empty((0, 2))
    places, owner = shapely.get_coordinates(parts, return_index=True)
    along = shapely.line_locate_point(lines[owner], shapely.points(places))
    begins = np.flatnonzero(np.diff(owner, prepend=-1))
    return np.column_stack([np.minimum.reduceat(along, begins), np.maximum.reduceat(along, begins)])


def _by_line(count: int, owner: NDArray[np.int64], spans: Floats) -> list[list[Span]]:
    found: list[list[Span]] = [[] for _ in range(count)]
    for k, (begin, end) in zip(owner, spans, strict=True):
        found[k].append((float(begin), float(end)))
    return [merged(line) for line in found]

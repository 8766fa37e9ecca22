"""Rows over the inner field: at which angle, where each begins and ends, and in which order.

Work happens in a plane turned so that the rows run along x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import affinity
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from hmi.planning.ground import polygons_of
from hmi.planning.projection import Floats

Geometries = NDArray[np.object_]

MIN_ROW_M = 1.0  # shorter rows cost a turn and treat nothing that the headland would not
SKIP = 0.02  # share of a row distance left at each edge of a row: two centimetres must not cost a row
BLUNT = 0.25  # share of a row distance not followed into the tips of slanted ends
_CHOOSE_UP_TO = 600  # rows; with more, where they lie makes no difference
_MOST_CHOICES = 8
_EDGE_M = 0.5  # an edge that wavers less than this is a straight one
_SAMPLE_LINES = 60  # lines tried per angle in the search: enough to rank angles, independent of the width


Place = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Swath:
    """A row from ``a`` over ``via`` to ``b``; a straight one has no ``via``.

    ``line`` numbers the parallel it lies on; a hole splits a parallel into several rows.
    """

    line: int
    a: Place
    b: Place
    via: tuple[Place, ...] = ()

    @property
    def points(self) -> Floats:
        """The row as (N, 2) metres."""
        return np.array([self.a, *self.via, self.b])

    def reversed(self) -> Swath:
        """Return the row driven the other way round."""
        return Swath(self.line, self.b, self.a, self.via[::-1])


def best_angle(inner: BaseGeometry, width_m: float) -> float:
    """Return the row angle in [0, pi) with the fewest rows, and so the fewest turns; along an edge if equal."""
    hull = shapely.get_coordinates(inner.convex_hull)
    steps = np.diff(hull, axis=0)
    edges = np.mod(np.arctan2(steps[:, 1], steps[:, 0]), math.pi)[np.hypot(steps[:, 0], steps[:, 1]) > width_m]
    coarse = np.unique(np.round([*edges, *np.arange(0, math.pi, math.radians(10))], 6))
    best = min(coarse, key=lambda angle: _turns(inner, float(angle), width_m))
    fine = np.mod(best + np.radians(np.arange(-6, 7)), math.pi)
    return float(min([best, *fine], key=lambda angle: _turns(inner, float(angle), width_m)))


def edge_angle(field: BaseGeometry) -> float:
    """Return the direction of the longest straight edge of a field, in [0, pi); holes do not count."""
    rings = [shapely.get_coordinates(part.exterior.simplify(_EDGE_M)) for part in polygons_of(field)]
    steps = np.concatenate([np.diff(ring, axis=0) for ring in rings])
    longest = steps[np.argmax(np.hypot(*steps.T))]
    return float(math.atan2(longest[1], longest[0]) % math.pi)


def lay_rows(inner: BaseGeometry, room: BaseGeometry, angle_rad: float, width_m: float) -> list[list[Swath]]:
    """Return rows over ``inner`` in cells: within a cell, rows are neighbours and may be driven one after another.

    Args:
        inner: area that the rows must cover.
        room: where row ends may reach to cover slanted edges; contains ``inner``.
        angle_rad: direction of the rows.
        width_m: distance of the rows.
    """
    turned = affinity.rotate(inner, -angle_rad, origin=(0, 0), use_radians=True)
    turned_room = affinity.rotate(room, -angle_rad, origin=(0, 0), use_radians=True)
    options = [(levels, _needed(turned, levels, width_m)) for levels in _choices(turned, width_m)]
    levels, needed = min(options, key=lambda option: _cost(option[1], width_m))
    rooms = _spans(turned_room, levels)
    rows = [[row for span in needed[k] for row in fitted(span, rooms[k])] for k in range(len(levels))]
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)

    def back(x: float, y: float) -> tuple[float, float]:
        return x * cos - y * sin, x * sin + y * cos

    def row(k: int, i: int) -> Swath:
        x0, x1 = rows[k][i]
        return Swath(k, back(x0, levels[k]), back(x1, levels[k]))

    return [[row(k, i) for k, i in cell] for cell in cells_of(rows)]


def _levels(turned: BaseGeometry, width_m: float) -> Floats:
    """Return the y of each row, spread so that what does not divide evenly laps into both headlands."""
    _, low, _, high = turned.bounds
    count = max(1, math.ceil((high - low) / width_m - 2 * SKIP))
    first = (low + high) / 2 - (count - 1) * width_m / 2
    return np.asarray(first + width_m * np.arange(count), dtype=np.float64)


def _choices(turned: BaseGeometry, width_m: float) -> list[Floats]:
    """Return ways to place the rows: spread evenly, or with the edge of a row on a corner of the area.

    A step in the outline then costs no row that is mostly outside.
    """
    even = _levels(turned, width_m)
    _, low, _, high = turned.bounds
    slack = len(even) * width_m - (high - low)
    if slack <= 0 or len(even) > _CHOOSE_UP_TO:
        return [even]
    corners = np.unique(np.round(shapely.get_coordinates(turned)[:, 1], 3))
    below = np.unique(np.round(np.mod(low - corners, width_m), 2))  # how far below the area the first row begins
    fitting = below[below <= slack][:_MOST_CHOICES]
    return [even, *(even + (slack / 2 - shift) for shift in fitting)]


def _needed(turned: BaseGeometry, levels: Floats, width_m: float) -> list[list[tuple[float, float]]]:
    """Return for each row the intervals of x in which its strip meets the area, left to right."""
    left, _, right, _ = turned.bounds

    def strips(skip: float) -> Geometries:
        half = width_m * (0.5 - skip)
        return np.asarray(shapely.box(left - 1, levels - half, right + 1, levels + half))

    parts, owner = shapely.get_parts(shapely.intersection(strips(SKIP), turned), return_index=True)
    bounds = shapely.bounds(parts)
    # the tips of slanted ends are long and treat next to nothing
    blunt = shapely.bounds(shapely.intersection(parts, strips(BLUNT)[owner]))
    bounds = np.where(np.isfinite(blunt), blunt, bounds)
    worth = shapely.area(parts) > SKIP * width_m * (bounds[:, 2] - bounds[:, 0])
    intervals: list[list[tuple[float, float]]] = [[] for _ in levels]
    for k, (x0, _, x1, _) in zip(owner[worth], bounds[worth], strict=True):
        intervals[k].append((float(x0), float(x1)))
    return [merged(line) for line in intervals]


def merged(intervals: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return intervals in order, those that overlap as one."""
    found: list[tuple[float, float]] = []
    for x0, x1 in sorted(intervals):
        if found and x0 < found[-1][1]:
            found[-1] = (found[-1][0], max(x1, found[-1][1]))
        else:
            found.append((x0, x1))
    return found


def _cost(needed: list[list[tuple[float, float]]], width_m: float) -> float:
    """Return metres driven for a placement, a turn counted as two row distances and a machine's length."""
    return sum(x1 - x0 + 2 * width_m + 3.0 for line in needed for x0, x1 in line)


def fitted(needed: tuple[float, float], rooms: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the parts of a row for which there is room and which are long enough to be worth a turn."""
    found = [(max(needed[0], r0), min(needed[1], r1)) for r0, r1 in rooms]
    return [(x0, x1) for x0, x1 in found if x1 - x0 >= MIN_ROW_M]


def _spans(turned: BaseGeometry, levels: Floats) -> list[list[tuple[float, float]]]:
    """Return for each y the intervals of x inside the area, left to right."""
    left, _, right, _ = turned.bounds
    ends = np.empty((len(levels), 2, 2))
    ends[:, 0, 0], ends[:, 1, 0] = left - 1, right + 1
    ends[:, :, 1] = levels[:, None]
    parts, owner = shapely.get_parts(shapely.intersection(shapely.linestrings(ends), turned), return_index=True)
    spans: list[list[tuple[float, float]]] = [[] for _ in levels]
    for k, (x0, _, x1, _) in zip(owner, shapely.bounds(parts), strict=True):
        if x1 - x0 > 1e-6:
            spans[k].append((float(x0), float(x1)))
    return [sorted(row) for row in spans]


def cells_of(rows: list[list[tuple[float, float]]]) -> list[list[tuple[int, int]]]:
    """Group rows, given by line and interval, into cells: a cell ends where a row splits, merges or has no neighbour.

    Returns the numbers of line and interval.
    """
    cells: list[list[tuple[int, int]]] = []
    open_cells: dict[int, int] = {}  # position in the previous line -> cell number
    for k, line in enumerate(rows):
        previous = rows[k - 1] if k else []
        below = [[j for j, p in enumerate(previous) if _overlap(p, s)] for s in line]
        above = [sum(_overlap(p, s) for s in line) for p in previous]
        now: dict[int, int] = {}
        for i in range(len(line)):
            if len(below[i]) == 1 and above[below[i][0]] == 1:
                number = open_cells[below[i][0]]
            else:
                cells.append([])
                number = len(cells) - 1
            cells[number].append((k, i))
            now[i] = number
        open_cells = now
    return cells


def _overlap(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return a[0] < b[1] and b[0] < a[1]


def _turns(inner: BaseGeometry, angle_rad: float, width_m: float) -> float:
    """Estimate how many rows, and so turns, an angle makes; the span across decides between equals."""
    turned = affinity.rotate(inner, -angle_rad, origin=(0, 0), use_radians=True)
    _, low, _, high = turned.bounds
    step = max(width_m, (high - low) / _SAMPLE_LINES)
    levels = _levels(turned, step)
    rows = sum(len(line) for line in _spans(turned, levels))
    share = (high - low) / (width_m * len(levels)) if step > width_m else 1.0
    return float(rows * share + (high - low) * 1e-6)


def strips(swaths: list[Swath], width_m: float) -> list[Polygon]:
    """Return the ground each row treats."""
    points = [swath.points for swath in swaths]
    lines = shapely.linestrings(
        np.concatenate(points), indices=np.repeat(np.arange(len(points)), list(map(len, points)))
    )
    return [p for g in shapely.buffer(lines, width_m / 2, quad_segs=12, cap_style="flat") for p in polygons_of(g)]

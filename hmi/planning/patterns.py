"""Orders of rows that a person may choose in place of the shortest: row by row, skipping rows, in lands.

Each cell is worked whole before the next; the cells follow one another from the beginning side of the field.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import shapely
from shapely.geometry.base import BaseGeometry

from hmi.domain.mission_plan import Corner, Pattern
from hmi.planning.machine import RobotProfile
from hmi.planning.swaths import Swath
from hmi.planning.tour import tour

LEAST_SPAN = 2  # rows between two that follow each other when rows are skipped
LAND_SPANS = 5  # a land is so many times as wide as a wide turn: few narrow turns, no long ways
_LEAST_LAND = 8

Numbers = list[int]
Place = tuple[float, float]
_TOWARD: dict[Corner, Place] = {
    Corner.NORTH_WEST: (-1, 1),
    Corner.NORTH_EAST: (1, 1),
    Corner.SOUTH_WEST: (-1, -1),
    Corner.SOUTH_EAST: (1, -1),
}


def driving_order(
    pattern: Pattern,
    cells: list[list[Swath]],
    inner: BaseGeometry,
    *,
    home: Place | None,
    corner: Corner | None,
    span: int,
) -> list[list[Swath]]:
    """Return cells in driving order, each with its rows as they are driven.

    Args:
        cells: groups of neighbouring rows, none empty.
        inner: area of the rows.
        home: where the machine comes from.
        corner: of the field, where to begin; wins over ``home``.
        span: rows that a turn should pass over at least where rows are skipped.
    """
    begin = _corner_place(inner, corner) if corner is not None else home
    if pattern is Pattern.SHORTEST:
        return tour(cells, inner, begin)
    if not cells:
        return []
    return _swept(cells, _ORDERS[pattern], span, begin)


def span_for(machine: RobotProfile, width_m: float) -> int:
    """Return over how many row distances the machine turns in one half circle."""
    return max(LEAST_SPAN, math.ceil(2 * machine.turning_radius_m / width_m - 1e-9))


def row_by_row(count: int, _span: int) -> Numbers:
    """Return the numbers of neighbouring rows one after another."""
    return list(range(count))


def skip_rows(count: int, span: int) -> Numbers:
    """Return an order in which each row is at least ``span`` rows from the one before, if there are enough.

    The rows come in blocks of about twice the span; in a block the lower and the upper half take turns.
    """
    blocks = max(1, count // (2 * span + 1))
    sizes = [count // blocks + (1 if k < count % blocks else 0) for k in range(blocks)]
    order: Numbers = []
    first = 0
    for size in sizes:
        # the first block begins at the edge of the cell; later ones are entered in their far half
        lower = size - size // 2 if not order else size // 2
        halves = (range(first, first + lower), range(first + lower, first + size))
        near, far = halves if not order else halves[::-1]
        order += _alternating(near, far)
        first += size
    return order


def lands(count: int, span: int) -> Numbers:
    """Return an order that works strips of the cell one after another, each from its edges to its middle."""
    number = max(1, round(count / max(_LEAST_LAND, LAND_SPANS * span)))
    order: Numbers = []
    first = 0
    for k in range(number):
        size = count // number + (1 if k < count % number else 0)
        half = size - size // 2
        order += _alternating(range(first, first + half), range(first + size - 1, first + half - 1, -1))
        first += size
    return order


_ORDERS: dict[Pattern, Callable[[int, int], Numbers]] = {
    Pattern.ROW_BY_ROW: row_by_row,
    Pattern.SKIP_ROWS: skip_rows,
    Pattern.SPIRAL: lands,
}


def _alternating(near: Sequence[int], far: Sequence[int]) -> Numbers:
    """Take turns, beginning with ``near``, which has as many or one more."""
    order: Numbers = []
    for k, number in enumerate(near):
        order.append(number)
        if k < len(far):
            order.append(far[k])
    return order


def _swept(
    cells: list[list[Swath]], order: Callable[[int, int], Numbers], span: int, begin: Place | None
) -> list[list[Swath]]:
    """Return the cells from one side of the field to the other, each begun where the machine is nearest."""
    last = max(row.line for cell in cells for row in cell)
    is_upward = begin is None or _begins_low(cells, last, begin)
    waiting, here = list(cells), begin
    swept: list[list[Swath]] = []
    while waiting:
        depths = [_depth(cell, last, is_upward=is_upward) for cell in waiting]
        directions = (True, False) if swept else (is_upward,)
        options = [
            (number, _driven(waiting[number], order, span, is_upward=up, is_forward=forward))
            for number, depth in enumerate(depths)
            for up in directions
            for forward in (True, False)
            if depth == min(depths)
        ]
        number, rows = min(options, key=lambda option: _way_m(here, option[1][0]))
        swept.append(rows)
        del waiting[number]
        here = rows[-1].b
    return swept


def _begins_low(cells: list[list[Swath]], last: int, begin: Place) -> bool:
    """Say whether the lowest rows are nearer to where the machine comes from than the highest."""
    ends = [(row.line, min(math.dist(row.a, begin), math.dist(row.b, begin))) for cell in cells for row in cell]
    first = min(line for line, _ in ends)
    return min(m for line, m in ends if line == first) <= min(m for line, m in ends if line == last)


def _way_m(here: Place | None, row: Swath) -> float:
    return 0.0 if here is None else math.dist(here, row.a)


def _depth(cell: list[Swath], last: int, *, is_upward: bool) -> int:
    lines = [row.line for row in cell]
    return min(lines) if is_upward else last - max(lines)


def _driven(
    cell: list[Swath], order: Callable[[int, int], Numbers], span: int, *, is_upward: bool, is_forward: bool
) -> list[Swath]:
    """Return a cell's rows in driving order, every other one reversed."""
    rows = cell if is_upward else cell[::-1]
    return [
        rows[number] if (k % 2 == 0) == is_forward else rows[number].reversed()
        for k, number in enumerate(order(len(rows), span))
    ]


def _corner_place(inner: BaseGeometry, corner: Corner) -> Place:
    """Return the point of the area that lies furthest toward a corner."""
    east, north = _TOWARD[corner]
    points = shapely.get_coordinates(inner.convex_hull)
    x, y = max(points.tolist(), key=lambda p: p[0] * east + p[1] * north)
    return float(x), float(y)

"""In which order the cells of a field are worked, and each from which of its corners."""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from hmi.planning.ground import polygons_of
from hmi.planning.projection import Floats
from hmi.planning.swaths import Swath

_MOST_STARTS = 400  # beginnings tried
_MENDED_CELLS = 1_500  # cells in all the tries that are mended, some 0.5 ms each
_MOST_ROUNDS = 60  # of mending; it ends by itself much earlier
_ACROSS = 4.0  # a metre from one headland to another crosses standing rows, mostly
_LEAST_GAIN_M = 0.01
_WAYS = 4  # a cell's rows are taken upward or downward, the first of them forward or back

Order = list[int]
"""Numbers of options: cell number times four plus the way it is driven, in driving order."""


def tour(cells: list[list[Swath]], inner: BaseGeometry, place: tuple[float, float] | None) -> list[list[Swath]]:
    """Return the cells in an order with short ways between them, each as its rows are driven.

    Args:
        cells: groups of neighbouring rows, none empty.
        inner: area of the rows; its border and each of its holes has a headland of its own.
        place: where the machine comes from; ``None`` may begin anywhere.
    """
    options = [_driven(cell, way) for cell in cells for way in range(_WAYS)]
    if not options:
        return []
    costs = _costs(options, inner, place)
    rows = [len(cell) for cell in cells]
    # first the cheap tries from everywhere, then the dear mending of the best of them: as many as there is time for
    begin = np.argsort(costs[-2, : len(options)], kind="stable")[:_MOST_STARTS]
    tries = sorted((_greedy(costs, int(first)) for first in begin), key=lambda order: _total(costs, order))
    mended = [_mended(costs, order, rows) for order in tries[: max(1, _MENDED_CELLS // len(cells))]]
    return [options[number] for number in min(mended, key=lambda order: _total(costs, order))]


def by_part(cells: list[list[Swath]], ground: BaseGeometry) -> list[list[list[Swath]]]:
    """Return the cells by the part of the ground they lie on, the part with most metres of rows first.

    Where a field is too narrow to pass, its parts cannot be reached from one another.
    """
    parts = np.array(polygons_of(ground))
    if len(parts) < 2:
        return [cells]
    groups: dict[int, list[list[Swath]]] = {}
    for cell in cells:
        groups.setdefault(int(_nearest(np.array([cell[0].a]), parts)[0]), []).append(cell)
    return sorted(groups.values(), key=_metres, reverse=True)


def _metres(cells: list[list[Swath]]) -> float:
    return sum(math.dist(row.a, row.b) for cell in cells for row in cell)


def _driven(cell: list[Swath], way: int) -> list[Swath]:
    """Return a cell's rows in driving order, every other one reversed."""
    ordered = cell if way < 2 else cell[::-1]
    is_forward = way % 2 == 0
    return [swath if (k % 2 == 0) == is_forward else swath.reversed() for k, swath in enumerate(ordered)]


def _reversed(number: int, rows: int) -> int:
    """Return the option that drives the same rows in the opposite direction and order."""
    way = number % _WAYS
    forward = way % 2 if rows % 2 else 1 - way % 2
    # the last row's direction follows from the first one's; driven back it is the opposite
    return number - way + (2 if way < 2 else 0) + (1 - forward)


def _costs(options: list[list[Swath]], inner: BaseGeometry, place: tuple[float, float] | None) -> Floats:
    """Return the cost from the end of one option to the beginning of another, metres along the headland.

    The last two stand for start and end of the tour: it ends at the border, where the laps around the field follow.
    """
    n = len(options)
    entries = np.array([rows[0].a for rows in options])
    exits = np.array([rows[-1].b for rows in options])
    parts = polygons_of(inner)
    border = shapely.union_all([part.exterior for part in parts])
    rings = np.array([border, *(hole for part in parts for hole in part.interiors)])
    enters, leaves = _nearest(entries, rings), _nearest(exits, rings)
    costs = np.zeros((n + 2, n + 2))
    steps = np.hypot(exits[:, None, 0] - entries[None, :, 0], exits[:, None, 1] - entries[None, :, 1])
    costs[:n, :n] = steps * np.where(leaves[:, None] == enters[None, :], 1.0, _ACROSS)
    costs[:n, n + 1] = np.where(leaves == 0, 0.0, _ACROSS * shapely.distance(shapely.points(exits), border))
    if place is not None:
        costs[n, :n] = np.hypot(*(entries - np.array(place)).T)
    return costs


def _nearest(places: Floats, rings: NDArray[np.object_]) -> NDArray[np.int64]:
    """Return for each place the number of the ring that is nearest."""
    distances = [shapely.distance(shapely.points(places), ring) for ring in rings]
    return np.asarray(np.argmin(distances, axis=0), dtype=np.int64)


def _greedy(costs: Floats, first: int) -> Order:
    n = len(costs) - 2
    is_left = np.ones(n, dtype=bool)
    order = [first]
    while True:
        begin = order[-1] - order[-1] % _WAYS
        is_left[begin : begin + _WAYS] = False
        if not is_left.any():
            return order
        order.append(int(np.argmin(np.where(is_left, costs[order[-1], :n], np.inf))))


def _total(costs: Floats, order: Order) -> float:
    path = np.array([len(costs) - 2, *order, len(costs) - 1])
    return float(costs[path[:-1], path[1:]].sum())


def _mended(costs: Floats, order: Order, rows: list[int]) -> Order:
    """Move single cells and turn parts of the order around as long as that saves way."""
    for _ in range(_MOST_ROUNDS):
        before = _total(costs, order)
        order = _turned(costs, _moved(costs, order), rows)
        if _total(costs, order) > before - _LEAST_GAIN_M:
            break
    return order


def _turned(costs: Floats, order: Order, rows: list[int]) -> Order:
    """Return the order with the part driven the other way round that saves most."""
    start, end = len(costs) - 2, len(costs) - 1
    here = np.array(order)
    back = np.array([_reversed(number, rows[number // _WAYS]) for number in order])
    before, after = np.append(start, here[:-1]), np.append(here[1:], end)
    now = costs[before, here][:, None] + costs[here, after][None, :]
    then = costs[before[:, None], back[None, :]] + costs[back[:, None], after[None, :]]
    gains = np.triu(now - then)
    i, j = np.unravel_index(int(np.argmax(gains)), gains.shape)
    if gains[i, j] < _LEAST_GAIN_M:
        return order
    return [*order[:i], *(int(k) for k in back[i : j + 1][::-1]), *order[j + 1 :]]


def _moved(costs: Floats, order: Order) -> Order:
    """Return the order with every cell moved to where it saves most."""
    start, end = len(costs) - 2, len(costs) - 1
    for number in list(order):
        rest = [other for other in order if other // _WAYS != number // _WAYS]
        path = np.array([start, *rest, end])
        links = costs[path[:-1], path[1:]]
        ways = number - number % _WAYS + np.arange(_WAYS)
        added = costs[path[:-1, None], ways] + costs[ways, path[1:, None]] - links[:, None]
        place, way = np.unravel_index(int(np.argmin(added)), added.shape)
        if float(links.sum() + added[place, way]) < _total(costs, order) - _LEAST_GAIN_M:
            order = [*rest[:place], int(ways[way]), *rest[place:]]
    return order

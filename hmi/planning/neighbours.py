"""How far beside one another lines lie that were recorded in any order: each is measured from a neighbour."""

from __future__ import annotations

import math
from collections.abc import Sequence
from heapq import heappop, heappush

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry import GeometryCollection, LineString
from shapely.geometry.base import BaseGeometry

from hmi.planning.projection import Floats

_OUTSIDE_M = 1e4  # a neighbour that ends before it is beside is taken last
_STEP_M = 0.5


def beside(along: LineString, lines: Sequence[Floats], near_m: float) -> list[float]:
    """Return how far left of ``along`` each line lies in its middle, metres.

    A line is measured from its nearest neighbour, and that from its own: straight from ``along``, lines that curve
    would be measured wrongly at its ends.

    Args:
        along: the longest line, drawn on at its ends.
        lines: (N, 2) metres each, about parallel.
        near_m: further away there are no neighbours.
    """
    shapes = [LineString(points if _is_along(along, points) else points[::-1]) for points in lines]
    coarse = _level(shapes, near_m)
    tree = shapely.STRtree(coarse)
    found: dict[int, float] = {}
    waiting: list[tuple[float, int, float]] = []
    longest = max(range(len(shapes)), key=lambda k: shapes[k].length)
    rest = sorted(range(len(shapes)), key=lambda k: along.distance(shapes[k].interpolate(0.5, normalized=True)))
    for start in (longest, *rest):  # more than one if some lie far from all others
        if start in found:
            continue
        _, place = _from(along, shapes[start])
        heappush(waiting, (0.0, start, place))
        while waiting:
            _, number, place = heappop(waiting)
            if number in found:
                continue
            found[number] = place
            for other in tree.query(coarse[number], predicate="dwithin", distance=near_m).tolist():
                if other not in found:
                    cost, step = _between(shapes[number], shapes[other])
                    heappush(waiting, (cost, other, place + step))
    return [found[k] for k in range(len(shapes))]


def _level(shapes: list[LineString], near_m: float) -> list[BaseGeometry]:
    """Return lines without small bends and about parallel to the x axis: the box of a slanting one meets all others."""
    longest = max(shapes, key=lambda shape: float(shape.length))
    (x0, y0), (x1, y1) = shapely.get_coordinates(longest)[[0, -1]]
    turned = affinity.rotate(GeometryCollection(shapes), -math.atan2(y1 - y0, x1 - x0), origin=(0, 0), use_radians=True)
    return list(shapely.simplify(shapely.get_parts(turned), near_m / 10))


def _between(placed: LineString, other: LineString) -> tuple[float, float]:
    """Return how dear it is to measure a line from another, and how far left of that it lies."""
    cost, step = _from(placed, other)
    back_cost, back_step = _from(other, placed)
    return (cost, step) if cost <= back_cost else (back_cost, -back_step)


def _from(line: LineString, other: LineString) -> tuple[float, float]:
    middle = other.interpolate(0.5, normalized=True)
    s = line.project(middle)
    a, b = (
        shapely.get_coordinates(line.interpolate(min(max(0.0, s + d), line.length)))[0] for d in (-_STEP_M, _STEP_M)
    )
    ahead = (b - a) / math.hypot(*(b - a))
    off = shapely.get_coordinates(middle)[0] - a
    left = float(ahead[0] * off[1] - ahead[1] * off[0])
    is_inside = 0 < s < line.length
    return abs(left) + (0.0 if is_inside else _OUTSIDE_M), left


def _is_along(along: LineString, points: Floats) -> bool:
    first, last = shapely.line_locate_point(along, shapely.points(points[[0, -1]]))
    return bool(np.less_equal(first, last))

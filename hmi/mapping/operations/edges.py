"""Corners along rings and lines: which can go, which edges cross."""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely import STRtree
from shapely.geometry import Polygon

from hmi.planning.projection import Floats

DUPLICATE_M = 0.01  # two corners nearer than RTK can tell apart are one
SPIKE_RAD = math.radians(1)  # an edge that comes back this straight encloses nothing a machine could drive


def needless(path_m: Floats, *, is_closed: bool) -> list[int]:
    """Return the numbers of duplicate and spike corners of a path.

    Args:
        path_m: (N, 2) metres; a ring without its closing corner.
        is_closed: whether the last corner is joined to the first.
    """
    kept = list(range(len(path_m)))
    while True:
        left = _pass(path_m, kept, is_closed)
        if len(left) == len(kept):
            return sorted(set(range(len(path_m))) - set(kept))
        kept = left


def crossing_edges(ring_m: Floats, most: int = 8) -> list[tuple[int, int]]:
    """Return pairs of edges of a ring that meet other than at a shared corner; edge n begins at corner n.

    Args:
        ring_m: (N, 2) metres, without the closing corner.
        most: stop after this many.
    """
    count = len(ring_m)
    edges = shapely.linestrings(np.stack([ring_m, np.roll(ring_m, -1, axis=0)], axis=1))
    first, second = STRtree(edges).query(edges, predicate="intersects")
    apart = (second > first + 1) & ~((first == 0) & (second == count - 1))
    pairs = sorted(zip(first[apart].tolist(), second[apart].tolist(), strict=True))
    return pairs[:most]


def is_simple(ring_m: Floats) -> bool:
    """Say whether a ring without its closing corner is a sound outline."""
    return len(ring_m) >= 3 and bool(Polygon(ring_m).is_valid)


def _pass(path_m: Floats, kept: list[int], is_closed: bool) -> list[int]:
    left: list[int] = []
    for n in kept:
        left.append(n)
        _shorten(path_m, left)
    while is_closed and len(left) > 2 and _joins_badly(path_m, left):
        left.pop()
    if is_closed and len(left) > 2 and _is_spike(path_m, left[-1], left[0], left[1]):
        left.pop(0)
    return left


def _shorten(path_m: Floats, left: list[int]) -> None:
    while len(left) > 1:
        if _is_near(path_m, left[-2], left[-1]):
            left.pop()
        elif len(left) > 2 and _is_spike(path_m, left[-3], left[-2], left[-1]):
            left.pop(-2)
        else:
            return


def _joins_badly(path_m: Floats, left: list[int]) -> bool:
    return _is_near(path_m, left[-1], left[0]) or _is_spike(path_m, left[-2], left[-1], left[0])


def _is_near(path_m: Floats, a: int, b: int) -> bool:
    return math.dist(path_m[a], path_m[b]) < DUPLICATE_M


def _is_spike(path_m: Floats, a: int, tip: int, b: int) -> bool:
    back, on = path_m[a] - path_m[tip], path_m[b] - path_m[tip]
    turn = math.atan2(abs(float(back[0] * on[1] - back[1] * on[0])), float(back @ on))
    return turn < SPIKE_RAD

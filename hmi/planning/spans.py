"""Stretches of a line by the ground they lie on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from hmi.planning.projection import Floats

SLIVER_M = 0.1  # pieces shorter than this are the rounding of two borders, not a wish

Span = tuple[float, float, float]
"""From and to in metres along a line, and the number that counts there."""
Zone = tuple[BaseGeometry, float]
"""Ground and the number that counts on it."""


def without_later(areas: Iterable[Zone]) -> list[Zone]:
    """Return areas without what later ones cover, the last one first."""
    zones: list[Zone] = []
    taken: BaseGeometry = shapely.Polygon()
    for area, number in reversed([*areas]):
        zones.append((area.difference(taken), number))
        taken = taken.union(area)
    return zones


def spans_along(points: Floats, zones: Sequence[Zone], rest: float) -> list[Span]:
    """Return the numbers along a line in order, without gaps; ``rest`` counts off the zones."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    starts = np.append(0.0, np.cumsum(steps))
    lines = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
    found: list[Span] = []
    for zone, number in zones:
        parts, owner = shapely.get_parts(shapely.intersection(lines, zone), return_index=True)
        for part, k in zip(parts, owner, strict=True):
            if part.geom_type != "LineString" or part.is_empty:
                continue
            ends = np.hypot(*(shapely.get_coordinates(part)[[0, -1]] - points[k]).T)
            found.append((float(starts[k] + ends.min()), float(starts[k] + ends.max()), number))
    return _filled(sorted(found), float(starts[-1]), rest)


def joined(spans: Iterable[Span]) -> list[Span]:
    """Join neighbours of one number."""
    found: list[Span] = []
    for begin, end, number in spans:
        if found and found[-1][2] == number:
            found[-1] = (found[-1][0], end, number)
        else:
            found.append((begin, end, number))
    return found


def merged(spans: list[Span]) -> list[Span]:
    """Give slivers to their neighbours."""
    kept = [span for span in spans if span[1] - span[0] > SLIVER_M] or spans[:1]
    edges = [spans[0][0], *((a[1] + b[0]) / 2 for a, b in pairwise(kept)), spans[-1][1]]
    return joined((edges[k], edges[k + 1], span[2]) for k, span in enumerate(kept))


def between(points: Floats, begin_m: float, end_m: float) -> Floats:
    """Return the part of a polyline between two distances along it."""
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    if begin_m <= 1e-9 and end_m >= along[-1] - 1e-9:
        return points
    inside = (along > begin_m + 1e-6) & (along < end_m - 1e-6)
    ends = np.array([[np.interp(s, along, points[:, 0]), np.interp(s, along, points[:, 1])] for s in (begin_m, end_m)])
    return np.vstack([ends[:1], points[inside], ends[1:]])


def _filled(found: list[Span], length_m: float, rest: float) -> list[Span]:
    spans: list[Span] = []
    here = 0.0
    for begin, end, number in found:
        if begin > here + 1e-9:
            spans.append((here, begin, rest))
        spans.append((max(begin, here), max(end, here), number))
        here = max(here, end)
    if length_m > here:
        spans.append((here, length_m, rest))
    return joined(spans)

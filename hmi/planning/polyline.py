"""Lines as they are told to a robot, in millimetres: without corners so near to each other that this makes degrees."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from hmi.planning.projection import Floats

_SAME_M = 1e-4
_CRUMB_M = 0.02  # paths are told in millimetres: over shorter pieces that makes degrees
_CRUMB_OFF_M = 0.002
_CRUMB_RAD = math.radians(10)


def distinct(points: Floats) -> Floats:
    """Drop points on top of the one before, and those so near to one that a millimetre would turn the heading there.

    The first and the last one are kept exactly; the line moves by 2 mm at most and bends nowhere by more than
    10 degrees because of what was dropped.
    """
    steps = np.hypot(*np.diff(points, axis=0).T)
    kept: Floats = points[np.append(True, steps > _SAME_M)]
    if len(kept) > 1:
        kept[-1] = points[-1]
    if len(kept) > 2 and np.hypot(*np.diff(kept, axis=0).T).min() < _CRUMB_M:
        return _without_crumbs(kept)
    return kept


def in_millimetres(points: Floats) -> Floats:
    """Return a polyline as a document tells it, of two points at the least.

    A border of a dose or zone may cut a line a millimetre from a corner: such corners go, rounded they point anywhere.
    """
    line = distinct(points)
    rounded: Floats = np.round(line if len(line) > 1 else points[[0, -1]], 3) + 0.0  # the sum turns -0.0 into 0.0
    return rounded


def length_m(points: Floats) -> float:
    """Return the length of a polyline in metres."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def part_of(points: Floats, from_m: float, to_m: float) -> Floats:
    """Return a polyline between two distances along it, (N, 2); one point if there is nothing between."""
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    inner = points[(along > from_m + 1e-6) & (along < to_m - 1e-6)]
    ends = [np.array([np.interp(at, along, points[:, k]) for k in (0, 1)]) for at in (from_m, to_m)]
    return distinct(np.vstack([ends[0], inner, ends[1]])) if to_m > from_m + 1e-6 else ends[0].reshape(1, 2)


def pose_at(points: Floats, at_m: float) -> tuple[float, float, float]:
    """Return x, y and heading (radians) ``at_m`` metres along a polyline, the heading that of the piece before."""
    x, y = part_of(points, 0.0, at_m)[-1]
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    k = min(max(int(np.searchsorted(along, at_m, side="left")) - 1, 0), len(points) - 2)
    ahead = points[k + 1] - points[k]
    return float(x), float(y), math.atan2(ahead[1], ahead[0])


def _without_crumbs(points: Floats) -> Floats:
    kept = [(float(x), float(y)) for x, y in points]
    k = 0
    while k + 1 < len(kept):
        is_crumb = math.dist(kept[k], kept[k + 1]) < _CRUMB_M
        spare = next((at for at in (k, k + 1) if is_crumb and _is_spare(kept, at)), None)
        if spare is None:
            k += 1
        else:
            del kept[spare]
            k = max(0, k - 1)
    return np.array(kept)


def _is_spare(line: list[tuple[float, float]], at: int) -> bool:
    """Say whether a corner of a line is not missed: its ends always are."""
    if not 0 < at < len(line) - 1:
        return False
    (ax, ay), (x, y), (bx, by) = line[at - 1 : at + 2]
    chord = max(math.hypot(bx - ax, by - ay), _SAME_M)
    along = min(1.0, max(0.0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / chord**2))
    if math.hypot(x - ax - along * (bx - ax), y - ay - along * (by - ay)) > _CRUMB_OFF_M:
        return False
    rest = [*line[max(0, at - 2) : at], *line[at + 1 : at + 3]]
    directions = [math.atan2(v[1] - u[1], v[0] - u[0]) for u, v in pairwise(rest)]
    return all(abs(math.remainder(b - a, 2 * math.pi)) <= _CRUMB_RAD for a, b in pairwise(directions))

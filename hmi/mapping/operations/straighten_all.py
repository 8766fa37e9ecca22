"""Draw straight every edge that is nearly straight already."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from hmi.mapping.coordinates import Position, is_ring, paths, with_paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.ground import frame_of, shape_of
from hmi.mapping.kinds import POINT
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.selection import Selection, title
from hmi.planning.projection import Floats, LocalFrame

LEAST_DEG, USUAL_DEG, MOST_DEG = 0.1, 4.0, 20.0
MOST_M = 2.0  # from the new edge: a long soft bend is a bend, however softly it turns


def straighten_all(selection: Selection, arguments: Arguments) -> Outcome:
    """Leave out corners between which no edge turns more than ``within_deg`` from one straight line.

    Corners that turn more stay exactly where they are; nothing moves by more than 2 m.

    Raises:
        OperationRefused: a point, every corner turns more, or the outline would cross itself.
    """
    within_rad = math.radians(arguments.number("within_deg", LEAST_DEG, MOST_DEG, USUAL_DEG))
    feature = selection.one()
    if feature.geometry["type"] == POINT:
        raise OperationRefused("no_edge", f"{title(feature)} is a point and has no edges. Choose an area or a line.")
    closed, frame = is_ring(feature.geometry), frame_of([feature])
    old = paths(feature.geometry)
    new = [_straightened(path, frame, within_rad, is_closed=closed) for path in old]
    gone = sum(map(len, old)) - sum(map(len, new))
    if not gone:
        raise OperationRefused("nothing_to_do", f"{title(feature)} has no edge that is nearly straight. Allow more.")
    geometry = with_paths(feature.geometry, new)
    if shape_of(feature.geometry, frame).is_valid and not shape_of(geometry, frame).is_valid:
        raise OperationRefused("would_cross", "Straight edges would cross each other. Allow less.")
    label = f"Edges of {title(feature)} straightened, {gone} corner{'s' if gone > 1 else ''} fewer"
    return Outcome(label, (changed(feature, replace(feature, geometry=geometry)),))


def _straightened(path: list[Position], frame: LocalFrame, within_rad: float, *, is_closed: bool) -> list[Position]:
    corners = path[:-1] if is_closed else path
    xy = frame.to_local(corners)
    if not is_closed:
        return [list(corners[n]) for n in _kept(xy, within_rad)]
    start = _sharpest(xy)
    order = [*range(start, len(xy)), *range(start), start]
    kept = sorted({order[n] for n in _kept(xy[order], within_rad)})
    if len(kept) < 3:
        return path
    left = [list(corners[n]) for n in kept]
    return [*left, list(left[0])]


def _sharpest(xy: Floats) -> int:
    """Return the corner of a ring that turns most: it stays for sure."""
    back, on = np.roll(xy, 1, axis=0) - xy, np.roll(xy, -1, axis=0) - xy
    turn = np.arctan2(np.abs(back[:, 0] * on[:, 1] - back[:, 1] * on[:, 0]), (back * on).sum(axis=1))
    return int(np.argmin(turn))


def _kept(xy: Floats, within_rad: float) -> list[int]:
    """Return the numbers of the points that stay, first and last among them."""
    kept = {0, len(xy) - 1}
    stack = [(0, len(xy) - 1)]
    while stack:
        start, end = stack.pop()
        if end - start < 2:
            continue
        off = _off(xy[start : end + 1])
        if off.max() <= MOST_M and _is_straight(xy[start : end + 1], within_rad):
            continue
        middle = start + 1 + int(np.argmax(off[1:-1]))
        kept.add(middle)
        stack += [(start, middle), (middle, end)]
    return sorted(kept)


def _off(xy: Floats) -> Floats:
    """Return how far each point is from the line through the ends, metres."""
    chord = xy[-1] - xy[0]
    length = float(np.hypot(*chord))
    away: Floats = xy - xy[0]
    if length < 1e-9:
        return np.hypot(away[:, 0], away[:, 1])
    off: Floats = np.abs(away[:, 0] * chord[1] - away[:, 1] * chord[0]) / length
    return off


def _is_straight(xy: Floats, within_rad: float) -> bool:
    chord, steps = xy[-1] - xy[0], np.diff(xy, axis=0)
    turn = np.arctan2(np.abs(steps[:, 0] * chord[1] - steps[:, 1] * chord[0]), steps @ chord)
    return bool(turn.max() <= within_rad)

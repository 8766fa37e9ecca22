"""Draw the edge between two corners straight."""

from __future__ import annotations

from dataclasses import replace

from hmi.mapping.coordinates import is_ring, paths, with_paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.ground import frame_of, shape_of
from hmi.mapping.kinds import POINT
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.selection import Selection, title


def straighten(selection: Selection, arguments: Arguments) -> Outcome:
    """Take away the corners from corner ``from`` on to corner ``to``, numbered from 0.

    On a ring the way goes forward from ``from``, past the end if it must; on a line either way is the same.

    Raises:
        OperationRefused: no corner lies between, or the outline would cross itself.
    """
    feature = selection.one()
    if feature.geometry["type"] == POINT:
        raise OperationRefused("no_edge", f"{title(feature)} is a point and has no edges. Choose an area or a line.")
    every = paths(feature.geometry)
    number = arguments.index("ring", len(every), default=0)
    closed = is_ring(feature.geometry)
    path = every[number][:-1] if closed else every[number]
    start, end = arguments.index("from", len(path)), arguments.index("to", len(path))
    if not closed:
        start, end = min(start, end), max(start, end)
    between = {(start + n) % len(path) for n in range(1, (end - start) % len(path))}
    if not between:
        raise OperationRefused("nothing_to_do", "No corner lies between these two. Choose two that are further apart.")
    left = [list(p) for n, p in enumerate(path) if n not in between]
    if closed and len(left) < 3:
        raise OperationRefused("vanishes", "Fewer than three corners would be left. Choose corners nearer together.")
    new = with_paths(feature.geometry, [*every[:number], [*left, left[0]] if closed else left, *every[number + 1 :]])
    frame = frame_of([feature])
    if shape_of(feature.geometry, frame).is_valid and not shape_of(new, frame).is_valid:
        raise OperationRefused(
            "would_cross", "The straight edge would cross another one. Choose corners nearer together."
        )
    return Outcome(f"Edge of {title(feature)} straightened", (changed(feature, replace(feature, geometry=new)),))

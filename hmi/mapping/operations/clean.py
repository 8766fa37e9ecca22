"""Take away corners that are double or stick out as a spike."""

from __future__ import annotations

from dataclasses import replace

from hmi.mapping.coordinates import Position, is_ring, paths, with_paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.ground import frame_of
from hmi.mapping.kinds import POINT
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.edges import needless
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.selection import Selection, title
from hmi.planning.projection import LocalFrame


def clean(selection: Selection, arguments: Arguments) -> Outcome:
    """Take away duplicate and spike corners of one feature; a hole that is nothing else goes with them.

    Raises:
        OperationRefused: there are none, or nothing else would be left.
    """
    del arguments
    feature = selection.one()
    closed = is_ring(feature.geometry)
    frame = frame_of([feature])
    old = [] if feature.geometry["type"] == POINT else paths(feature.geometry)
    cleaned = [_cleaned(path, frame, is_closed=closed) for path in old]
    gone = sum(map(len, old)) - sum(map(len, cleaned))
    if not gone:
        raise OperationRefused("nothing_to_do", f"{title(feature)} has no double corners and no spikes.")
    kept = [path for path in cleaned if path]
    if not kept or not cleaned[0]:
        raise OperationRefused("vanishes", f"Nothing would be left of {title(feature)}. Draw it again, or delete it.")
    after = replace(feature, geometry=with_paths(feature.geometry, kept))
    return Outcome(
        f"{gone} needless corner{'s' if gone > 1 else ''} removed from {title(feature)}", (changed(feature, after),)
    )


def _cleaned(path: list[Position], frame: LocalFrame, *, is_closed: bool) -> list[Position]:
    corners = path[:-1] if is_closed else path
    gone = set(needless(frame.to_local(corners), is_closed=is_closed))
    left = [p for n, p in enumerate(corners) if n not in gone]
    if len({tuple(p) for p in left}) < (3 if is_closed else 2):
        return []
    if not gone:
        return path
    return [*left, list(left[0])] if is_closed else left

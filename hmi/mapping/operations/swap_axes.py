"""Exchange latitude and longitude."""

from __future__ import annotations

from dataclasses import replace

from hmi.mapping.coordinates import is_ring, paths, with_paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.selection import Selection, title, titles


def swap_axes(selection: Selection, arguments: Arguments) -> Outcome:
    """Exchange the two numbers of every corner; rings are turned so that they wind as before.

    Raises:
        OperationRefused: a longitude beyond 90 degrees can be no latitude.
    """
    del arguments
    changes = []
    for feature in selection.chosen:
        old = paths(feature.geometry)
        if any(abs(lon) > 90 for path in old for lon, _ in path):
            raise OperationRefused(
                "not_swapped", f"{title(feature)} has longitudes beyond 90 degrees: these are right."
            )
        # the mirror image of a ring winds the other way
        closed = is_ring(feature.geometry)
        new = [[[lat, lon] for lon, lat in (reversed(path) if closed else path)] for path in old]
        changes.append(changed(feature, replace(feature, geometry=with_paths(feature.geometry, new))))
    return Outcome(f"Latitude and longitude of {titles(selection.chosen)} exchanged", tuple(changes))

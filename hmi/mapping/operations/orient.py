"""Wind rings as GeoJSON asks: the outline counter-clockwise, holes clockwise."""

from __future__ import annotations

from dataclasses import replace

import shapely

from hmi.mapping.coordinates import Position, is_ring, paths, with_paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.selection import Selection, title


def orient(selection: Selection, arguments: Arguments) -> Outcome:
    """Turn around each ring of one polygon that runs the wrong way; its first corner stays the first.

    Raises:
        OperationRefused: no polygon, or every ring runs the right way.
    """
    del arguments
    feature = selection.one()
    if not is_ring(feature.geometry):
        raise OperationRefused("not_a_polygon", f"{title(feature)} is no area. Choose a feature with an outline.")
    old = paths(feature.geometry)
    new = [ring[::-1] if _is_wrong(ring, is_outline=not number) else ring for number, ring in enumerate(old)]
    if new == old:
        raise OperationRefused("nothing_to_do", f"{title(feature)} runs the right way round already.")
    after = replace(feature, geometry=with_paths(feature.geometry, new))
    return Outcome(f"Direction of {title(feature)} corrected", (changed(feature, after),))


def _is_wrong(ring: list[Position], *, is_outline: bool) -> bool:
    """Say whether the ring runs right only the other way round; one without an area never does."""
    here, back = (bool(shapely.is_ccw(shapely.linearrings(way))) for way in (ring, ring[::-1]))
    return here != is_outline and back == is_outline

"""Undo edges of an outline that cross each other."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import Polygon

from hmi.mapping.coordinates import is_ring, paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import GRID_M, Shape, areas_in, frame_of, polygons_in, shape_of, sound
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.edges import crossing_edges, is_simple
from hmi.mapping.operations.outcome import Outcome
from hmi.mapping.operations.pieces import changes_for_pieces, polygon_pieces, rows_that_follow
from hmi.mapping.operations.selection import Selection, title
from hmi.planning.projection import Floats, LocalFrame

MOST_STEPS = 100
MOST_CORNERS = 2000  # each step looks at every edge; longer outlines are cut instead


def untangle(selection: Selection, arguments: Arguments) -> Outcome:
    """Make one polygon sound.

    Corners stay where they are and are joined in another order where that is enough. Otherwise the outline is cut
    where it crosses, and each part larger than a crumb becomes a feature of its own. Holes that overlap become one.

    Raises:
        OperationRefused: no polygon, nothing crosses, or nothing would be left.
    """
    del arguments
    feature = selection.one()
    if not is_ring(feature.geometry):
        raise OperationRefused("not_a_polygon", f"{title(feature)} is no area. Choose a feature with an outline.")
    frame = frame_of([feature])
    if shape_of(feature.geometry, frame).is_valid and not _holes_meet(feature, frame):
        raise OperationRefused("nothing_to_do", f"No edges of {title(feature)} cross.")
    pieces = polygon_pieces(polygons_in(_sound(feature, frame)), frame)
    changes = changes_for_pieces(feature, pieces, selection.draft, feature.properties)
    return Outcome(f"Outline of {title(feature)} untangled", (*changes, *rows_that_follow(changes, selection.draft)))


def _sound(feature: MapFeature, frame: LocalFrame) -> Shape:
    outline, *holes = (_reordered(frame.to_local(ring[:-1])) for ring in paths(feature.geometry))
    inner = areas_in(shapely.union_all([sound(Polygon(ring)) for ring in holes], grid_size=GRID_M))
    return shapely.difference(sound(Polygon(outline)), inner, grid_size=GRID_M)


def _reordered(ring: Floats) -> Floats:
    """Join the corners in another order, crossing by crossing; the way around gets shorter with each step."""
    new = ring
    for _ in range(MOST_STEPS if len(ring) <= MOST_CORNERS else 0):
        if is_simple(new):
            return new
        pairs = crossing_edges(new, most=1)
        if not pairs:
            break
        first, second = pairs[0]
        new = np.vstack([new[: first + 1], new[first + 1 : second + 1][::-1], new[second + 1 :]])
    return new if is_simple(new) else ring


def _holes_meet(feature: MapFeature, frame: LocalFrame) -> bool:
    holes = [Polygon(frame.to_local(ring)) for ring in paths(feature.geometry)[1:]]
    return any(a.distance(b) == 0 for n, a in enumerate(holes) for b in holes[:n])

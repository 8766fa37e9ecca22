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
from hmi.mapping.operations.hole import APART_M
from hmi.mapping.operations.outcome import Outcome
from hmi.mapping.operations.pieces import changes_for_pieces, polygon_pieces, rows_that_follow
from hmi.mapping.operations.selection import Selection, title
from hmi.planning.projection import Floats, LocalFrame

MOST_STEPS = 100
OPEN_M = 0.05  # a hole that touches the edge becomes a bay this much wider
MOST_CORNERS = 2000  # each step looks at every edge; longer outlines are cut instead


def untangle(selection: Selection, arguments: Arguments) -> Outcome:
    """Make one polygon sound.

    Corners stay where they are and are joined in another order where that is enough. Otherwise the outline is cut
    where it crosses, and each part larger than a crumb becomes a feature of its own. Holes that overlap become one,
    those that touch the edge a bay.

    Raises:
        OperationRefused: no polygon, nothing crosses, or nothing would be left.
    """
    del arguments
    feature = selection.one()
    if not is_ring(feature.geometry):
        raise OperationRefused("not_a_polygon", f"{title(feature)} is no area. Choose a feature with an outline.")
    frame = frame_of([feature])
    if shape_of(feature.geometry, frame).is_valid and not _holes_touch(feature, frame):
        raise OperationRefused("nothing_to_do", f"No edges of {title(feature)} cross.")
    pieces = polygon_pieces(polygons_in(_sound(feature, frame)), frame)
    changes = changes_for_pieces(feature, pieces, selection.draft, feature.properties)
    return Outcome(f"Outline of {title(feature)} untangled", (*changes, *rows_that_follow(changes, selection.draft)))


def _sound(feature: MapFeature, frame: LocalFrame) -> Shape:
    outline, *holes = (_reordered(frame.to_local(ring[:-1])) for ring in paths(feature.geometry))
    whole = sound(Polygon(outline))
    cut = [_to_the_edge(sound(Polygon(ring)), whole) for ring in holes]
    inner = areas_in(shapely.union_all(cut, grid_size=GRID_M))
    return shapely.difference(whole, inner, grid_size=GRID_M)


def _to_the_edge(hole: Shape, whole: Shape) -> Shape:
    """Return the hole wide enough to open the edge it touches; in one corner only it would leave no way in."""
    is_touching = whole.covers(hole) and whole.boundary.distance(hole) < APART_M
    return hole.buffer(OPEN_M, join_style="mitre") if is_touching else hole


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


def _holes_touch(feature: MapFeature, frame: LocalFrame) -> bool:
    outline, *holes = (Polygon(frame.to_local(ring)) for ring in paths(feature.geometry))
    if any(outline.exterior.distance(hole) < APART_M for hole in holes):
        return True
    return any(a.distance(b) == 0 for n, a in enumerate(holes) for b in holes[:n])

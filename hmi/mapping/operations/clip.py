"""Take away from an area what others cover."""

from __future__ import annotations

import shapely

from hmi.mapping.errors import OperationRefused
from hmi.mapping.ground import GRID_M, areas_in, covered_by, polygons_in
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome
from hmi.mapping.operations.pieces import changes_for_pieces, polygon_pieces, rows_that_follow
from hmi.mapping.operations.selection import Selection, title, titles

LEAST_M2 = 0.01


def clip(selection: Selection, arguments: Arguments) -> Outcome:
    """Cut ``others`` out of one polygon: areas as drawn, lines with their width, points with their radius.

    Raises:
        OperationRefused: nothing overlaps, or nothing would be left.
    """
    feature, frame, shape = selection.one_polygon()
    others = [selection.named(one) for one in arguments.feature_ids("others")]
    if feature.id in {one.id for one in others}:
        raise OperationRefused("bad_argument", f"{title(feature)} cannot be cut by itself. Choose other features.")
    taken = areas_in(shapely.union_all([covered_by(one, frame) for one in others], grid_size=GRID_M))
    if shapely.intersection(shape, taken, grid_size=GRID_M).area < LEAST_M2:
        raise OperationRefused("nothing_to_do", f"{titles(others)} and {title(feature)} do not overlap.")
    left = polygon_pieces(polygons_in(shapely.difference(shape, taken, grid_size=GRID_M)), frame)
    changes = changes_for_pieces(feature, left, selection.draft, feature.properties)
    return Outcome(
        f"{title(feature)} cut back at {titles(others)}", (*changes, *rows_that_follow(changes, selection.draft))
    )

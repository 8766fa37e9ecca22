"""Split a polygon or a line along a line drawn across it."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from shapely.geometry import LineString, Point
from shapely.ops import polygonize

from hmi.mapping.coordinates import Geometry, Position, paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import GRID_M, Shape, frame_of, place, shape_of
from hmi.mapping.kinds import LINE, POLYGON
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome
from hmi.mapping.operations.pieces import changes_for_pieces, polygon_pieces, rows_that_follow
from hmi.mapping.operations.selection import Selection, sound_polygon, title
from hmi.planning.projection import Floats, LocalFrame

REACH_M = 1.0  # a line that ends this near inside the edge was meant to reach it
LEAST_PIECE_M2 = 0.5
LEAST_PIECE_M = 0.05
_WORDS = ("two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def split(selection: Selection, arguments: Arguments) -> Outcome:
    """Cut one polygon or line; the largest piece keeps id and name, rows follow the piece they lie in.

    Raises:
        OperationRefused: the line does not cut through, or cuts off a crumb.
    """
    feature = selection.one()
    frame = frame_of([feature])
    cut = frame.to_local(arguments.line("line"))
    if not np.isfinite(cut).all():
        raise _no_cut(feature)
    pieces = _pieces(feature, frame, cut)
    changes = changes_for_pieces(feature, pieces, selection.draft, feature.properties)
    label = f"Split {title(feature)} in {_WORDS[len(pieces) - 2] if len(pieces) <= 10 else len(pieces)}"
    return Outcome(label, (*changes, *rows_that_follow(changes, selection.draft)))


def _pieces(feature: MapFeature, frame: LocalFrame, cut: Floats) -> list[Geometry]:
    if feature.geometry["type"] == POLYGON:
        return _areas(feature, frame, cut)
    if feature.geometry["type"] == LINE:
        return _lines(feature, frame, LineString(cut))
    raise OperationRefused("cannot_split", f"{title(feature)} is neither an area nor one line. Choose one of those.")


def _areas(feature: MapFeature, frame: LocalFrame, cut: Floats) -> list[Geometry]:
    shape = sound_polygon(feature, frame)
    edges = shapely.union_all([shape.boundary, LineString(_reaching(cut, shape))], grid_size=GRID_M)
    shapely.prepare(shape)
    pieces = [piece for piece in polygonize(edges) if shape.contains(piece.representative_point())]
    if len(pieces) < 2:
        raise _no_cut(feature)
    if min(piece.area for piece in pieces) < LEAST_PIECE_M2:
        raise OperationRefused(
            "crumb", f"A piece would be smaller than {LEAST_PIECE_M2:g} m². Draw the line further from the edge."
        )
    return polygon_pieces(sorted(pieces, key=lambda piece: -piece.area), frame)


def _reaching(cut: Floats, shape: Shape) -> Floats:
    """Draw an end that stops just inside, or on the edge, out across it."""
    first, last = _beyond(cut[1], cut[0], shape), _beyond(cut[-2], cut[-1], shape)
    return np.vstack([first, cut[1:-1], last])


def _beyond(inner: Floats, end: Floats, shape: Shape) -> Floats:
    step = end - inner
    length = float(np.hypot(*step))
    if length == 0 or shape.distance(Point(end)) > 0.01:
        return end
    further: Floats = end + step / length * REACH_M
    return further


def _lines(feature: MapFeature, frame: LocalFrame, cut: Shape) -> list[Geometry]:
    degrees = paths(feature.geometry)[0]
    local = shape_of(feature.geometry, frame).coords
    pieces: list[list[Position]] = [[degrees[0]]]
    for (a, b), there in zip(pairwise(local), degrees[1:], strict=True):
        for crossing in sorted(_crossings(LineString([a, b]), cut), key=Point(a).distance):
            at = place(crossing.coords[0], frame)
            if at != pieces[-1][-1]:
                pieces[-1].append(at)
            pieces.append([at])
        if there != pieces[-1][-1]:
            pieces[-1].append(there)
    lengths = [LineString(frame.to_local(p)).length if len(p) > 1 else 0.0 for p in pieces]
    kept = [(length, piece) for length, piece in zip(lengths, pieces, strict=True) if length > 0]
    if len(kept) < 2:
        raise _no_cut(feature)
    if min(length for length, _ in kept) < LEAST_PIECE_M:
        raise OperationRefused("crumb", "A piece would be shorter than 5 cm. Draw the line further from the end.")
    kept.sort(key=lambda pair: -pair[0])
    return [{"type": LINE, "coordinates": piece} for _, piece in kept]


def _crossings(edge: Shape, cut: Shape) -> list[Any]:
    return [part for part in shapely.get_parts(edge.intersection(cut)) if part.geom_type == "Point"]


def _no_cut(feature: MapFeature) -> OperationRefused:
    return OperationRefused(
        "no_cut", f"The line does not cut {title(feature)} in two. Draw it from one side right across to the other."
    )

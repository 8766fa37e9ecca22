"""Give the strip between two parcels to one of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import Polygon

from hmi.mapping.errors import OperationRefused
from hmi.mapping.ground import GRID_M, Shape, frame_of, polygon_geometry, polygons_in
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.edges import needless
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.pieces import CRUMB_M2
from hmi.mapping.operations.selection import Selection, sound_polygon, title
from hmi.mapping.operations.strips import SLIVER_M, strips_between
from hmi.planning.projection import Floats

MOST_M = 5.0
SEAM_M = 2e-3  # a strip computed by offsets lies a hair away from what it joins


def close_gap(selection: Selection, arguments: Arguments) -> Outcome:
    """Let one polygon grow up to ``to`` where less than ``width_m`` lies between them; ``to`` stays as it is.

    Raises:
        OperationRefused: not two areas, or no such strip between them.
    """
    feature = selection.one()
    other = selection.named(arguments.feature_id("to"))
    width_m = arguments.number("width_m", 0.01, MOST_M, SLIVER_M)
    if other.id == feature.id:
        raise OperationRefused("bad_argument", f"{title(feature)} has no gap to itself. Choose its neighbour.")
    frame = frame_of([feature, other])
    shape, wall = sound_polygon(feature, frame), sound_polygon(other, frame)
    strips = strips_between(shape, wall, width_m)
    if not strips:
        raise OperationRefused(
            "nothing_to_do", f"No strip narrower than {width_m:g} m lies between {title(feature)} and {title(other)}."
        )
    geometry = polygon_geometry(_grown(shape, wall, strips), frame)
    if geometry is None:
        raise OperationRefused("vanishes", f"Nothing would be left of {title(feature)}. Move its corners by hand.")
    label = f"Gap between {title(feature)} and {title(other)} closed"
    return Outcome(label, (changed(feature, replace(feature, geometry=geometry)),))


def _grown(shape: Shape, wall: Shape, strips: list[Polygon]) -> Polygon:
    wide = [strip.buffer(SEAM_M, join_style="mitre") for strip in strips]
    grown = shapely.difference(shapely.union_all([shape, *wide], grid_size=GRID_M), wall, grid_size=GRID_M)
    whole = polygons_in(grown)[0]
    holes = [_clean(ring) for ring in whole.interiors if Polygon(ring).area > CRUMB_M2]
    return Polygon(_clean(whole.exterior), holes)


def _clean(ring: Shape) -> Floats:
    """Leave out what the seam adds: corners that are double or a spike."""
    corners = np.asarray(ring.coords, dtype=np.float64)[:-1]
    kept: Floats = np.delete(corners, needless(corners, is_closed=True), axis=0)
    return kept if len(kept) > 2 else corners

"""Add a hole to a parcel, or take one away."""

from __future__ import annotations

from dataclasses import replace

import shapely
from shapely.geometry import Polygon

from hmi.mapping.coordinates import paths, with_paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import polygon_geometry
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.selection import Selection, title

APART_M = 0.01  # between hole and edge, and between two holes


def add_hole(selection: Selection, arguments: Arguments) -> Outcome:
    """Cut ``ring`` out of one parcel; rings are numbered, the outline is 0, the new hole the last.

    Raises:
        OperationRefused: the ring crosses itself, leaves the parcel, or meets another hole.
    """
    parcel = _parcel(selection)
    _, frame, shape = selection.one_polygon()
    hole = Polygon(frame.to_local(arguments.ring("ring")))
    if not hole.is_valid:
        raise OperationRefused("crosses_itself", "The outline of the hole crosses itself. Draw it again.")
    outline = Polygon(shape.exterior)
    if not outline.contains(hole) or shapely.distance(outline.exterior, hole) < APART_M:
        raise OperationRefused("outside", f"The hole is not inside {title(parcel)}. Draw it clear of the edge.")
    for number, other in enumerate(shape.interiors, 1):
        if shapely.distance(Polygon(other), hole) < APART_M:
            raise OperationRefused(
                "meets_hole", f"The hole meets hole {number}. Draw it clear, or remove that one first."
            )
    degrees = polygon_geometry(hole, frame)
    if degrees is None:
        raise OperationRefused("vanishes", "The hole is smaller than 1 mm. Draw it larger.")
    ring = degrees["coordinates"][0][::-1]
    new = with_paths(parcel.geometry, [*paths(parcel.geometry), ring])
    return Outcome(f"Hole added in {title(parcel)}", (changed(parcel, replace(parcel, geometry=new)),))


def remove_hole(selection: Selection, arguments: Arguments) -> Outcome:
    """Take away hole number ``ring``, 1 is the first.

    Raises:
        OperationRefused: no parcel, or no such hole.
    """
    parcel = _parcel(selection)
    every = paths(parcel.geometry)
    if len(every) == 1:
        raise OperationRefused("no_hole", f"{title(parcel)} has no hole. Choose a parcel that has one.")
    number = arguments.index("ring", len(every), first=1)
    new = with_paths(parcel.geometry, [ring for n, ring in enumerate(every) if n != number])
    return Outcome(f"Hole removed from {title(parcel)}", (changed(parcel, replace(parcel, geometry=new)),))


def _parcel(selection: Selection) -> MapFeature:
    feature = selection.one()
    if feature.kind != "parcel":
        raise OperationRefused("not_a_parcel", f"{title(feature)} is no parcel. Only parcels have holes.")
    return feature

"""Merge polygons that touch, overlap, or lie a small gap apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import shapely
from shapely.geometry import Polygon

from hmi.domain.map_ground import FLOWN_OVER_KINDS, object_height_m
from hmi.mapping.attributes import HEIGHT
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import GRID_M, Shape, areas_in, frame_of, polygons_in, sound
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.pieces import CRUMB_M2, clean_geometry, rows_that_follow
from hmi.mapping.operations.selection import Selection, sound_polygon, title, titles

GAP_M = 0.5
MOST_GAP_M = 10.0
TOUCH_M = 0.005  # corners rounded to 1 mm, edges of different length on top of each other


def merge(selection: Selection, arguments: Arguments) -> Outcome:
    """Make one polygon of several; the largest keeps id, name and attributes, rows of the others follow.

    What stands up is then as high as the highest of them, for somebody may fly over it.

    Raises:
        OperationRefused: fewer than two, of different kinds, or further apart than ``gap_m``.
    """
    gap_m = arguments.number("gap_m", 0, MOST_GAP_M, GAP_M)
    chosen = selection.chosen
    if len(chosen) < 2:
        raise OperationRefused("two_or_more", "One feature is chosen. Choose two or more to merge.")
    if len({one.kind for one in chosen}) > 1:
        raise OperationRefused(
            "different_kinds", f"{titles(chosen)} are of different kinds. Choose features of one kind."
        )
    frame = frame_of(chosen)
    shapes = [sound_polygon(one, frame) for one in chosen]
    whole = _united(shapes, max(gap_m, TOUCH_M))
    parts = polygons_in(whole)
    if len(parts) != 1:
        apart_m = shapely.distance(parts[0], shapely.union_all(parts[1:]))
        if apart_m < 0.01:
            raise OperationRefused(
                "apart", f"{titles(chosen)} meet in a corner only. Move an edge of one to the other."
            )
        raise OperationRefused(
            "apart", f"{titles(chosen)} lie {max(apart_m, 0.1):.1f} m apart. Move them together, or allow a wider gap."
        )
    geometry = clean_geometry(_without_crumbs(parts[0]), frame)
    if geometry is None:
        raise OperationRefused("vanishes", f"{titles(chosen)} are too thin to merge. Draw one outline around them.")
    keeper = max(zip(shapes, chosen, strict=True), key=lambda pair: pair[0].area)[1]
    changes = [changed(keeper, replace(keeper, geometry=geometry, properties=_as_high(keeper, chosen)))]
    changes += [changed(one, None) for one in chosen if one is not keeper]
    label = f"Merged {titles(chosen)}" + (f" into {title(keeper)}" if len(chosen) > 2 else "")
    return Outcome(label, (*changes, *rows_that_follow(changes, selection.draft)))


def _as_high(keeper: MapFeature, chosen: Sequence[MapFeature]) -> dict[str, Any]:
    """Return its properties with the height of the highest; none where one of them does not say how high it is."""
    if keeper.kind not in FLOWN_OVER_KINDS:
        return keeper.properties
    rest = {key: value for key, value in keeper.properties.items() if key != HEIGHT}
    heights = [object_height_m(one.kind, one.properties) for one in chosen]
    known = [height for height in heights if height is not None]
    return {**rest, HEIGHT: max(known)} if len(known) == len(heights) else rest


def _united(shapes: list[Shape], gap_m: float) -> Shape:
    """Unite, and fill gaps that lie between two of the shapes; corners of the shapes stay where they are."""
    together = areas_in(shapely.union_all(shapes, grid_size=GRID_M))
    grown = together.buffer(gap_m / 2 + 1e-4, join_style="mitre")
    closed = sound(grown.buffer(-gap_m / 2 - 1e-4, join_style="mitre"))
    filled = shapely.difference(closed, together, grid_size=GRID_M)
    bridges = [gap for gap in polygons_in(filled) if sum(shapely.dwithin(gap, shape, 1e-3) for shape in shapes) > 1]
    # a bridge computed by two offsets lies a hair away from what it joins
    wide = [gap.buffer(1e-3, join_style="mitre") for gap in bridges]
    return shapely.union_all([together, *wide], grid_size=GRID_M)


def _without_crumbs(polygon: Polygon) -> Polygon:
    return Polygon(polygon.exterior, [ring for ring in polygon.interiors if Polygon(ring).area > CRUMB_M2])

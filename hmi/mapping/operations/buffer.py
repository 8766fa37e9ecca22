"""Grow or shrink features by a distance."""

from __future__ import annotations

from dataclasses import replace

from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import Shape, frame_of, half_width_m, polygons_in, shape_of
from hmi.mapping.kinds import KINDS, LINE, POINT, POLYGON
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Change, Outcome, changed
from hmi.mapping.operations.pieces import changes_for_pieces, polygon_pieces
from hmi.mapping.operations.selection import Selection, sound_polygon, title, titles

MOST_M = 1000.0
LEAST_M = 0.01
MITRE = 2.5  # a corner sharper than 47 degrees is cut off at 2.5 times the distance, never nearer


def buffer(selection: Selection, arguments: Arguments) -> Outcome:
    """Move the edge of features outwards, or inwards where ``distance_m`` is negative.

    A line becomes the area that reaches ``distance_m`` past its width. What an inset cuts apart becomes new features.

    Raises:
        OperationRefused: a feature has no edge to move, or vanishes.
    """
    distance_m = arguments.number("distance_m", -MOST_M, MOST_M)
    if abs(distance_m) < LEAST_M:
        raise OperationRefused("nothing_to_do", "The distance is less than 1 cm. Give a longer one.")
    draft = dict(selection.draft)
    changes: list[Change] = []
    for feature in selection.chosen:
        new = _buffered(feature, distance_m, draft)
        changes += new
        draft |= {change.id: change.after for change in new if change.after is not None}
    how = "grown" if distance_m > 0 else "shrunk"
    return Outcome(f"{titles(selection.chosen)} {how} by {abs(distance_m):g} m", tuple(changes))


def _buffered(feature: MapFeature, distance_m: float, draft: dict[str, MapFeature]) -> tuple[Change, ...]:
    kind = feature.geometry["type"]
    frame = frame_of([feature])
    if kind == POLYGON:
        grown = sound_polygon(feature, frame).buffer(distance_m, join_style="mitre", mitre_limit=MITRE)
        return changes_for_pieces(feature, polygon_pieces(polygons_in(grown), frame), draft, feature.properties)
    if kind == POINT and "radius_m" in feature.properties:
        return (_with_radius(feature, distance_m),)
    if kind == LINE and POLYGON in KINDS[feature.kind].geometries:
        area = _around(feature, shape_of(feature.geometry, frame), distance_m)
        rest = {key: value for key, value in feature.properties.items() if key != "width_m"}
        return changes_for_pieces(feature, polygon_pieces(polygons_in(area), frame), draft, rest)
    raise OperationRefused(
        "no_edge", f"{title(feature)} has no edge to move. Choose an area or a line that can be one."
    )


def _around(feature: MapFeature, line: Shape, distance_m: float) -> Shape:
    reach_m = half_width_m(feature) + distance_m
    if reach_m <= 0:
        raise OperationRefused(
            "vanishes", f"{title(feature)} is {2 * half_width_m(feature):g} m wide; nothing would be left. Choose less."
        )
    return line.buffer(reach_m, cap_style="square", join_style="mitre", mitre_limit=MITRE)


def _with_radius(feature: MapFeature, distance_m: float) -> Change:
    radius_m = round(feature.properties["radius_m"] + distance_m, 3)
    if radius_m <= 0:
        raise OperationRefused("vanishes", f"Nothing would be left of {title(feature)}. Choose less, or delete it.")
    return changed(feature, replace(feature, properties={**feature.properties, "radius_m": radius_m}))

"""Shift and turn features without changing their shape."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import shapely

from hmi.mapping.coordinates import paths, positions, rounded, with_paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import distance_m, frame_of
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.selection import Selection, titles
from hmi.planning.projection import Floats, LocalFrame

FURTHEST_M = 10_000.0
WIDEST_M = 50_000.0  # across everything moved at once: further away the plane bends
_DIRECTIONS = ("east", "north-east", "north", "north-west", "west", "south-west", "south", "south-east")


def shift(selection: Selection, arguments: Arguments) -> Outcome:
    """Move features ``east_m`` and ``north_m``, as one piece.

    Raises:
        OperationRefused: by less than 1 mm, or features too far apart to move as one.
    """
    east_m = arguments.number("east_m", -FURTHEST_M, FURTHEST_M)
    north_m = arguments.number("north_m", -FURTHEST_M, FURTHEST_M)
    length_m = math.hypot(east_m, north_m)
    if length_m < 0.001:
        raise OperationRefused("nothing_to_do", "The way is less than 1 mm. Give a longer one.")
    frame = _frame(selection.chosen)
    new = [_moved(one, frame, lambda xy: xy + np.array([east_m, north_m])) for one in selection.chosen]
    towards = _DIRECTIONS[round(math.atan2(north_m, east_m) / (math.pi / 4)) % 8]
    way = f"{length_m:.2f} m" if length_m < 10 else f"{length_m:.0f} m"
    return _outcome(selection, new, f"{titles(selection.chosen)} moved {way} {towards}")


def turn(selection: Selection, arguments: Arguments) -> Outcome:
    """Turn features clockwise by ``angle_deg`` about the middle of all of them; directions of theirs turn as well.

    Raises:
        OperationRefused: by less than 0.001 degrees, or features too far apart to turn as one.
    """
    angle_deg = arguments.number("angle_deg", -360, 360)
    if abs(angle_deg) < 0.001:
        raise OperationRefused("nothing_to_do", "The angle is less than 0.001 degrees. Give a larger one.")
    frame = _frame(selection.chosen)
    every = frame.to_local([p for one in selection.chosen for p in positions(one.geometry)])
    middle = np.array(shapely.MultiPoint(every).convex_hull.centroid.coords[0])  # turning back finds the same one
    cos, sin = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    clockwise = np.array([[cos, -sin], [sin, cos]])  # row vectors
    new = [_moved(one, frame, lambda xy: (xy - middle) @ clockwise + middle) for one in selection.chosen]
    new = [replace(one, properties=_turned(one.properties, angle_deg)) for one in new]
    side = "clockwise" if angle_deg > 0 else "counter-clockwise"
    return _outcome(selection, new, f"{titles(selection.chosen)} turned {abs(angle_deg):g} degrees {side}")


def _frame(features: Sequence[MapFeature]) -> LocalFrame:
    every = [p for one in features for p in positions(one.geometry)]
    lons, lats = [p[0] for p in every], [p[1] for p in every]
    if distance_m((min(lons), min(lats)), (max(lons), max(lats))) > WIDEST_M:
        raise OperationRefused("too_far_apart", "These features lie more than 50 km apart. Move them site by site.")
    return frame_of(features)


def _moved(feature: MapFeature, frame: LocalFrame, step: Callable[[Floats], Floats]) -> MapFeature:
    new = [[rounded(*p) for p in frame.to_lon_lat(step(frame.to_local(path)))] for path in paths(feature.geometry)]
    return replace(feature, geometry=with_paths(feature.geometry, new))


def _turned(properties: dict[str, Any], clockwise_deg: float) -> dict[str, Any]:
    turned = dict(properties)
    if isinstance(properties.get("row_bearing_deg"), (int, float)):
        turned["row_bearing_deg"] = round((properties["row_bearing_deg"] + clockwise_deg) % 180, 6)
    if isinstance(properties.get("heading_deg"), (int, float)):
        turned["heading_deg"] = round((properties["heading_deg"] - clockwise_deg) % 360, 6)
    return turned


def _outcome(selection: Selection, new: Sequence[MapFeature], label: str) -> Outcome:
    pairs = zip(selection.chosen, new, strict=True)
    return Outcome(label, tuple(changed(before, after) for before, after in pairs))

"""Bring the end of a road onto another road."""

from __future__ import annotations

from dataclasses import replace

from shapely.geometry import Point
from shapely.ops import nearest_points

from hmi.mapping.errors import OperationRefused
from hmi.mapping.ground import frame_of, place, shape_of
from hmi.mapping.kinds import LINE
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.selection import Selection, title

ON_ROAD_M = 0.05  # nearer counts as on it: a hand-set corner snapped to 1 mm, an edge re-drawn between others
FURTHEST_M = 20.0


def snap_end(selection: Selection, arguments: Arguments) -> Outcome:
    """Move the end of one road that lies nearest to, but not on, road ``to`` onto it.

    Raises:
        OperationRefused: not a line, not two roads, already joined, or further than 20 m away.
    """
    road, target = selection.one(), selection.named(arguments.feature_id("to"))
    if road.kind != "road" or road.geometry["type"] != LINE:
        raise OperationRefused("not_a_road", f"{title(road)} is no road drawn as a line. Choose one.")
    if target.kind != "road" or target.id == road.id:
        raise OperationRefused("not_a_road", f"{title(target)} is no other road. Choose the road to reach.")
    frame = frame_of([road])
    line, goal = shape_of(road.geometry, frame), shape_of(target.geometry, frame)
    ends = [(goal.distance(Point(line.coords[n])), n) for n in (0, -1)]
    short = [(gap, n) for gap, n in ends if gap > ON_ROAD_M]
    if not short or (len(short) == 1 and short[0][0] > FURTHEST_M):
        raise OperationRefused("nothing_to_do", f"{title(road)} reaches {title(target)} already.")
    gap, end = min(short)
    if gap > FURTHEST_M:
        raise OperationRefused(
            "too_far",
            f"{title(road)} ends {gap:.0f} m away from {title(target)}. Draw it nearer than {FURTHEST_M:g} m.",
        )
    at = place(nearest_points(goal, Point(line.coords[end]))[0].coords[0], frame)
    coordinates = [list(p) for p in road.geometry["coordinates"]]
    coordinates[end] = at
    if len({tuple(p) for p in coordinates}) < 2:
        raise OperationRefused("vanishes", f"Nothing would be left of {title(road)}. Delete it instead.")
    after = replace(road, geometry={"type": LINE, "coordinates": coordinates})
    return Outcome(f"{title(road)} joined to {title(target)}", (changed(road, after),))

"""What a machine in the air flies over and around, in words."""

from __future__ import annotations

import shapely
from shapely.geometry.base import BaseGeometry

from hmi.domain.flight import CLEARANCE_M, named
from hmi.domain.mission_plan import Surroundings
from hmi.planning.machine import RobotProfile
from hmi.planning.projection import LocalFrame
from hmi.planning.surroundings import area_of

HEIGHT_UNKNOWN = (
    "The robot does not say how high it flies: it flies around obstacles, buildings, hedges, trees and keep-out zones."
)
Place = tuple[float, float]


def flight_notes(
    around: Surroundings, frame: LocalFrame, machine: RobotProfile, ground: BaseGeometry, home: Place | None
) -> tuple[str, ...]:
    """Return the sentences of a plan that is flown, none of one that is driven.

    Args:
        ground: the field; what stands neither over it nor between it and home is not named.
    """
    if not machine.flies:
        return ()
    height_m = around.flight_height_m
    if height_m is None:
        return (HEIGHT_UNKNOWN,)
    over = f"over water and what is lower than {height_m - CLEARANCE_M:g} m, around all else and keep-out zones"
    places = [ground] if home is None else [ground, shapely.Point(home)]
    flown = shapely.union_all(places).convex_hull
    kept_m = machine.clearance_m + machine.reach_m + machine.margin_m
    shapely.prepare(flown)
    near = (k for k in around.unmeasured if shapely.dwithin(flown, area_of(*around.obstacles[k], frame), kept_m))
    missed = list(dict.fromkeys(around.names[k] for k in near))
    said = f"It flies {height_m:g} m above the ground, {over}."
    return (said, _unmeasured(missed)) if missed else (said,)


def _unmeasured(names: list[str]) -> str:
    of, its, over = ("no height of it", "its height", "it")
    if len(names) > 1:
        of, its, over = ("no heights of them", "their heights", "them")
    return f"Flown around, for the map has {of}: {named(names)}. Enter {its} on the map to fly over {over}."

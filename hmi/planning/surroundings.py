"""What lies around a field, on the plan's plane: closed ground, ways and slow zones."""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely.geometry import shape
from shapely.geometry.base import BaseGeometry

from hmi.domain.mission_plan import Geometry, PlanRefused, Surroundings
from hmi.planning.machine import RobotProfile
from hmi.planning.projection import LocalFrame
from hmi.planning.speed_limits import SpeedLimits


def closed_areas(around: Surroundings, frame: LocalFrame, machine: RobotProfile) -> list[BaseGeometry]:
    """Return the ground that a machine may not enter, with the clearance it keeps; raises as ``area_of``."""
    closed = [area_of(geometry, width, frame) for geometry, width in around.obstacles]
    closed += crossed_areas(around, frame)
    return [area.buffer(machine.clearance_m) for area in closed] if machine.clearance_m else closed


def crossed_areas(around: Surroundings, frame: LocalFrame) -> list[BaseGeometry]:
    """Return water, hedges and trees without the ways across; raises as ``area_of``."""
    crossed = [area_of(geometry, width, frame) for geometry, width in around.crossed]
    if not crossed:
        return []
    # whoever draws a road through a hedge or over a ditch says that there is a gap or a bridge
    ways = shapely.union_all(way_areas(around, frame))
    return [left for left in (area.difference(ways) for area in crossed) if not left.is_empty]


def way_areas(around: Surroundings, frame: LocalFrame) -> list[BaseGeometry]:
    """Return roads and yards; raises as ``area_of``."""
    return [area_of(geometry, width, frame) for geometry, width in around.ways]


def limits_of(around: Surroundings, frame: LocalFrame, machine: RobotProfile) -> SpeedLimits:
    """Return the slow zones, wider by what the machine reaches: none of it is faster there.

    Raises:
        PlanRefused: as ``area_of``, or a zone has no speed.
    """
    if not all(0 < most < math.inf for _, most in around.slow):
        raise PlanRefused("bad_map", "A slow zone of the map has no speed above 0 m/s.", "field_id")
    areas = ((area_of(geometry, 0.0, frame), most) for geometry, most in around.slow)
    return SpeedLimits(tuple((area.buffer(machine.reach_m), most) for area, most in areas))


def rings_of(geometry: Geometry) -> list[list[list[float]]]:
    """Return the outline of a field as a mission carries it: of several parts the first."""
    coordinates = geometry["coordinates"]
    rings = coordinates[0] if geometry["type"] == "MultiPolygon" else coordinates
    return [[[round(float(p[0]), 9), round(float(p[1]), 9)] for p in ring] for ring in rings]


def area_of(geometry: Geometry, width_m: float, frame: LocalFrame) -> BaseGeometry:
    """Return a map feature as ground: polygons as they are, lines and points with their width.

    Raises:
        PlanRefused: it is not GeoJSON.
    """
    try:
        local = shapely.transform(shape(geometry), frame.to_local)
    except (TypeError, ValueError, AttributeError, shapely.errors.ShapelyError) as error:
        raise PlanRefused("bad_map", "The map has a feature that is not valid GeoJSON.", "field_id") from error
    if not (np.isfinite(shapely.get_coordinates(local)).all() and math.isfinite(width_m)):
        raise PlanRefused("bad_map", "The map has a feature whose place or size is not a number.", "field_id")
    if local.geom_type in ("Polygon", "MultiPolygon"):
        return local if local.is_valid else local.buffer(0)
    return local.buffer(max(width_m, 0.1) / 2)

"""Where a machine may be, and the ways it can take there.

``turning`` is the ground eroded by the circle the outline sweeps: with its base inside, the machine fits at
any heading. Outside ``turning`` the outline itself is tested, pose by pose.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import shapely
from shapely.geometry import LineString, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from hmi.planning.machine import RobotProfile
from hmi.planning.plan import poses_along
from hmi.planning.projection import Floats
from hmi.planning.ways import Ways

CHECK_STEP_M = 0.2  # outlines tested this far apart; between two of them a corner moves less than the margin
_TOUCH_M = (
    1.5e-3  # a row end lies on the border of the turning ground; the millimetres of a document must not put it outside
)


def erode(area: BaseGeometry, distance_m: float) -> BaseGeometry:
    """Shrink by at least ``distance_m``: mitred corners give up a little more than they must, never less."""
    return area.buffer(-distance_m, join_style="mitre", mitre_limit=3.0)


def polygons_of(area: BaseGeometry) -> list[Polygon]:
    """Return the polygons of any geometry, largest first."""
    parts = [p for p in shapely.get_parts(area) if isinstance(p, Polygon) and not p.is_empty]
    return sorted(parts, key=lambda p: p.area, reverse=True)


class Ground:
    """Allowed ground for one machine.

    Args:
        allowed: where the outline may be, metres.
        machine: whose outline it is.
        crop: standing rows that a way between two places should go around.
    """

    def __init__(self, allowed: BaseGeometry, machine: RobotProfile, crop: BaseGeometry | None = None) -> None:
        self.allowed = allowed
        self.machine = machine
        self.crop = crop if crop is not None else MultiPolygon()
        self.turning = erode(allowed, machine.reach_m + machine.margin_m)
        self._kept = erode(allowed, machine.margin_m / 2)
        self._free = self.turning.buffer(_TOUCH_M)
        # necessary and cheap: half a width from the border at the least
        self._drivable = allowed.buffer(_TOUCH_M - machine.width_m / 2)
        for area in (self.allowed, self._kept, self._free, self._drivable, self.crop):
            shapely.prepare(area)

    def can_turn_at(self, xy: tuple[float, float]) -> bool:
        """Say whether the machine fits there at any heading."""
        return bool(shapely.covers(self._free, Point(xy)))

    def may_be_at(self, xy: tuple[float, float]) -> bool:
        """Say quickly whether there may be a heading at which the machine fits there."""
        return bool(shapely.covers(self._drivable, Point(xy)))

    def fits(self, points: Floats, *, is_crop_free: bool = False, is_backward: bool = False) -> bool:
        """Say whether the outline stays on the ground along a polyline, and the polyline off the standing rows."""
        if len(points) < 2:
            return True
        line = shapely.linestrings(points)
        if not shapely.covers(self._drivable, line):
            return False
        if is_crop_free and shapely.intersects(self.crop, line):
            return False
        if shapely.covers(self._free, line):
            return True
        outlines = self.machine.outline_polygons(poses_along(points, CHECK_STEP_M, is_backward=is_backward))
        return bool(shapely.covers(self._kept, outlines).all())

    def fitting(self, points: Floats, step_m: float = CHECK_STEP_M) -> tuple[Floats, Floats]:
        """Return places along a polyline, metres from its beginning, and whether the outline is on the ground there."""
        poses = poses_along(points, step_m)
        along_m = np.append(0.0, np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T)))
        return along_m, np.asarray(shapely.covers(self._kept, self.machine.outline_polygons(poses)))

    def outside_m(self, points: Floats, step_m: float = CHECK_STEP_M) -> float:
        """Return how many metres of a polyline the outline is partly off the ground."""
        poses = poses_along(points, step_m)
        if shapely.covers(self._free, LineString(points)):
            return 0.0
        return float((~shapely.covers(self.allowed, self.machine.outline_polygons(poses))).sum()) * step_m

    def way(self, start: tuple[float, float], goal: tuple[float, float]) -> Floats | None:
        """Return the cheapest polyline from start to goal inside the turning ground, or ``None``.

        Cheap is short and off the standing rows; corners are where the machine turns.
        """
        ends = np.array([start, goal])
        line = shapely.linestrings(ends)
        if shapely.covers(self._free, line) and not shapely.intersects(self.crop, line):
            return ends
        if not (self.can_turn_at(start) and self.can_turn_at(goal)):
            return None
        return self._ways.cheapest(ends)

    @cached_property
    def _ways(self) -> Ways:
        return Ways(self._free, self.crop, self._corners())

    def _corners(self) -> Floats:
        """Points where a shortest way may bend: a little inside the turning ground, and around the crop."""
        slack = 0.45 * self.machine.turning_radius_m  # room to round a right angle without leaving the ground
        areas = [*polygons_of(erode(self.turning, slack)), *polygons_of(self.turning)]
        found = [corner for area in areas for corner in bends_of(area.simplify(0.02))]
        outside_crop = self.crop.buffer(0.05, join_style="mitre", mitre_limit=2.0)
        found += [c for area in polygons_of(outside_crop) for c in bends_of(area.simplify(0.02), outward=True)]
        if not found:
            return np.empty((0, 2))
        corners = np.unique(np.round(np.array(found), 3), axis=0)
        inside = shapely.covers(self._free, shapely.points(corners))
        return np.asarray(corners[inside], dtype=np.float64)


def bends_of(area: Polygon, *, outward: bool = False) -> list[tuple[float, float]]:
    """Return the corners of a polygon around which a way inside it (or outside, ``outward``) may bend."""
    corners: list[tuple[float, float]] = []
    oriented = orient(area)  # ground on the left of every ring, so that a left turn is a convex corner
    for ring in (oriented.exterior, *oriented.interiors):
        points = shapely.get_coordinates(ring)[:-1]
        before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
        cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        corners += [(float(x), float(y)) for x, y in points[cross > 0 if outward else cross < 0]]
    return corners

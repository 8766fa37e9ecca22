"""Lines that a machine can follow: drawn on straight at their ends, and bent no tighter than its turning radius.

A line that runs from border to border of a large box parts it in two. Shrinking one part gives the parallels of the
line without loops, whatever it does; shrinking it more and growing it again rounds what is too tight.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import split

from hmi.planning.ground import polygons_of
from hmi.planning.plan import headings
from hmi.planning.projection import Floats

NOISE_M = 0.02  # RTK is no better: what a recorded line wavers by is not followed
SLACK_RAD = math.radians(3)  # half a piece of a sampled arc, nearly
KINK_RAD = math.radians(8)  # more at one point is a corner, however long the pieces on its sides
_QUARTER = 24  # pieces of a quarter circle
_THIN_M, _THIN = 0.005, 0.001  # points nearer to the line of their neighbours are left out; the latter of the radius
_END_M = 1.0  # the direction of an end is that of its last metre
_EPS_M = 1e-3


class NoSide(Exception):
    """A line does not part the ground in two: it crosses itself, or does when drawn on at its ends."""


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """The ground on one side of a line, as far as it counts.

    Args:
        area: that ground, with a border far away from ``window``.
        window: where lines are wanted.
        along: the line itself; parallels run in its direction.
    """

    area: Polygon
    window: Polygon
    along: LineString

    def parallel(self, offset_m: float) -> list[Floats]:
        """Return the line ``offset_m`` inside the side, its pieces in the window one after another."""
        return self._lines(self.area.buffer(-offset_m, quad_segs=_QUARTER) if offset_m else self.area)

    def gentle_parallel(self, offset_m: float, radius_m: float) -> list[Floats]:
        """Return the parallel with everything rounded that is bent tighter than a radius."""
        return self._lines(self._gentle(offset_m, radius_m))

    def gentle(self, radius_m: float) -> BaseGeometry:
        """Return the side with its edge bent no tighter than a radius."""
        return self._gentle(0.0, radius_m)

    def _gentle(self, offset_m: float, radius_m: float) -> BaseGeometry:
        inside = self.area.buffer(-(offset_m + radius_m), quad_segs=_QUARTER)
        return inside.buffer(2 * radius_m, quad_segs=_QUARTER).buffer(-radius_m, quad_segs=_QUARTER)

    def _lines(self, area: BaseGeometry) -> list[Floats]:
        rings = [part.exterior for part in polygons_of(area)]
        if not rings:
            return []
        inside = shapely.line_merge(shapely.intersection(shapely.MultiLineString(rings), self.window))
        lines = [part for part in shapely.get_parts(inside) if part.length > _EPS_M]
        found: list[tuple[float, Floats]] = []
        for line in lines:
            points = shapely.get_coordinates(line)
            first, last = shapely.line_locate_point(self.along, shapely.points(points[[0, -1]]))
            found.append((min(first, last), points if first <= last else points[::-1]))
        return [points for _, points in sorted(found, key=lambda one: one[0])]


def sides_of(points: Floats, window: Polygon, margin_m: float) -> tuple[Side, Side]:
    """Return the ground left and right of a line, drawn on straight at both ends.

    Args:
        points: (N, 2) metres.
        window: where lines are wanted.
        margin_m: as far as the sides will be shrunk, at least.

    Raises:
        NoSide: the line crosses itself, or would.
    """
    around = shapely.union_all([window, LineString(points)]).envelope
    far_m = 2 * margin_m + around.length
    big = around.buffer(margin_m, join_style="mitre")
    line = LineString(drawn_on(points, far_m, far_m))
    parts = list(split(big, line).geoms) if line.is_simple else []
    if len(parts) != 2:
        raise NoSide
    middle = (points[0] + points[1]) / 2
    ux, uy = (points[1] - points[0]) / math.dist(points[0], points[1])
    left_place = shapely.Point(middle[0] - _EPS_M * uy, middle[1] + _EPS_M * ux)
    left, right = parts if parts[0].contains(left_place) else parts[::-1]
    along = line.intersection(big)
    return Side(left, window, along), Side(right, window, along)


def drawn_on(points: Floats, before_m: float, after_m: float) -> Floats:
    """Return a line made longer at its ends, straight on."""
    back, ahead = _end_direction(points[::-1]), _end_direction(points)
    return np.vstack([points[:1] + before_m * back, points, points[-1:] + after_m * ahead])


def cleaned(points: Floats) -> Floats:
    """Return a line without noise and double points; fewer than two points if nothing is left."""
    if len(points) < 2:
        return points
    line = shapely.simplify(LineString(points), NOISE_M)
    return distinct(shapely.get_coordinates(line))


def thinned(points: Floats, radius_m: float) -> Floats:
    """Return a line with no more points than its bends need."""
    for tolerance_m in (_THIN_M, min(_THIN_M, _THIN * radius_m)):
        found = distinct(shapely.get_coordinates(shapely.simplify(LineString(points), tolerance_m)))
        if is_gentle(found, radius_m):
            return found
    return distinct(points)


def distinct(points: Floats) -> Floats:
    """Return a line without points on top of the one before."""
    keep = np.append(True, np.hypot(*np.diff(points, axis=0).T) > _EPS_M)
    return np.asarray(points[keep], dtype=np.float64)


def is_gentle(points: Floats, radius_m: float) -> bool:
    """Say whether a line has no corner, and no stretch that turns more than a radius allows but for sampling."""
    if len(points) < 3:
        return True
    if np.abs(np.angle(np.exp(1j * np.diff(headings(points))))).max() > KINK_RAD:
        return False
    excess = turned_beyond(points, radius_m)
    return bool((excess - np.minimum.accumulate(excess)).max() <= SLACK_RAD)


def turned_beyond(points: Floats, radius_m: float) -> Floats:
    """Return, at the middle of each of the N-1 pieces, what a line has turned less what a radius allows, radians."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    turns = np.abs(np.angle(np.exp(1j * np.diff(headings(points)))))
    return np.asarray(np.append(0.0, np.cumsum(turns)) - (np.cumsum(lengths) - lengths / 2) / radius_m)


def furthest(lines: Sequence[Floats], others: Sequence[Floats], where: BaseGeometry) -> tuple[float, Floats | None]:
    """Return how far ``lines`` lie from ``others`` at most, of what is in ``where``, and the place."""
    if not lines or not others:
        return (0.0, None) if not lines else (math.inf, lines[0][0])
    inside = shapely.intersection(shapely.MultiLineString(list(lines)), where)
    places = shapely.get_coordinates(shapely.segmentize(inside, 0.5)) if not inside.is_empty else np.empty((0, 2))
    if not len(places):
        return 0.0, None
    distances = shapely.distance(shapely.points(places), shapely.MultiLineString(list(others)))
    worst = int(np.argmax(distances))
    return float(distances[worst]), places[worst]


def _end_direction(points: Floats) -> Floats:
    line = LineString(points)
    before = shapely.get_coordinates(line.interpolate(max(0.0, line.length - _END_M)))[0]
    step = points[-1] - before
    return np.asarray(step / math.hypot(*step), dtype=np.float64)

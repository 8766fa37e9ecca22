"""Ways over lanes: ground that a machine drives along, and on which it cannot turn round.

A way through ground on which a machine fits at any heading needs roads as wide as its diagonal. Here the outline is
tested pose by pose instead. A way is searched as far from the borders as the narrowest place lets it be, its corners
are rounded with the turning radius, and a corner that does not fit is driven wider.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry import Point, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import nearest_points

from hmi.planning.bent_way import BentWay
from hmi.planning.dubins import Pose
from hmi.planning.ground import bends_of, erode, polygons_of
from hmi.planning.links import Linker
from hmi.planning.plan import GENTLE_RAD, headings
from hmi.planning.polyline import distinct, length_m, part_of, pose_at
from hmi.planning.projection import Floats
from hmi.planning.ways import Ways

Place = tuple[float, float]

_LESS_M = (0.3, 0.6, 0.1, 1.0, 1.5, 0.01)  # nearer to the border than the narrowest place asks for
_JOIN_RADII = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)  # where a way is left for a pose beside it
_ROOMY_RADII = 4.0  # a way is begun so much away from a pose to which it will be joined
_GENTLE = 1.25  # radius of a gentle arc, over the reach of the outline
_SMOOTH_M = 0.1  # corners of a drawn curve nearer than this to their chord are none
_TOUCH_M = 1.5e-3
_CLOSE_M = 0.02  # the width of a lane is found to so much
_BESIDE_M = 1.0  # a place so much nearer to a border than the way is still joined to it
_DETOUR = 2.0  # no turn onto a way is longer than this many times the distance, and a circle


class Lanes:
    """Finds ways along lanes for the machine of a linker; places and poses in metres."""

    def __init__(self, linker: Linker) -> None:
        self._linker = linker
        self._ground = linker.ground
        self._machine = linker.machine
        self._radius = max(self._machine.turning_radius_m, 0.05)

    @property
    def _radii_m(self) -> list[float]:
        """Its tightest arc, and one on which a long machine swings its nose out less."""
        gentle_m = _GENTLE * self._machine.reach_m
        return [self._radius, gentle_m] if gentle_m > 1.1 * self._radius else [self._radius]

    @property
    def needed_m(self) -> float:
        """Width of the narrowest lane the machine drives on."""
        return self._machine.width_m + 2 * self._machine.margin_m

    def from_place(self, place: Place, end: Pose) -> list[Floats] | None:
        """Return polylines from a place, left at any heading, to a pose; ``None`` if there is no way."""
        return self._first(place, end[:2], None, end)

    def to_place(self, start: Pose, place: Place) -> list[Floats] | None:
        """Return polylines from a pose to a place, reached at any heading; ``None`` if there is no way."""
        return self._first(start[:2], place, start, None)

    def between(self, start: Pose, end: Pose) -> list[Floats] | None:
        """Return polylines between two poses; ``None`` if there is no way."""
        return self._first(start[:2], end[:2], start, end)

    def width_m(self, a: Place, b: Place) -> float:
        """Return how wide the ground between two places is where it is narrowest, 0 if nothing joins them.

        It is told no wider than the machine needs to turn on the spot.
        """
        low, high = 0.0, self._machine.reach_m + self._machine.margin_m
        while high - low > _CLOSE_M:
            middle = (low + high) / 2
            low, high = (middle, high) if self._joined(middle, a, b) is not None else (low, middle)
        return 2 * low

    def _first(self, a: Place, b: Place, start: Pose | None, end: Pose | None) -> list[Floats] | None:
        from_place = a if start is None else self._roomy(a)
        to_place = b if end is None else self._roomy(b)
        for way in self._ways(from_place, to_place):
            ends = [[a]] if start is None else [], [[b]] if end is None else []
            whole = distinct(np.vstack([*ends[0], way, *ends[1]]))
            for radius_m in self._radii_m if len(whole) > 1 else ():
                pieces = BentWay(self._linker, whole, radius_m).pieces()
                joined = None if pieces is None else self._joined_to(pieces, start, end)
                if joined is not None:
                    return joined
        return None

    def _roomy(self, place: Place) -> Place:
        """Return the nearest place at which the machine fits at any heading, the place itself if there is none near."""
        turning = self._ground.turning
        near = _nearest(turning, place) if not turning.is_empty else place
        return near if math.dist(near, place) <= _ROOMY_RADII * self._radius else place

    def _ways(self, a: Place, b: Place) -> Iterator[Floats]:
        """Yield cornered ways from a to b: those first that run beside a border only where they have to."""
        most_m, least_m = self.width_m(a, b) / 2, self.needed_m / 2
        far_m = [most_m - less_m for less_m in _LESS_M if most_m - less_m > least_m - _CLOSE_M]
        for is_roomy in (True, False):
            for from_border_m in far_m:
                area = self._joined(from_border_m, a, b, is_roomy=is_roomy)
                way = None if area is None else self._way(area, a, b)
                if way is not None:
                    yield way

    def _way(self, area: Polygon, a: Place, b: Place) -> Floats | None:
        corners = np.array(bends_of(area.simplify(_SMOOTH_M))).reshape(-1, 2)
        ends = np.array([_nearest(area, a), _nearest(area, b)])
        # a line from corner to corner cuts the bends that were smoothed
        free = area.buffer(_SMOOTH_M + _TOUCH_M, join_style="mitre")
        shapely.prepare(free)
        return Ways(free, self._ground.crop, corners).cheapest(ends)

    def _joined(self, from_border_m: float, a: Place, b: Place, *, is_roomy: bool = False) -> Polygon | None:
        """Return the ground so far from the borders that both places lie on or beside."""
        beside_m = 2 * from_border_m + _BESIDE_M
        area = erode(self._ground.allowed, from_border_m)
        if is_roomy:
            area = shapely.union_all([self._ground.turning, area.intersection(self._narrow)], grid_size=1e-3)
        for part in polygons_of(area):
            if part.distance(Point(a)) <= beside_m and part.distance(Point(b)) <= beside_m:
                return part
        return None

    @cached_property
    def _narrow(self) -> BaseGeometry:
        """The lanes and what lies around their mouths."""
        reach_m = self._machine.reach_m + self._machine.margin_m
        roomy = self._ground.turning.buffer(reach_m)
        return self._ground.allowed.difference(roomy).buffer(2 * reach_m, quad_segs=2)

    def _joined_to(self, pieces: list[Floats], start: Pose | None, end: Pose | None) -> list[Floats] | None:
        """Return a way that begins and ends at the poses that are given, ``None`` if they cannot be joined to it."""
        whole: list[Floats] | None = pieces
        if end is not None:
            whole = self._onto(pieces, end)
        if start is not None and whole is not None:
            whole = self._off(start, whole)
        return whole

    def _onto(self, pieces: list[Floats], end: Pose) -> list[Floats] | None:
        """Leave the last piece for a pose, the shortest way."""
        last, whole_m = pieces[-1], length_m(pieces[-1])
        found: list[tuple[float, list[Floats]]] = []
        for left_m in self._left_m(whole_m):
            stop = pose_at(last, whole_m - left_m)
            for turn in self._turns(stop, end):
                kept = part_of(last, 0.0, whole_m - left_m)
                found.append((sum(map(length_m, turn)) - left_m, [*pieces[:-1], *_fused(kept, turn)]))
        return min(found, key=lambda one: one[0])[1] if found else None

    def _off(self, start: Pose, pieces: list[Floats]) -> list[Floats] | None:
        """Join the first piece from a pose, the shortest way."""
        first, whole_m = pieces[0], length_m(pieces[0])
        found: list[tuple[float, list[Floats]]] = []
        for left_m in self._left_m(whole_m):
            stop = pose_at(first, left_m)
            for turn in self._turns(start, stop):
                kept = part_of(first, left_m, whole_m)
                found.append((sum(map(length_m, turn)) - left_m, [*turn[:-1], *_fused(turn[-1], [kept]), *pieces[1:]]))
        return min(found, key=lambda one: one[0])[1] if found else None

    def _left_m(self, whole_m: float) -> Iterator[float]:
        return (radii * self._radius for radii in _JOIN_RADII if radii * self._radius < whole_m)

    def _turns(self, start: Pose, end: Pose) -> Iterator[list[Floats]]:
        """Yield turns from one pose to the other that are no journey."""
        distance_m = float(np.hypot(end[0] - start[0], end[1] - start[1]))
        most_m = _DETOUR * distance_m + 2 * np.pi * self._radius
        turn = self._linker.curve(start, end, is_crop_free=False)
        turns = [turn] if turn is not None else None
        if turn is None and self._ground.can_turn_at(start[:2]):
            turns = self._linker.link(start, end)
        if turns and sum(map(length_m, turns)) <= most_m:
            yield turns


def _fused(before: Floats, after: list[Floats]) -> list[Floats]:
    """Join a piece to the one that leads to it; where they meet in a corner the machine turns on the spot."""
    if len(before) < 2 or len(after[0]) < 2:
        return after if len(before) < 2 else [before, *after[1:]]
    if abs(math.remainder(float(headings(after[0])[0] - headings(before)[-1]), 2 * math.pi)) > GENTLE_RAD:
        return [before, *after]
    return [distinct(np.vstack([before, after[0]])), *after[1:]]


def _nearest(area: BaseGeometry, place: Place) -> tuple[float, float]:
    near = nearest_points(area, Point(place))[0]
    return near.x, near.y

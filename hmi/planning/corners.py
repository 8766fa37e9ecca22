"""Corners of laps: worked to the tip by driving straight on and swinging around into the next side.

A lap rounds a corner with the turning radius, and outside its round edge a tip stays that the lap nearer to the
border left square. Driving straight on over the tip, a loop with the tool off, and straight on across the own
track work both sides to their ends. A machine that can turn on the spot does so where no loop fits.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from hmi.planning.dubins import Pose
from hmi.planning.headland import Lap, strips
from hmi.planning.links import Linker
from hmi.planning.plan import headings
from hmi.planning.polyline import distinct, length_m
from hmi.planning.projection import Floats

WORTH_M2 = 0.5  # a smaller tip is not worth the way of a loop
# a large field has many holes: a tip there is worked if it is that much of what a row as long as the detour works,
WORTH_SHARE = 0.6
WORTH_FIELD = 4e-4  # or that much of the field
_LEAST_RAD, _MOST_RAD = math.radians(30), math.radians(150)  # blunter leaves no tip; sharper ones have no end nearby
_BEND_RAD = math.radians(0.5)
_PIECE = 0.3  # of the radius: pieces of an arc are shorter, straight ones between two arcs longer
_WAY = 4.0  # a loop takes some ten radii; a way longer than this times radius and width together goes elsewhere


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A piece of a lap, (N, 2) points. Its tool is off in the loops."""

    points: Floats
    is_worked: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class _Corner:
    """Vertices ``first`` to ``last`` of a line turn by ``turn_rad``; its sides meet in ``tip``."""

    first: int
    last: int
    turn_rad: float
    tip: Floats
    before: Floats
    after: Floats


class Corners:
    """Finds what a corner of a lap is worth, and a way to work it that stays on the ground.

    Args:
        linker: its ground and machine count.
        laps: all laps of the field.
        others: ground that the rows work.
        wanted: ground to be treated.
        width_m: of one pass.
        may_pivot: turn on the spot where no loop fits, if the machine can.
    """

    def __init__(
        self,
        linker: Linker,
        laps: Sequence[Lap],
        others: BaseGeometry,
        wanted: BaseGeometry,
        width_m: float,
        *,
        may_pivot: bool,
    ) -> None:
        self._linker, self._others, self._wanted, self._width_m = linker, others, wanted, width_m
        self._may_pivot = may_pivot and linker.machine.can_pivot
        self._strips = dict(zip(map(id, laps), strips(list(laps), width_m), strict=True))
        self._radius_m = max(linker.machine.turning_radius_m, 0.05)

    def stretches(self, lap: Lap, points: Floats) -> list[Stretch]:
        """Return a lap's line, as it is driven, with a loop in each corner that is worth one."""
        near = [strip for other, strip in self._strips.items() if other != id(lap)]
        done: list[Stretch] = []
        begin, following = points[0], 1  # of what is left of the lap: where it begins, and its next vertex
        for corner in _corners(points, self._radius_m):
            found = self._worked_out(points, corner, near, is_inner=lap.is_inner)
            if found is None:
                continue
            end, loop, start = found
            side = np.vstack([begin, points[following : corner.first + 1], end])
            done += [Stretch(distinct(side)), Stretch(loop, is_worked=False)]
            is_beyond = np.dot(start - points[corner.last], corner.after) > 0  # beyond where the round corner ends
            begin, following = start, corner.last + int(is_beyond)
        done.append(Stretch(distinct(np.vstack([begin, points[following:]]))))
        worked = shapely.MultiLineString([one.points for one in done if one.is_worked])
        self._strips[id(lap)] = worked.buffer(self._width_m / 2, cap_style="flat")  # the next lap leaves no more tips
        return done

    def _worked_out(
        self, points: Floats, corner: _Corner, near: Sequence[BaseGeometry], *, is_inner: bool
    ) -> tuple[Floats, Floats, Floats] | None:
        """Return where the tool goes off, the way from there and where it goes on; ``None`` to round the corner."""
        slope = math.tan(abs(corner.turn_rad) / 2)
        half = self._width_m / 2
        # just far enough to meet the next side where it begins, on its outer edge, and the tip itself
        ahead = slope * math.cos(corner.turn_rad) + math.sin(abs(corner.turn_rad))
        end = corner.tip + half * max(slope, ahead) * corner.before
        start = corner.tip + half * min(slope, 1 / slope) * corner.after
        beyond = points[corner.last + 1]  # the end of the side, or of the lap
        if np.dot(beyond - start, corner.after) < 0.1:
            return None
        sides = [np.vstack([points[corner.first], end]), np.vstack([start, beyond])]
        gain_m2 = self._gain_m2(points, corner, sides, near)
        if gain_m2 < WORTH_M2:
            return None
        if not all(self._linker.ground.fits(side) for side in sides):
            return None
        loop = self._way(end, start, corner)
        if loop is None:
            return None
        detour_m = sum(map(length_m, (*sides, loop))) - length_m(points[corner.first : corner.last + 2])
        least_m2 = min(WORTH_SHARE * self._width_m * detour_m, WORTH_FIELD * self._wanted.area) if is_inner else 0.0
        return (end, loop, start) if gain_m2 >= least_m2 else None

    def _gain_m2(self, points: Floats, corner: _Corner, sides: Sequence[Floats], near: Sequence[BaseGeometry]) -> float:
        """Return how much more is worked when both sides are driven to their ends."""
        half = self._width_m / 2
        reach = 2 * (self._width_m + self._radius_m * math.tan(abs(corner.turn_rad) / 2))
        around = shapely.box(*(corner.tip - reach), *(corner.tip + reach))
        # one step back onto the straight sides, so that both shapes begin with the same edge
        rounded = shapely.LineString(points[corner.first - 1 : corner.last + 2])
        straight = shapely.MultiLineString([np.vstack([points[corner.first - 1], sides[0][1]]), sides[1]])
        new, old = (shapely.buffer(one, half, quad_segs=12, cap_style="flat") for one in (straight, rounded))
        free = shapely.intersection(self._wanted, around)
        taken = [one for one in (*near, self._others) if shapely.intersects(one, around)]
        free = free.difference(shapely.union_all(shapely.intersection(taken, around))) if taken else free
        return float(shapely.area(shapely.intersection(new, free)) - shapely.area(shapely.intersection(old, free)))

    def _way(self, end: Floats, start: Floats, corner: _Corner) -> Floats | None:
        """Return the way from the end of one side to the start of the next: a loop, else turned on the spot."""
        ground = self._linker.ground
        loop = self._linker.curve(_pose(end, corner.before), _pose(start, corner.after))
        if loop is not None and length_m(loop) <= _WAY * (self._radius_m + self._width_m):
            return loop
        across = np.vstack([end, start])
        can_turn = ground.can_turn_at(_place(end)) and ground.can_turn_at(_place(start))
        return across if self._may_pivot and can_turn and ground.fits(across) else None


def _corners(points: Floats, radius_m: float) -> Iterator[_Corner]:
    """Yield the bends of a line that begins and ends on straight pieces."""
    directions = headings(points)
    turns = np.angle(np.exp(1j * np.diff(directions)))  # at vertices 1 to N - 2
    lengths = np.hypot(*np.diff(points, axis=0).T)
    k = 1
    while k < len(points) - 1:
        last = k
        if abs(turns[k - 1]) > _BEND_RAD:
            while last + 1 < len(points) - 1 and lengths[last] < _PIECE * radius_m and turns[last] * turns[k - 1] > 0:
                last += 1
            turn = float(turns[k - 1 : last].sum())
            if _LEAST_RAD <= abs(turn) <= _MOST_RAD:
                yield _corner(points, k, last, turn)
        k = last + 1


def _corner(points: Floats, first: int, last: int, turn_rad: float) -> _Corner:
    before, after = _unit(points[first] - points[first - 1]), _unit(points[last + 1] - points[last])
    way = points[last] - points[first]
    ahead = (way[0] * after[1] - way[1] * after[0]) / (before[0] * after[1] - before[1] * after[0])
    return _Corner(first, last, turn_rad, points[first] + ahead * before, before, after)


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / math.hypot(*vector), dtype=np.float64)


def _pose(place: Floats, direction: Floats) -> Pose:
    return (*_place(place), math.atan2(direction[1], direction[0]))


def _place(place: Floats) -> tuple[float, float]:
    return float(place[0]), float(place[1])

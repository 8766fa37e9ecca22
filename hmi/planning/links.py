"""Ways between two poses: turns at the row ends, and longer links around holes and along headlands.

Tried in this order, the first that stays on the ground is taken: a Dubins turn after rolling out to a common
line, a Dubins turn from where the machine stands, a Dubins turn through the corners of the cheapest way,
and, for machines that can, the cheapest way with turns on the spot.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from hmi.planning import dubins
from hmi.planning.dubins import DubinsPath, Pose
from hmi.planning.ground import Ground
from hmi.planning.plan import GENTLE_RAD, headings
from hmi.planning.polyline import distinct, length_m
from hmi.planning.projection import Floats

STEP_M = 0.5  # distance of points on straight pieces does not matter to a robot; on arcs the angle rules
_MERGE_M = (3.0, 5.0, 8.0)  # how far ahead of a lap, in turning radii, the machine swings onto it


class Linker:
    """Finds ways on one ground for its machine."""

    def __init__(self, ground: Ground) -> None:
        self.ground = ground
        self.machine = ground.machine
        self._radius = max(ground.machine.turning_radius_m, 0.05)

    def link(self, start: Pose, end: Pose) -> list[Floats] | None:
        """Return smooth polylines from start to end, corners between them, or ``None`` if there is no way.

        No polyline at all (an empty list) means the machine is there already, up to a turn on the spot.
        """
        if math.hypot(end[0] - start[0], end[1] - start[1]) < 1e-3:
            return [] if self.machine.can_pivot or _turn(start[2], end[2]) < GENTLE_RAD else None
        smooth = self._rolled_out(start, end)
        if smooth is None:
            smooth = self.curve(start, end)
        if smooth is not None:
            return [smooth]
        way = self.ground.way(start[:2], end[:2])
        if way is None:
            return self._off_and_on(start, end)
        if length_m(way) > 4 * self._radius:
            rounded = self._rounded(start, way, end)
            if rounded is not None:
                return [rounded]
        return self._cornered(way) if self.machine.can_pivot else None

    def can_leave(self, pose: Pose) -> bool:
        """Say whether a lap that ends here can be left again."""
        return self.ground.can_turn_at(pose[:2]) or bool(self._swings(pose, is_joining=False))

    def curve(self, start: Pose, end: Pose, *, is_crop_free: bool = True) -> Floats | None:
        """Return the shortest Dubins turn between two poses that stays on the ground, ``None`` if there is none."""
        for path in self._hopeful(start, end):
            points = distinct(path.sample(2.0)[:, :2])
            if len(points) < 2:
                continue
            if self.ground.fits(points, is_crop_free=is_crop_free):
                return points
        return None

    def _rolled_out(self, start: Pose, end: Pose) -> Floats | None:
        """Turn into a row that runs the other way: roll out level with the longer of the two, then turn."""
        if _turn(start[2], end[2] + math.pi) > GENTLE_RAD:
            return None
        ux, uy = math.cos(start[2]), math.sin(start[2])
        ahead = (end[0] - start[0]) * ux + (end[1] - start[1]) * uy
        if abs(ahead) < 0.05:
            return None
        out, back = max(ahead, 0.0), max(-ahead, 0.0)
        from_pose = (start[0] + out * ux, start[1] + out * uy, start[2])
        to_pose = (end[0] - back * math.cos(end[2]), end[1] - back * math.sin(end[2]), end[2])
        for path in self._hopeful(from_pose, to_pose):
            points = distinct(np.vstack([start[:2], path.sample(2.0)[:, :2], end[:2]]))
            if self.ground.fits(points, is_crop_free=True):
                return points
        return None

    def _hopeful(self, start: Pose, end: Pose) -> Iterator[DubinsPath]:
        """Yield the Dubins paths, shortest first, whose middle is on the ground: of a turn that is the far end."""
        for path in dubins.candidates(start, end, self._radius):
            x, y, _ = path.at(path.length_m / 2)
            if self.ground.may_be_at((x, y)):
                yield path

    def _rounded(self, start: Pose, way: Floats, end: Pose) -> Floats | None:
        """Follow a way without stopping: Dubins paths between the middles of its pieces."""
        directions = headings(way)
        middles = [(*m, h) for m, h in zip((way[:-1] + way[1:]) / 2, directions, strict=True)]
        stops: list[Pose] = [start, *middles, end]
        pieces = []
        for a, b in pairwise(stops):
            piece = self.curve(a, b, is_crop_free=False)
            if piece is None or length_m(piece) > math.hypot(b[0] - a[0], b[1] - a[1]) * 1.5 + self._radius:
                return None
            pieces.append(piece)
        return distinct(np.vstack(pieces))

    def _cornered(self, way: Floats) -> list[Floats]:
        """Follow a way, rounding the corners that can be rounded and turning on the spot in the others."""
        directions = headings(way)
        middles = (way[:-1] + way[1:]) / 2
        done: list[Floats] = []
        current = [way[0]]
        for k in range(1, len(way) - 1):
            a: Pose = (*middles[k - 1], directions[k - 1])
            b: Pose = (*middles[k], directions[k])
            corner = self.curve(a, b, is_crop_free=False)
            if corner is not None and length_m(corner) < length_m(np.array([middles[k - 1], way[k], middles[k]])) + 0.1:
                current.extend(corner)
            elif _turn(directions[k - 1], directions[k]) <= GENTLE_RAD:
                current.append(way[k])
            else:
                done.append(distinct(np.array([*current, way[k]])))
                current = [way[k]]
        done.append(distinct(np.array([*current, way[-1]])))
        return [piece for piece in done if len(piece) > 1]

    def _off_and_on(self, start: Pose, end: Pose) -> list[Floats] | None:
        """Link places too near a border to turn: swing off the first lap, go, and swing onto the other."""
        off = [(start, None)] if self.ground.can_turn_at(start[:2]) else self._swings(start, is_joining=False)
        on = [(end, None)] if self.ground.can_turn_at(end[:2]) else self._swings(end, is_joining=True)
        for left, away in off:
            for joined, onto in on:
                if away is None and onto is None:
                    return None
                middle = self.link(left, joined)
                if middle is not None:
                    parts = [p for p in (away, *middle, onto) if p is not None]
                    return _fused(parts)
        return None

    def _swings(self, pose: Pose, *, is_joining: bool) -> list[tuple[Pose, Floats | None]]:
        """Return poses on turning ground from which a lap can be joined (or to which it can be left)."""
        found: list[tuple[Pose, Floats | None]] = []
        x, y, heading = pose
        sign = -1.0 if is_joining else 1.0
        shift = self.machine.reach_m + self.machine.margin_m + 0.1
        for ahead in _MERGE_M:
            for side in (1.0, -1.0):
                along, across = sign * ahead * self._radius, side * shift
                px = x + along * math.cos(heading) - across * math.sin(heading)
                py = y + along * math.sin(heading) + across * math.cos(heading)
                for bend in (0.0, side * sign * math.pi / 4, side * sign * math.pi / 2):
                    place: Pose = (px, py, heading + bend)
                    if not self.ground.can_turn_at(place[:2]):
                        continue
                    a, b = (place, pose) if is_joining else (pose, place)
                    points = self.curve(a, b, is_crop_free=False)
                    if points is not None and length_m(points) < 4 * math.hypot(px - x, py - y):
                        found.append((place, points))
                        break
        return found


def _fused(parts: list[Floats]) -> list[Floats]:
    """Join polylines that meet without a corner."""
    fused = [parts[0]]
    for part in parts[1:]:
        if _turn(float(headings(fused[-1])[-1]), float(headings(part)[0])) <= GENTLE_RAD:
            fused[-1] = distinct(np.vstack([fused[-1], part]))
        else:
            fused.append(part)
    return fused


def _turn(a: float, b: float) -> float:
    return abs(math.remainder(b - a, 2 * math.pi))

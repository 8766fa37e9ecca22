"""Shortest paths of bounded curvature between two poses, forwards and backwards.

Source: J. A. Reeds and L. A. Shepp, Optimal paths for a car that goes both forwards and backwards, 1990; section 8.
Lengths are signed and over the radius: negative ones are driven backwards. Each word of the paper stands for eight:
as it is, with the direction of driving exchanged, left and right exchanged, and each of these from the end to the
start.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from hmi.planning.dubins import Pose, along
from hmi.planning.plan import Drive
from hmi.planning.polyline import distinct

_QUARTER = math.pi / 2
_LEAST_PART = 1e-6  # shorter parts are rounding
_MIRRORED = {"L": "R", "R": "L", "S": "S"}

Part = tuple[str, float]
"""L, R or S, and its signed length over the radius."""


@dataclass(frozen=True, slots=True)
class ReedsSheppPath:
    """No to five parts, each an arc left (L) or right (R) or straight (S)."""

    start: Pose
    radius_m: float
    parts: tuple[Part, ...]

    @property
    def length_m(self) -> float:
        """Length of the whole path, forwards and backwards."""
        return sum(abs(part) for _, part in self.parts) * self.radius_m

    @property
    def drives_m(self) -> list[float]:
        """Signed lengths between the places where it stops to drive the other way."""
        groups = groupby((part for _, part in self.parts), key=lambda part: part < 0)
        return [sum(group) * self.radius_m for _, group in groups]

    def drives(self, step_m: float, step_rad: float = math.radians(8)) -> list[Drive]:
        """Return the path in pieces that are driven one way, points as ``DubinsPath.sample`` has them."""
        x, y, heading = 0.0, 0.0, self.start[2]
        found: list[Drive] = []
        for is_backward, parts in groupby(self.parts, key=lambda part: part[1] < 0):
            points = [np.array([[x, y]])]
            for kind, part in parts:
                span = abs(part) * self.radius_m / step_m
                count = max(1, math.ceil(max(span, abs(part) / step_rad) if kind != "S" else span))
                poses = along(kind, x, y, heading, part * np.arange(1, count + 1) / count)
                points.append(poses[:, :2])
                x, y, heading = poses[-1].tolist()
            places = np.concatenate(points) * self.radius_m + np.array(self.start[:2])
            line = distinct(places)
            if len(line) > 1:
                found.append(Drive(line, is_backward=is_backward))
        return found


def candidates(start: Pose, end: Pose, radius_m: float) -> list[ReedsSheppPath]:
    """Return every Reeds-Shepp word that joins two poses and turns no more than half a circle a part, shortest first.

    Raises:
        ValueError: the radius is not positive or a pose is not finite.
    """
    if not radius_m > 0 or not all(map(math.isfinite, (*start, *end, radius_m))):
        raise ValueError(f"no Reeds-Shepp path from {start} to {end} with radius {radius_m}")
    dx, dy = (end[0] - start[0]) / radius_m, (end[1] - start[1]) / radius_m
    cos, sin = math.cos(start[2]), math.sin(start[2])
    turn = math.remainder(end[2] - start[2], 2 * math.pi)
    found: dict[tuple[Part, ...], ReedsSheppPath] = {}
    for parts in _all_words(dx * cos + dy * sin, dy * cos - dx * sin, turn):
        kept = tuple((kind, part) for kind, part in parts if abs(part) > _LEAST_PART)
        found.setdefault(kept, ReedsSheppPath(start, radius_m, kept))
    return sorted(found.values(), key=lambda path: path.length_m)


def shortest(start: Pose, end: Pose, radius_m: float) -> ReedsSheppPath:
    """Return the shortest path; it has no parts where both poses are the same."""
    return candidates(start, end, radius_m)[0]


def _all_words(x: float, y: float, turn: float) -> Iterator[list[Part]]:
    """Yield the words to a pose in the frame of the start, lengths in radii."""
    cos, sin = math.cos(turn), math.sin(turn)
    ways = ((x, y, False), (x * cos + y * sin, x * sin - y * cos, True))
    for px, py, is_from_end in ways:
        for forth in (1.0, -1.0):
            for side in (1.0, -1.0):
                for word in _words(forth * px, side * py, forth * side * turn):
                    parts = [(kind if side > 0 else _MIRRORED[kind], forth * part) for kind, part in word]
                    yield parts[::-1] if is_from_end else parts


def _words(x: float, y: float, turn: float) -> Iterator[list[Part]]:
    yield from _one_way_first(x - math.sin(turn), y - 1 + math.cos(turn), turn)
    yield from _other_way_last(x + math.sin(turn), y - 1 - math.cos(turn), turn)


def _one_way_first(xi: float, eta: float, turn: float) -> Iterator[list[Part]]:
    """Yield the words of formulas 8.1, 8.3, 8.4 and 8.9, which end in a left arc as they begin."""
    rho, theta = math.hypot(xi, eta), math.atan2(eta, xi)
    yield [("L", _wrap(theta)), ("S", rho), ("L", _wrap(turn - theta))]
    if rho <= 4:
        u = -2 * math.asin(rho / 4)
        t = _wrap(theta + u / 2 + math.pi)
        yield [("L", t), ("R", u), ("L", _wrap(turn - t + u))]
    if rho >= 2:
        r = math.sqrt(rho * rho - 4)
        t = _wrap(theta + math.atan2(r, -2))
        yield [("L", t), ("R", -_QUARTER), ("S", 2 - r), ("L", _wrap(turn - _QUARTER - t))]


def _other_way_last(xi: float, eta: float, turn: float) -> Iterator[list[Part]]:
    """Yield the words of formulas 8.2, 8.7, 8.8, 8.10 and 8.11, which end in a right arc."""
    rho, theta = math.hypot(xi, eta), math.atan2(eta, xi)
    if rho >= 2:
        u = math.sqrt(rho * rho - 4)
        t = _wrap(theta + math.atan2(2, u))
        yield [("L", t), ("S", u), ("R", _wrap(t - turn))]
        t = _wrap(math.atan2(xi, -eta))
        yield [("L", t), ("R", -_QUARTER), ("S", 2 - rho), ("R", _wrap(t + _QUARTER - turn))]
        s = 4 - u
        t = _wrap(math.atan2((4 - s) * xi - 2 * eta, -2 * xi + (s - 4) * eta))
        yield [("L", t), ("R", -_QUARTER), ("S", s), ("L", -_QUARTER), ("R", _wrap(t - turn))]
    if (near := (2 + rho) / 4) <= 1:
        u = math.acos(near)
        t, v = _outer_arcs(u, -u, xi, eta, turn)
        yield [("L", t), ("R", u), ("L", -u), ("R", v)]
    if 0 <= (far := (20 - rho * rho) / 16) <= 1:
        u = -math.acos(far)
        t, v = _outer_arcs(u, u, xi, eta, turn)
        yield [("L", t), ("R", u), ("L", u), ("R", v)]


def _outer_arcs(u: float, v: float, xi: float, eta: float, turn: float) -> tuple[float, float]:
    """Return the first and the last of four arcs whose middle ones are known."""
    delta = _wrap(u - v)
    a, b = math.sin(u) - math.sin(delta), math.cos(u) - math.cos(delta) - 1
    t = math.atan2(eta * a - xi * b, xi * a + eta * b)
    if 2 * (math.cos(delta) - math.cos(v) - math.cos(u)) + 3 < 0:
        t += math.pi
    t = _wrap(t)
    return t, _wrap(t - u + v - turn)


def _wrap(angle: float) -> float:
    return math.remainder(angle, 2 * math.pi)

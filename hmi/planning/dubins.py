"""Shortest paths of bounded curvature between two poses, forward only.

Source: L. E. Dubins, 1957; the closed forms follow Shkel and Lumelsky, 2001.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hmi.planning.projection import Floats

Pose = tuple[float, float, float]
"""x and y in metres, heading in radians, 0 east, counter-clockwise."""

_TAU = 2 * math.pi
WORDS = ("LSL", "RSR", "LSR", "RSL", "RLR", "LRL")


@dataclass(frozen=True, slots=True)
class DubinsPath:
    """Three pieces, each an arc left (L) or right (R) or straight (S). ``parts`` are lengths over the radius."""

    start: Pose
    radius_m: float
    word: str
    parts: tuple[float, float, float]

    @property
    def length_m(self) -> float:
        """Length of the whole path."""
        return sum(self.parts) * self.radius_m

    def at(self, s_m: float) -> Pose:
        """Return the pose ``s_m`` metres from the start, clamped to the path."""
        left = min(max(s_m, 0.0), self.length_m) / self.radius_m
        x, y, heading = 0.0, 0.0, self.start[2]
        for kind, part in zip(self.word, self.parts, strict=True):
            step = min(left, part)
            x, y, heading = _advance(kind, x, y, heading, step)
            left -= step
            if left <= 0:
                break
        return self.start[0] + x * self.radius_m, self.start[1] + y * self.radius_m, heading

    def sample(self, step_m: float, step_rad: float = math.radians(8)) -> Floats:
        """Return (N, 3) poses no further apart than ``step_m``, on arcs no more than ``step_rad`` apart."""
        x, y, heading = 0.0, 0.0, self.start[2]
        pieces = [np.array([[x, y, heading]])]
        for kind, part in zip(self.word, self.parts, strict=True):
            if part <= 1e-9:
                continue
            span = part * self.radius_m / step_m
            count = max(1, math.ceil(max(span, part / step_rad) if kind != "S" else span))
            pieces.append(along(kind, x, y, heading, part * np.arange(1, count + 1) / count))
            x, y, heading = _advance(kind, x, y, heading, part)
        poses = np.concatenate(pieces)
        poses[:, :2] = poses[:, :2] * self.radius_m + np.array(self.start[:2])
        return poses


def shortest(start: Pose, end: Pose, radius_m: float) -> DubinsPath:
    """Return the shortest path from ``start`` to ``end`` turning no tighter than ``radius_m``."""
    return min(candidates(start, end, radius_m), key=lambda path: path.length_m)


def candidates(start: Pose, end: Pose, radius_m: float) -> list[DubinsPath]:
    """Return every Dubins word that joins the two poses, shortest first.

    Raises:
        ValueError: the radius is not positive or a pose is not finite.
    """
    if not radius_m > 0 or not all(map(math.isfinite, (*start, *end, radius_m))):
        raise ValueError(f"no Dubins path from {start} to {end} with radius {radius_m}")
    dx, dy = (end[0] - start[0]) / radius_m, (end[1] - start[1]) / radius_m
    d = math.hypot(dx, dy)
    bearing = math.atan2(dy, dx) if d > 0 else 0.0
    found = [
        DubinsPath(start, radius_m, word, parts)
        for word, parts in _words(d, _wrap(start[2] - bearing), _wrap(end[2] - bearing))
    ]
    return sorted(found, key=lambda path: path.length_m)


def _words(d: float, a: float, b: float) -> Iterator[tuple[str, tuple[float, float, float]]]:
    """Yield the words that exist for distance ``d`` (in radii) and headings ``a``, ``b`` to the joining line."""
    sa, ca, sb, cb, cab = math.sin(a), math.cos(a), math.sin(b), math.cos(b), math.cos(a - b)
    if (p2 := 2 + d * d - 2 * cab + 2 * d * (sa - sb)) >= 0:
        t = math.atan2(cb - ca, d + sa - sb)
        yield "LSL", (_wrap(t - a), math.sqrt(p2), _wrap(b - t))
    if (p2 := 2 + d * d - 2 * cab + 2 * d * (sb - sa)) >= 0:
        t = math.atan2(ca - cb, d - sa + sb)
        yield "RSR", (_wrap(a - t), math.sqrt(p2), _wrap(t - b))
    if (p2 := d * d - 2 + 2 * cab + 2 * d * (sa + sb)) >= 0:
        p = math.sqrt(p2)
        t = math.atan2(-ca - cb, d + sa + sb) - math.atan2(-2.0, p)
        yield "LSR", (_wrap(t - a), p, _wrap(t - b))
    if (p2 := d * d - 2 + 2 * cab - 2 * d * (sa + sb)) >= 0:
        p = math.sqrt(p2)
        t = math.atan2(ca + cb, d - sa - sb) - math.atan2(2.0, p)
        yield "RSL", (_wrap(a - t), p, _wrap(b - t))
    if abs(c := (6 - d * d + 2 * cab + 2 * d * (sa - sb)) / 8) <= 1:
        p = _wrap(_TAU - math.acos(c))
        t = _wrap(a - math.atan2(ca - cb, d - sa + sb) + p / 2)
        yield "RLR", (t, p, _wrap(a - b - t + p))
    if abs(c := (6 - d * d + 2 * cab + 2 * d * (sb - sa)) / 8) <= 1:
        p = _wrap(_TAU - math.acos(c))
        t = _wrap(-a - math.atan2(ca - cb, d + sa - sb) + p / 2)
        yield "LRL", (t, p, _wrap(b - a - t + p))


def _wrap(angle: float) -> float:
    """Return the angle in [0, 2 pi); a full turn that is only rounding becomes 0."""
    wrapped = angle % _TAU
    return 0.0 if _TAU - wrapped < 1e-9 else wrapped


def _advance(kind: str, x: float, y: float, heading: float, part: float) -> Pose:
    """Move ``part`` along a unit-radius piece."""
    if kind == "S":
        return x + part * math.cos(heading), y + part * math.sin(heading), heading
    if kind == "L":
        turned = heading + part
        return x + math.sin(turned) - math.sin(heading), y - math.cos(turned) + math.cos(heading), turned
    turned = heading - part
    return x - math.sin(turned) + math.sin(heading), y + math.cos(turned) - math.cos(heading), turned


def along(kind: str, x: float, y: float, heading: float, parts: Floats) -> Floats:
    """Return the (N, 3) poses at N lengths of a unit-radius piece; negative ones lie behind its start."""
    if kind == "S":
        return np.column_stack([x + parts * math.cos(heading), y + parts * math.sin(heading), parts * 0 + heading])
    sign = 1.0 if kind == "L" else -1.0
    turned = heading + sign * parts
    east = x + sign * (np.sin(turned) - math.sin(heading))
    north = y - sign * (np.cos(turned) - math.cos(heading))
    return np.column_stack([east, north, turned])

"""Feet of things on the ground, as rings of ENU points."""

from __future__ import annotations

import math

from backend_clients.simulator.cameras.scene import Point


def disc(x_m: float, y_m: float, radius_m: float, many: int = 14) -> list[Point]:
    """Return a circle as a ring."""
    return [
        (x_m + radius_m * math.cos(2 * math.pi * k / many), y_m + radius_m * math.sin(2 * math.pi * k / many))
        for k in range(many)
    ]


def oblong(
    x_m: float, y_m: float, theta_rad: float, long_m: float, wide_m: float, offset: Point = (0, 0)
) -> list[Point]:
    """Return a rectangle turned by ``theta_rad``; ``offset`` is its middle, forward and left of the place."""
    cos, sin = math.cos(theta_rad), math.sin(theta_rad)
    corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    found = []
    for a, b in corners:
        f, s = offset[0] + a * long_m / 2, offset[1] + b * wide_m / 2
        found.append((x_m + f * cos - s * sin, y_m + f * sin + s * cos))
    return found

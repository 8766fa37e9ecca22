"""The simple shapes of URDF as triangles, flat shaded: every corner belongs to one triangle."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hmi.twin.model import Box, Cylinder, Sphere, Vector
from hmi.twin.rotation import from_rpy

Floats = NDArray[np.float32]
SIDES = 18  # of a cylinder
RINGS = 10  # of a ball


def triangles_of(shape: Box | Cylinder | Sphere) -> Floats:
    """Return (3N, 3) corners in metres, three to a triangle, counter-clockwise seen from outside."""
    match shape:
        case Box():
            return _box(shape.size)
        case Cylinder():
            return _cylinder(shape.radius, shape.length)
        case Sphere():
            return _sphere(shape.radius)


def placed(corners: Floats, xyz: Vector, rpy: Vector) -> Floats:
    """Return corners in the link's frame."""
    return np.asarray(corners @ matrix(from_rpy(rpy)).T + np.asarray(xyz), dtype=np.float32)


def matrix(wxyz: tuple[float, float, float, float]) -> NDArray[np.float64]:
    """Return the 3 x 3 matrix of a unit quaternion."""
    w, x, y, z = wxyz
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def _box(size: Vector) -> Floats:
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    order = [index for a, b, c, d in sides for index in (a, b, c, a, c, d)]
    return np.asarray(corners[order], dtype=np.float32)


def _cylinder(radius: float, length: float) -> Floats:
    angles = np.linspace(0, 2 * math.pi, SIDES, endpoint=False)
    low = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(SIDES, -length / 2)])
    high = low + np.array((0, 0, length))
    next_low, next_high = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    bottom, top = np.tile([0, 0, -length / 2], (SIDES, 1)), np.tile([0, 0, length / 2], (SIDES, 1))
    faces = [low, next_low, next_high, low, next_high, high, top, high, next_high, bottom, next_low, low]
    return np.asarray(np.stack(faces, axis=1).reshape(-1, 3), dtype=np.float32)


def _sphere(radius: float) -> Floats:
    heights = np.linspace(-math.pi / 2, math.pi / 2, RINGS + 1)
    angles = np.linspace(0, 2 * math.pi, SIDES + 1)
    grid = radius * np.stack(
        [
            np.cos(heights)[:, None] * np.cos(angles)[None, :],
            np.cos(heights)[:, None] * np.sin(angles)[None, :],
            np.repeat(np.sin(heights)[:, None], SIDES + 1, axis=1),
        ],
        axis=-1,
    )
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.asarray(np.stack([a, b, c, a, c, d], axis=2).reshape(-1, 3), dtype=np.float32)

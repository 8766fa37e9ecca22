"""Draws what stands on the ground: extruded feet with shaded walls, and flat marks on the ground."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from PIL import ImageDraw

from backend_clients.simulator.cameras.eye import Eye, Floats
from backend_clients.simulator.cameras.scene import Point

Colour = tuple[int, int, int]
SUN = (0.55, 0.35)  # where the light comes from, for shading only
MIN_PX = 1.2
CLOSE_M = 0.35


def ring3(ring: Sequence[Point], z_m: float) -> Floats:
    """Return a ring at a height, shape (N, 3)."""
    flat = np.asarray(ring, dtype=np.float64)
    return np.column_stack((flat, np.full(len(flat), z_m)))


def block(
    draw: ImageDraw.ImageDraw, eye: Eye, ring: Sequence[Point], low_m: float, high_m: float, wall: Colour, roof: Colour
) -> None:
    """Draw an upright body on a foot: the walls that face the camera, far ones first, then the top."""
    foot = list(ring) if _area(ring) > 0 else list(ring)[::-1]
    walls = []
    for a, b in zip(foot, foot[1:] + foot[:1], strict=True):
        nx, ny = b[1] - a[1], a[0] - b[0]
        if nx * (eye.x_m - a[0]) + ny * (eye.y_m - a[1]) <= 0:
            continue
        light = 0.72 + 0.28 * (nx * SUN[0] + ny * SUN[1]) / (math.hypot(nx, ny) or 1.0)
        walls.append((-math.dist((eye.x_m, eye.y_m), ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)), a, b, light))
    for _, a, b, light in sorted(walls):
        face = np.array([(*a, low_m), (*b, low_m), (*b, high_m), (*a, high_m)])
        fill(draw, eye, face, shaded(wall, light))
    if eye.z_m > high_m:
        fill(draw, eye, ring3(foot, high_m), roof)


def fill(draw: ImageDraw.ImageDraw, eye: Eye, ring: Floats, colour: Colour | tuple[int, int, int, int]) -> None:
    """Fill a ring in space, shape (N, 3)."""
    outline = eye.outline(ring)
    if len(outline) >= 3 and _is_worth(outline, eye):
        draw.polygon(outline, fill=colour)


def beam(
    draw: ImageDraw.ImageDraw, eye: Eye, a: Sequence[float], b: Sequence[float], wide_m: float, colour: Colour
) -> None:
    """Draw a bar between two places, lighter along its upper side; what is behind the camera is cut off."""
    near, far = eye.seen(np.array([a, b], dtype=np.float64))
    if near[2] < CLOSE_M and far[2] < CLOSE_M:
        return
    if near[2] < CLOSE_M:
        near = near + (far - near) * ((CLOSE_M - near[2]) / (far[2] - near[2]))
    elif far[2] < CLOSE_M:
        far = far + (near - far) * ((CLOSE_M - far[2]) / (near[2] - far[2]))
    (x0, y0, w0), (x1, y1, w1) = (_bar_end(eye, one, wide_m) for one in (near, far))
    long = math.hypot(x1 - x0, y1 - y0) or 1.0
    nx, ny = -(y1 - y0) / long, (x1 - x0) / long
    if ny > 0:
        nx, ny = -nx, -ny

    def side(share: float) -> list[tuple[float, float]]:
        return [(x0 + nx * w0 * share, y0 + ny * w0 * share), (x1 + nx * w1 * share, y1 + ny * w1 * share)]

    draw.polygon(side(1) + side(-1)[::-1], fill=shaded(colour, 0.66))
    draw.polygon(side(1) + side(0.1)[::-1], fill=colour)
    draw.line(side(1), fill=shaded(colour, 1.2), width=1)


def _bar_end(eye: Eye, seen: Floats, wide_m: float) -> tuple[float, float, float]:
    """Return where an end in camera axes is in the picture, and half its width in pixels."""
    scale = eye.focal_px / float(seen[2])
    u0, v0 = eye.middle
    return u0 + float(seen[0]) * scale, v0 - float(seen[1]) * scale, max(wide_m * scale / 2, 1.0)


def shaded(colour: Colour, share: float) -> Colour:
    """Return a colour in more or less light."""
    return tuple(min(round(c * share), 255) for c in colour)  # type: ignore[return-value]


def _is_worth(outline: list[tuple[float, float]], eye: Eye) -> bool:
    xs, ys = [p[0] for p in outline], [p[1] for p in outline]
    is_in = max(xs) >= 0 and min(xs) <= eye.width_px and max(ys) >= 0 and min(ys) <= eye.height_px
    return is_in and (max(xs) - min(xs) >= MIN_PX or max(ys) - min(ys) >= MIN_PX)


def _area(ring: Sequence[Point]) -> float:
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)) / 2

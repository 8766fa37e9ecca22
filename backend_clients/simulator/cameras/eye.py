"""A pinhole camera without roll over a flat world: from ENU metres to pixels, and from pixel rows to the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
NEAREST_M = 0.12
MOST_PX = 3e4


@dataclass(frozen=True, slots=True)
class Eye:
    """Where a camera is and how it looks.

    Args:
        x_m, y_m, z_m: ENU, height above the ground.
        yaw_rad: ENU, 0 is east.
        pitch_rad: above the horizon; -pi/2 looks straight down.
        width_px, height_px, focal_px: of the picture.
    """

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    pitch_rad: float
    width_px: int
    height_px: int
    focal_px: float
    turn: Floats = field(init=False, repr=False, compare=False)
    place: Floats = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        cp, sp = math.cos(self.pitch_rad), math.sin(self.pitch_rad)
        cy, sy = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        turn = np.array(((sy, -sp * cy, cp * cy), (-cy, -sp * sy, cp * sy), (0.0, cp, sp)))
        object.__setattr__(self, "turn", turn)
        object.__setattr__(self, "place", np.array((self.x_m, self.y_m, self.z_m)))

    @property
    def middle(self) -> tuple[float, float]:
        """The pixel it looks at."""
        return self.width_px / 2, self.height_px / 2

    def seen(self, points: Floats) -> Floats:
        """Return ENU points, shape (N, 3), in the camera's axes: right, up, ahead."""
        found: Floats = (points - self.place) @ self.turn
        return found

    def project(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Return u, v and depth of points, shape (N, 3); what is behind has a depth below ``NEAREST_M``."""
        seen = self.seen(points)
        depth = seen[:, 2]
        scale = self.focal_px / np.where(np.abs(depth) < 1e-9, 1e-9, depth)
        u0, v0 = self.middle
        return u0 + seen[:, 0] * scale, v0 - seen[:, 1] * scale, depth

    def ground_rows(self, plane_m: float = 0.0) -> tuple[Floats, Floats]:
        """Return for each pixel row how far its rays go until the plane, and how far ahead that is per unit.

        Rows that never meet the plane have ``inf``.
        """
        s = (np.arange(self.height_px, dtype=np.float64) + 0.5 - self.middle[1]) / self.focal_px
        falls = s * math.cos(self.pitch_rad) - math.sin(self.pitch_rad)
        ahead = math.cos(self.pitch_rad) + s * math.sin(self.pitch_rad)
        reach: Floats = np.where(falls > 1e-6, (self.z_m - plane_m) / np.maximum(falls, 1e-6), np.inf)
        return reach, ahead

    def outline(self, ring: Floats) -> list[tuple[float, float]]:
        """Return a ring, shape (N, 3), in pixels, cut off at the camera; empty if all of it is behind."""
        seen = self.seen(ring)
        is_ahead = seen[:, 2] >= NEAREST_M
        if not is_ahead.all():
            if not is_ahead.any():
                return []
            seen = _cut(seen)
        u0, v0 = self.middle
        scale = self.focal_px / seen[:, 2]
        # a drawing library takes no numbers without end
        u = np.clip(u0 + seen[:, 0] * scale, -MOST_PX, MOST_PX)
        v = np.clip(v0 - seen[:, 1] * scale, -MOST_PX, MOST_PX)
        return list(zip(u.tolist(), v.tolist(), strict=True))


def _cut(ring: Floats) -> Floats:
    """Return the part of a ring in camera axes that is in front (Sutherland and Hodgman)."""
    corners = ring.tolist()
    kept: list[list[float]] = []
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        if a[2] >= NEAREST_M:
            kept.append(a)
        if (a[2] >= NEAREST_M) != (b[2] >= NEAREST_M):
            t = (NEAREST_M - a[2]) / (b[2] - a[2])
            kept.append([p + t * (q - p) for p, q in zip(a, b, strict=True)])
    return np.array(kept)

"""The ground the simulated machines stand on: gentle waves, the same at every run."""

from __future__ import annotations

import math

WAVES = ((0.11, 23.0, 0.4), (0.06, 9.0, 1.9), (0.03, 3.7, 4.1))
"""Height in metres, length in metres, direction in radians."""


def height_m(x_m: float, y_m: float) -> float:
    """Return how high the ground is at a place of the ENU frame."""
    return sum(
        high * math.sin(2 * math.pi * (x_m * math.cos(turn) + y_m * math.sin(turn)) / length)
        for high, length, turn in WAVES
    )


def tilt_rad(x_m: float, y_m: float, span_m: float = 2.0) -> float:
    """Return how much a machine of ``span_m`` leans there."""
    east = (height_m(x_m + span_m / 2, y_m) - height_m(x_m - span_m / 2, y_m)) / span_m
    north = (height_m(x_m, y_m + span_m / 2) - height_m(x_m, y_m - span_m / 2)) / span_m
    return math.atan(math.hypot(east, north))

"""Lines for rows to follow: waves, and random guide lines over a field."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st
from shapely.geometry import Polygon

from hmi.planning.projection import Floats
from hmi.planning.recorded import CropRow


def wave(left_m: float, right_m: float, y_m: float, *, high_m: float = 8.0, long_m: float = 30.0) -> Floats:
    """Return a line from left to right that waves gently: its tightest radius is ``long_m ** 2 / high_m``."""
    x = np.arange(left_m, right_m + 1e-6, 2.0)
    return np.column_stack([x, y_m + high_m * np.sin(x / long_m)])


def waves(count: int, spacing_m: float, left_m: float = -5.0, right_m: float = 125.0) -> list[CropRow]:
    """Return recorded rows one above the other."""
    return [CropRow(f"row {k + 1}", wave(left_m, right_m, 5.0 + k * spacing_m)) for k in range(count)]


@st.composite
def guides(draw: st.DrawFn, field: Polygon, least_radius_m: float) -> Floats:
    """Draw a line through the middle of a field that bends no tighter than a radius."""
    left, low, right, high = field.bounds
    step = 1.2 * math.hypot(right - left, high - low) / 24
    radius = draw(st.floats(least_radius_m, 20 * least_radius_m))
    heading = draw(st.floats(0, math.pi))
    points = [(0.0, 0.0)]
    for bend in (draw(st.floats(-1, 1)) for _ in range(4)):
        for _ in range(6):
            heading += step / radius * bend
            points.append((points[-1][0] + step * math.cos(heading), points[-1][1] + step * math.sin(heading)))
    found = np.array(points)
    return np.asarray(found - found.mean(axis=0) + [(left + right) / 2, (low + high) / 2])

"""Strips of nobody's land between two areas."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from hmi.mapping.ground import GRID_M, Shape, areas_in, polygons_in, sound

SLIVER_M = 0.5  # wider is a path someone may have meant
TOUCH_M = 1e-3


def strips_between(a: Shape, b: Shape, width_m: float = SLIVER_M) -> list[Polygon]:
    """Return what lies between two sound areas and is narrower than ``width_m``, largest first; metres."""
    region = shapely.box(*_common(shapely.bounds(a), shapely.bounds(b), width_m))
    near = areas_in(shapely.intersection(shapely.union(a, b), region))
    reach_m = width_m / 2
    closed = sound(near.buffer(reach_m, join_style="mitre").buffer(-reach_m, join_style="mitre"))
    strips = polygons_in(shapely.difference(closed, near, grid_size=GRID_M))
    return [strip for strip in strips if strip.distance(a) < TOUCH_M and strip.distance(b) < TOUCH_M]


def _common(a: NDArray[np.float64], b: NDArray[np.float64], width_m: float) -> tuple[float, float, float, float]:
    low, high = np.maximum(a[:2], b[:2]) - 2 * width_m, np.minimum(a[2:], b[2:]) + 2 * width_m
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])

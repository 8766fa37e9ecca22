"""Along and across the rows of a field, also of rows along a curve.

A curve is told near one place: by its direction and its bend there. Further than ``BEND_M`` it goes on straight.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backend_clients.simulator.cameras.scene import Rows

Floats = NDArray[np.float64]
Some = NDArray[np.floating[Any]]  # what comes in 32 bits goes out in 32 bits
BEND_M = 25.0
MOST_STRETCH = 0.5  # neighbouring rows of a curve are this much longer or shorter at the most
ROUNDS = 4  # of coming back from along and across; the bend is small


def straightened(ahead: Some, left: Some, bend_1pm: float, across_m: float) -> tuple[Some, Some]:
    """Return how far places lie along and across bent rows; ``across_m``: the place itself, across its rows."""
    near = np.clip(ahead, -BEND_M, BEND_M)
    over = left - bend_1pm * near * (ahead - near / 2)
    # rows on the inner side of a curve are shorter, and what is on them is told by the first row's length
    along = ahead * (1 + bend_1pm * across_m) * (1 + np.clip(bend_1pm * over, -MOST_STRETCH, MOST_STRETCH))
    return along, over


def to_field(rows: Rows, points: Floats) -> Floats:
    """Return ENU points, shape (N, 2), in the frame of a field."""
    cos, sin = math.cos(rows.bearing_rad), math.sin(rows.bearing_rad)
    away = np.asarray(points, dtype=np.float64) - rows.anchor
    ahead: Some
    left: Some
    ahead, left = away[:, 0] * cos + away[:, 1] * sin, away[:, 1] * cos - away[:, 0] * sin
    if rows.bend_1pm:
        ahead, left = straightened(ahead, left, rows.bend_1pm, rows.at[1])
    return np.column_stack((ahead + rows.at[0], left + rows.at[1]))


def from_field(rows: Rows, points: Floats) -> Floats:
    """Return points of a field's frame, shape (N, 2), in ENU."""
    cos, sin = math.cos(rows.bearing_rad), math.sin(rows.bearing_rad)
    along, across = points[:, 0] - rows.at[0], points[:, 1] - rows.at[1]
    ahead: Some = along
    left: Some = across
    if rows.bend_1pm:
        for _ in range(ROUNDS):
            found, over = straightened(ahead, left, rows.bend_1pm, rows.at[1])
            ahead, left = ahead + along - found, left + across - over
    x = rows.anchor[0] + ahead * cos - left * sin
    y = rows.anchor[1] + ahead * sin + left * cos
    return np.column_stack((x, y))

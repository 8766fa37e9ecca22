"""A dashed ring on the ground: how far people must stay away."""

from __future__ import annotations

import math

import numpy as np
import viser

DASH_M = 0.6
INK = (44, 52, 56)


def draw_ring(scene: viser.SceneApi, name: str, radius_m: float) -> None:
    """Draw a ring around the frame it hangs on, or replace it; none for no radius."""
    if radius_m <= 0:
        scene.remove_by_name(name)
        return
    dashes = max(12, min(180, round(math.pi * radius_m / DASH_M)))
    angles = np.linspace(0, 2 * math.pi, 2 * dashes, endpoint=False)
    points = np.column_stack([radius_m * np.cos(angles), radius_m * np.sin(angles), np.full(2 * dashes, 0.02)])
    scene.add_line_segments(
        name, points.reshape(-1, 2, 3).astype(np.float32), colors=INK, thickness=2.0, thickness_units="screen"
    )

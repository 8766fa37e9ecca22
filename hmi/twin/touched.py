"""The place a person touched: a ring, a line from the robot, a pole up to where a tool would go."""

from __future__ import annotations

import numpy as np
import viser

from hmi.twin.marks import RING, marks_of
from hmi.twin.model import Vector

FRAME = "/touched"
INK = (16, 20, 22)
BALL_M = 0.08


def draw_touched(
    scene: viser.SceneApi, place: tuple[float, float] | None, base: Vector | None, height_m: float = 0.0
) -> None:
    """Draw the mark, move it, or take it away for ``None``; ``height_m`` is that of the tool above the ground."""
    if place is None:
        if scene.get_handle_by_name(FRAME) is not None:
            scene.remove_by_name(FRAME)
        return
    corners, faces = marks_of(RING["current"])
    scene.add_frame(FRAME, show_axes=False)
    scene.add_mesh_simple(f"{FRAME}/ring", corners, faces, color=INK, position=(*place, 0.04), side="double")
    if height_m > 0:
        pole = np.asarray([[(*place, 0.04), (*place, height_m)]], np.float32)
        scene.add_line_segments(f"{FRAME}/pole", pole, colors=INK, thickness=2.0, thickness_units="screen")
        scene.add_icosphere(f"{FRAME}/end", radius=BALL_M, color=INK, position=(*place, height_m))
        scene.add_label(
            f"{FRAME}/text", f"{height_m:.1f} m", position=(*place, height_m + 0.15), anchor="bottom-center"
        )
    else:
        for part in ("pole", "end", "text"):
            scene.remove_by_name(f"{FRAME}/{part}")
    if base is not None:
        line = np.asarray([[(base[0], base[1], 0.04), (*place, 0.04)]], np.float32)
        scene.add_line_segments(f"{FRAME}/line", line, colors=INK, thickness=2.0, thickness_units="screen")

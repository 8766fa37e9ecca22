"""The place a person touched: a ring on the ground and a line from the robot, before anything is sent there."""

from __future__ import annotations

import numpy as np
import viser

from hmi.twin.marks import RING, marks_of
from hmi.twin.model import Vector

FRAME = "/touched"
INK = (16, 20, 22)


def draw_touched(scene: viser.SceneApi, place: tuple[float, float] | None, base: Vector | None) -> None:
    """Draw the mark, move it, or take it away for ``None``."""
    if place is None:
        if scene.get_handle_by_name(FRAME) is not None:
            scene.remove_by_name(FRAME)
        return
    corners, faces = marks_of(RING["current"])
    scene.add_frame(FRAME, show_axes=False)
    scene.add_mesh_simple(f"{FRAME}/ring", corners, faces, color=INK, position=(*place, 0.04), side="double")
    if base is not None:
        line = np.asarray([[(base[0], base[1], 0.04), (*place, 0.04)]], np.float32)
        scene.add_line_segments(f"{FRAME}/line", line, colors=INK, thickness=2.0, thickness_units="screen")

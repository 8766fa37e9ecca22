"""The ground all robots stand on: a plane, and a grid to judge distances by."""

from __future__ import annotations

import numpy as np
import viser

from hmi.twin.model import Colour

GROUND: Colour = (142, 138, 126)
DARK: Colour = (46, 50, 50)  # darker, and the planned way and the tracks in it cannot be told apart
PLANE = "/ground"
SIDE_M = 6000.0
BELOW_M = 0.03  # what lies on the ground must not flicker through it
CELL_M, SECTION_M, FADE_M = 1.0, 10.0, 120.0


def draw_ground(scene: viser.SceneApi, colour: Colour) -> None:
    """Draw the plane, or replace it."""
    half = SIDE_M / 2
    corners = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], np.float32)
    faces = np.array([(0, 1, 2), (0, 2, 3)], np.uint32)
    scene.add_mesh_simple(PLANE, corners, faces, color=colour, position=(0, 0, -BELOW_M), cast_shadow=False)


def tint_ground(scene: viser.SceneApi, colour: Colour) -> None:
    """Give this scene's own plane another colour; a plane made anew costs its shader once more."""
    plane = scene.get_handle_by_name(PLANE)
    if isinstance(plane, viser.MeshHandle):
        plane.color = colour
    else:
        draw_ground(scene, colour)


def draw_grid(scene: viser.SceneApi, name: str) -> None:
    """Draw lines each metre and each ten."""
    scene.add_grid(
        name,
        infinite_grid=True,
        cell_size=CELL_M,
        section_size=SECTION_M,
        cell_color=(150, 152, 148),
        section_color=(110, 114, 112),
        fade_distance=FADE_M,
    )

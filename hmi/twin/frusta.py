"""What a robot's cameras see, as open pyramids; without pictures.

A camera is a link of the model called ``camera_...``, looking along its x axis.
"""

from __future__ import annotations

import math

import viser

from hmi.twin.machine import Form
from hmi.twin.rotation import from_rpy, product

PREFIX = "camera_"
FOV_RAD, ASPECT, LENGTH_M = 1.0, 4 / 3, 0.5
INK = (36, 66, 82)
_LOOK_ALONG_X = from_rpy((-math.pi / 2, 0.0, -math.pi / 2))  # viser's cameras look along z, y down


def draw_frusta(scene: viser.SceneApi, name: str, form: Form) -> int:
    """Draw the cameras of a model below the frame ``name`` of its body; return how many there are."""
    cameras = {link: place for link, place in form.kinematics.in_base({}).items() if link.startswith(PREFIX)}
    for link, place in cameras.items():
        scene.add_camera_frustum(
            f"{name}/{link}",
            fov=FOV_RAD,
            aspect=ASPECT,
            scale=LENGTH_M,
            color=INK,
            wxyz=product(place.wxyz, _LOOK_ALONG_X),
            position=place.xyz,
        )
    return len(cameras)

"""What a robot's cameras see, as open pyramids with the newest picture in them.

A camera is a link of the model called ``camera_`` and the camera's id, looking along its x axis. A picture that gets
old is taken out: an empty pyramid says where a camera looks, a picture in it says what is there now.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import viser
from numpy.typing import NDArray

from backend_clients.edge import messages_up as up
from hmi.twin.kinematics import Place
from hmi.twin.machine import Form
from hmi.twin.rotation import from_rpy, product

PREFIX = "camera_"
FOV_RAD, ASPECT, LENGTH_M = 1.0, 4 / 3, 0.5  # of a camera whose factsheet does not tell
PICTURE_LENGTH_M = 0.45
OLD_S = 5.0
WIDEST_RAD = 2.6  # a pyramid cannot show more
INK = (36, 66, 82)
_LOOK_ALONG_X = from_rpy((-math.pi / 2, 0.0, -math.pi / 2))  # viser's cameras look along z, y down

Pixels = NDArray[np.uint8]


@dataclass(slots=True)
class _Frustum:
    handle: viser.CameraFrustumHandle
    place: Place
    captured_s: float | None = None


class Frusta:
    """The cameras of one robot, below the frame ``frame`` of its body."""

    def __init__(self, scene: viser.SceneApi, frame: str) -> None:
        self._scene, self._frame = scene, frame
        self._shown: dict[str, _Frustum] = {}
        self._key: tuple[Form, Sequence[up.Camera]] | None = None

    @property
    def cameras(self) -> list[str]:
        """The ids of the cameras that are drawn."""
        return list(self._shown)

    def show(self, form: Form, joints: Mapping[str, float], cameras: Sequence[up.Camera]) -> None:
        """Draw the cameras where they are and look now; ``joints`` in rad or m."""
        places = {
            link.removeprefix(PREFIX): place
            for link, place in form.kinematics.in_base(joints).items()
            if link.startswith(PREFIX)
        }
        if self._key is None or self._key[0] is not form or self._key[1] != cameras:
            self._key = (form, cameras)
            known = {camera.id: camera for camera in cameras}
            self._draw(places, known)
        for name, one in self._shown.items():
            if places[name] != one.place:
                one.place = places[name]
                one.handle.position = one.place.xyz
                one.handle.wxyz = product(one.place.wxyz, _LOOK_ALONG_X)

    def picture(self, camera: str, pixels: Pixels, captured_s: float) -> None:
        """Put a picture (height, width, 3) in; ``captured_s`` on the monotonic clock. An older one is dropped."""
        one = self._shown.get(camera)
        if one is None or (one.captured_s is not None and captured_s < one.captured_s):
            return
        one.captured_s = captured_s
        one.handle.image = pixels

    def fade(self, now_s: float) -> None:
        """Take out what got old."""
        for one in self._shown.values():
            if one.captured_s is not None and now_s - one.captured_s > OLD_S:
                one.captured_s = None
                one.handle.image = None

    def age_s(self, now_s: float) -> float | None:
        """Return the age of the oldest picture that is shown; ``None`` while there is none."""
        taken = [one.captured_s for one in self._shown.values() if one.captured_s is not None]
        return now_s - min(taken) if taken else None

    def _draw(self, places: Mapping[str, Place], known: Mapping[str, up.Camera]) -> None:
        for one in self._shown.values():
            one.handle.remove()
        self._shown = {}
        for name, place in places.items():
            fov_rad, aspect = _shape(known.get(name))
            handle = self._scene.add_camera_frustum(
                f"{self._frame}/{PREFIX}{name}",
                fov=fov_rad,
                aspect=aspect,
                scale=PICTURE_LENGTH_M if name in known else LENGTH_M,
                color=INK,
                format="jpeg",
                jpeg_quality=70,
                wxyz=product(place.wxyz, _LOOK_ALONG_X),
                position=place.xyz,
            )
            self._shown[name] = _Frustum(handle, place)


def _shape(camera: up.Camera | None) -> tuple[float, float]:
    """Return the vertical angle and width by height of a camera; a factsheet tells the horizontal one."""
    if camera is None:
        return FOV_RAD, ASPECT
    aspect = camera.width_px / camera.height_px
    if camera.fov_deg is None:
        return FOV_RAD, aspect
    across_rad = min(math.radians(camera.fov_deg), WIDEST_RAD)
    return 2 * math.atan(math.tan(across_rad / 2) / aspect), aspect

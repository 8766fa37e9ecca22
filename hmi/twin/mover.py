"""Frames of the scene that are moved often: only what moved is sent.

viser's own setters compare with a tolerance that grows with the distance from the origin, and cost three times as much.
"""

from __future__ import annotations

import viser

from hmi.twin.kinematics import Place
from hmi.twin.moves import Orientation, Position
from hmi.twin.rotation import is_near

STILL_M = 0.0005
STILL_RAD = 0.0002


class Mover:
    """Moves the frames of one scene, be it everybody's or one viewer's."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._shown: dict[str, Place] = {}
        self.sent = 0

    def add(self, name: str, place: Place, *, visible: bool = True) -> None:
        """Make a frame."""
        self._scene.add_frame(name, show_axes=False, position=place.xyz, wxyz=place.wxyz, visible=visible)
        self._shown[name] = place

    def has(self, name: str) -> bool:
        """Say whether it was made here."""
        return name in self._shown

    def move(self, name: str, place: Place) -> bool:
        """Move a frame made here if it is not there yet; return whether it moved."""
        before = self._shown[name]
        (ax, ay, az), (bx, by, bz) = before.xyz, place.xyz
        is_there = before.xyz is place.xyz or (
            -STILL_M < ax - bx < STILL_M and -STILL_M < ay - by < STILL_M and -STILL_M < az - bz < STILL_M
        )
        is_turned = is_near(before.wxyz, place.wxyz, STILL_RAD)
        if is_there and is_turned:
            return False
        if not is_there:
            self._send(Position(name, place.xyz))
        if not is_turned:
            self._send(Orientation(name, place.wxyz))
        self._shown[name] = Place(before.xyz if is_there else place.xyz, before.wxyz if is_turned else place.wxyz)
        return True

    def place(self, name: str) -> Place:
        """Return where a frame is shown."""
        return self._shown[name]

    def remove(self, name: str) -> None:
        """Take a frame and what hangs on it away."""
        self._scene.remove_by_name(name)
        for held in [one for one in self._shown if one == name or one.startswith(f"{name}/")]:
            del self._shown[held]

    def _send(self, message: Position | Orientation) -> None:
        self._scene._queue_scene_message(message)
        self.sent += 1

"""The camera of one picture: put somewhere by us, turned by the person, carried along with the robot.

A browser reports where its camera is, and reports late: one sent before an order of ours arrived still tells the place
before. So what we ordered counts until the person takes the camera, and an order that a page lost while it was loading
is given again.
"""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from hmi.twin.model import Vector

AGAIN_S = 0.4  # longer than a report takes on a usual link
MOST_TRIES = 60  # a slow tablet loads for half a minute; by then it has its place or never will
NEAR_SHARE = 0.05  # of the distance to what is looked at
Floats = NDArray[np.float64]


class Camera:
    """Where one viewer looks from. ``now_s`` is monotonic."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._pose: tuple[Floats, Floats] | None = None
        self._ordered_s = 0.0
        self._tries_left = 0
        self._report: object = None

    def stand(self, place: Vector, look: Vector, now_s: float) -> None:
        """Put the camera at ``place``, looking at ``look``."""
        self._pose = np.asarray(place, float), np.asarray(look, float)
        self._tries_left = MOST_TRIES
        self._send(now_s)

    def carry(self, step: Floats) -> None:
        """Move it as the robot moved; the first time after a person turned it, from where they left it."""
        if self._pose is None:
            self._pose = np.array(self._client.camera.position), np.array(self._client.camera.look_at)
        place, look = self._pose
        self._pose = place + step, look + step
        with self._client.atomic():
            self._client.camera.position, self._client.camera.look_at = self._pose
        self._report = self._client.camera._state

    def zoom(self, factor: float) -> None:
        """Bring it nearer to what it looks at (below 1) or further away."""
        camera = self._client.camera
        place, look = self._pose or (np.array(camera.position), np.array(camera.look_at))
        self._pose = look + (place - look) * factor, look
        camera.position, camera.look_at = self._pose

    def let_go(self) -> None:
        """A person has it: where they put it is where it is."""
        self._pose, self._tries_left = None, 0

    def check(self, now_s: float) -> None:
        """Order it again while the browser reports another place than the one it was ordered to."""
        if self._pose is None or self._tries_left == 0 or self._client.camera._state is self._report:
            return
        if self._is_there(*self._pose):
            self._tries_left = 0
        elif now_s - self._ordered_s >= AGAIN_S:
            self._tries_left -= 1
            self._send(now_s)

    def _is_there(self, place: Floats, look: Floats) -> bool:
        camera = self._client.camera
        most_m = NEAR_SHARE * float(np.linalg.norm(place - look))
        return all(
            float(np.linalg.norm(np.subtract(reported, ordered))) <= most_m
            for reported, ordered in ((camera.position, place), (camera.look_at, look))
        )

    def _send(self, now_s: float) -> None:
        if self._pose is None:
            return
        place, look = self._pose
        self._ordered_s = now_s
        with self._client.atomic():
            self._client.camera.up_direction = (0.0, 0.0, 1.0)
            self._client.camera.position = place
            self._client.camera.look_at = look
        self._report = self._client.camera._state  # the browser's next one is another object

"""Where a robot came from, in pieces of 200 points: only the newest piece is ever sent again."""

from __future__ import annotations

import math

import numpy as np
import viser

from hmi.twin.model import Vector

CHUNK = 200
CHUNKS = 20
STEP_M = 0.15
GAP_M = 15.0  # further than a robot gets between two looks: nobody watched in between, or it was carried
INK = (36, 66, 82)


class Trail:
    """The way of one robot since somebody watches it."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._scene, self._name = scene, name
        self._chunks: list[list[Vector]] = [[]]
        self._first = 0

    @property
    def points(self) -> int:
        """How many points are kept."""
        return sum(map(len, self._chunks))

    def add(self, place: Vector) -> bool:
        """Take a place; return whether it is far enough from the one before to be drawn."""
        point = (place[0], place[1], place[2] + 0.03)
        newest = self._chunks[-1]
        if newest:
            step = math.dist(newest[-1], point)
            if step < STEP_M:
                return False
            if step > GAP_M:
                self._start([])
            elif len(newest) >= CHUNK:
                self._start([newest[-1]])
        self._chunks[-1].append(point)
        self._draw()
        return True

    def _start(self, points: list[Vector]) -> None:
        self._chunks.append(points)
        if len(self._chunks) > CHUNKS:
            self._chunks.pop(0)
            self._scene.remove_by_name(f"{self._name}/{self._first}")
            self._first += 1

    def _draw(self) -> None:
        points = np.asarray(self._chunks[-1], np.float32)
        if len(points) < 2:
            return
        pairs = np.stack([points[:-1], points[1:]], axis=1)
        number = self._first + len(self._chunks) - 1
        self._scene.add_line_segments(
            f"{self._name}/{number}", pairs, colors=INK, thickness=2.5, thickness_units="screen"
        )

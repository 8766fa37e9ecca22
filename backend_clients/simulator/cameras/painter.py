"""Draws looks on the scenes it was given."""

from __future__ import annotations

from collections import OrderedDict

from backend_clients.simulator.cameras.composer import compose
from backend_clients.simulator.cameras.jpeg import encoded
from backend_clients.simulator.cameras.scene import Look, Picture, Rows, Scene
from backend_clients.simulator.cameras.stage import Stage
from backend_clients.simulator.cameras.textures import field_of

MOST_SCENES = 64


class Painter:
    """Keeps the newest scenes; the same look on the same scene is the same picture."""

    def __init__(self) -> None:
        self._stages: OrderedDict[str, Stage] = OrderedDict()
        self._owed: list[Rows] = []

    def keep(self, scene: Scene) -> None:
        """Remember a scene; the oldest is forgotten."""
        self._stages[scene.key] = Stage(scene)
        self._stages.move_to_end(scene.key)
        while len(self._stages) > MOST_SCENES:
            self._stages.popitem(last=False)

    def draw(self, number: int, look: Look) -> Picture:
        """Return the picture of a look; without its scene, the problem."""
        stage = self._stages.get(look.scene)
        if stage is None:
            return Picture(number, problem="unknown scene")
        pixels, boxes = compose(look, stage, self._owed)
        return Picture(number, encoded(pixels), boxes)

    def catch_up(self) -> None:
        """Make what a hasty picture could not wait for."""
        while self._owed:
            field_of(self._owed.pop())

"""Draws looks on the scenes it was given."""

from __future__ import annotations

from collections import OrderedDict

from backend_clients.simulator.cameras.composer import compose
from backend_clients.simulator.cameras.jpeg import encoded
from backend_clients.simulator.cameras.scene import Look, Picture, Scene
from backend_clients.simulator.cameras.stage import Stage

MOST_SCENES = 64


class Painter:
    """Keeps the newest scenes; the same look on the same scene is the same picture."""

    def __init__(self) -> None:
        self._stages: OrderedDict[str, Stage] = OrderedDict()

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
        pixels, boxes = compose(look, stage)
        return Picture(number, encoded(pixels), boxes)

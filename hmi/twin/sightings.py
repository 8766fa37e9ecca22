"""Who stands near the robot: a post with a caption that says how far, and whether that is too near."""

from __future__ import annotations

from collections.abc import Sequence

import viser

from backend_clients.edge.machine import Sighting

WORDS = {"person": "Person", "animal": "Animal", "vehicle": "Vehicle", "object": "Object"}
HEIGHT_M = {"person": 1.75, "animal": 0.9, "vehicle": 2.0, "object": 0.6}
CALM, WARNING = (84, 96, 104), (239, 125, 20)


class Sightings:
    """Draws what one robot sees."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._scene, self._name = scene, name
        self._shown: dict[str, tuple[object, ...]] = {}

    def show(self, seen: Sequence[Sighting], shift: tuple[float, float], keep_out_m: float) -> None:
        """Draw everybody who is seen now."""
        for gone in self._shown.keys() - {one.id for one in seen}:
            self._scene.remove_by_name(f"{self._name}/{gone}")
            del self._shown[gone]
        for one in seen:
            is_near = one.distance_m < keep_out_m
            drawn = (round(one.x_m, 1), round(one.y_m, 1), round(one.distance_m, 1), is_near)
            if self._shown.get(one.id) != drawn:
                self._shown[one.id] = drawn
                self._draw(one, shift, is_near=is_near)

    def _draw(self, one: Sighting, shift: tuple[float, float], *, is_near: bool) -> None:
        height_m = HEIGHT_M[one.kind]
        name = f"{self._name}/{one.id}"
        at = (one.x_m + shift[0], one.y_m + shift[1])
        self._scene.add_frame(name, show_axes=False, position=(*at, 0.0))
        colour = WARNING if is_near else CALM
        self._scene.add_cylinder(
            f"{name}/post", 0.28, height_m, color=colour, opacity=0.75, position=(0, 0, height_m / 2)
        )
        where = "inside keep-out" if is_near else "outside keep-out"
        text = f"{WORDS[one.kind]}, {one.distance_m:.1f} m\n{where}"
        self._scene.add_label(f"{name}/text", text, position=(0, 0, height_m + 0.4), anchor="bottom-center")

"""Joints beyond their soft limit: an orange band around the joint and how far it is."""

from __future__ import annotations

import viser

from backend_clients.edge.machine import Joint
from backend_clients.edge.messages_up import Factsheet
from hmi.twin.machine import Form
from hmi.twin.posture import Posture

WARNING = (239, 125, 20)
SHARE_OF_SIZE = 0.05


def beyond_soft_limit(joint: Joint, value: float) -> bool:
    """Say whether a joint warns."""
    below = joint.soft_lower is not None and value < joint.soft_lower
    return below or (joint.soft_upper is not None and value > joint.soft_upper)


def travel(joint: Joint, value: float) -> float:
    """Return how far a joint is towards the nearer end of its travel: 0.5 in the middle, 1 at the end."""
    span = joint.upper - joint.lower
    share = 0.5 if span <= 0 else (value - joint.lower) / span
    return min(1.0, max(share, 1.0 - share))


class LimitMarks:
    """Draws warnings on one robot."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._scene, self._name = scene, name
        self._shown: dict[str, tuple[object, ...]] = {}

    def show(self, form: Form, posture: Posture, factsheet: Factsheet) -> None:
        """Mark the joints that warn now."""
        link_of = {joint.name: joint.child for joint in form.model.joints}
        marked = set()
        places = form.kinematics.in_base(posture.joints)
        for joint in factsheet.joints:
            value = posture.joints.get(joint.name)
            if value is None or joint.name not in link_of or not beyond_soft_limit(joint, value):
                continue
            marked.add(joint.name)
            at = places[link_of[joint.name]].xyz
            drawn = (*(round(one, 2) for one in at), round(100 * travel(joint, value)))
            if self._shown.get(joint.name) != drawn:
                self._shown[joint.name] = drawn
                self._draw(joint, value, at, form.size_m)
        for calm in self._shown.keys() - marked:
            self._scene.remove_by_name(f"{self._name}/{calm}")
            del self._shown[calm]

    def _draw(self, joint: Joint, value: float, at: tuple[float, float, float], size_m: float) -> None:
        name = f"{self._name}/{joint.name}"
        self._scene.add_frame(name, show_axes=False, position=at)
        self._scene.add_icosphere(f"{name}/band", radius=SHARE_OF_SIZE * size_m, color=WARNING, opacity=0.85)
        text = f"{joint.label or joint.name}, {travel(joint, value):.0%} of its travel\nbeyond soft limit"
        self._scene.add_label(f"{name}/text", text, position=(0, 0, 0.1 * size_m), anchor="bottom-center")

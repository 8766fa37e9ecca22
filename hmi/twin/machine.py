"""One robot in the scene: its body frame and the frames of its moving joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import viser

from hmi.twin.doubt import NOTHING, Doubt
from hmi.twin.glb import shade_of
from hmi.twin.kinematics import Kinematics, Place
from hmi.twin.model import Model, Vector
from hmi.twin.mover import Mover
from hmi.twin.rotation import turned
from hmi.twin.skin import Skin


@dataclass(frozen=True, slots=True)
class Form:
    """A model made ready for drawing, shared by all robots that look alike."""

    model: Model
    kinematics: Kinematics
    solid: dict[str, bytes]
    ghost: dict[str, bytes]
    size_m: float
    tip: str
    _shades: dict[str, bytes] = field(default_factory=dict)

    @classmethod
    def of(cls, model: Model, skin: Skin) -> Form:
        """Prepare a model."""
        kinematics = Kinematics(model)
        return cls(
            model, kinematics, skin.glbs(), skin.glbs(is_ghost=True), _size(model, skin), _tip(model, kinematics)
        )

    def head(self, body: Place, joints: Mapping[str, float]) -> Vector | None:
        """Return where the tool's tip is in the site's plane; ``None`` for a machine of one piece."""
        return self.point(self.tip, body, joints)

    def shade(self, link: str) -> bytes:
        """Return how a link looks that is not known to stand there."""
        if link not in self._shades:
            self._shades[link] = shade_of(self.solid[link])
        return self._shades[link]

    def doubted(self, doubt: Doubt) -> frozenset[str]:
        """Return the links of which something is to be seen and that are not known to stand where they are drawn."""
        seen = frozenset(self.solid)
        if doubt.is_everything:
            return seen
        return seen & self.kinematics.moved_by(doubt.joints) if doubt.joints else frozenset()

    def point(self, link: str, body: Place, joints: Mapping[str, float]) -> Vector | None:
        """Return where a link's frame is in the site's plane."""
        place = self.kinematics.in_base(joints).get(link)
        if place is None:
            return None
        x, y, z = turned(body.wxyz, place.xyz)
        return body.xyz[0] + x, body.xyz[1] + y, body.xyz[2] + z


class MachineView:
    """Draws one robot below ``name``.

    Args:
        scene: everybody's scene, or one viewer's.
        name: path of the body frame, e.g. ``/machine/weeder-07``.
    """

    def __init__(self, scene: viser.SceneApi, mover: Mover, name: str, form: Form, *, is_ghost: bool = False) -> None:
        self._scene, self._mover, self.name, self.form = scene, mover, name, form
        self._doubt: Doubt = NOTHING
        self.doubted: frozenset[str] = frozenset()
        self._frames = {joint.child: self._frame(joint.child) for joint in form.model.joints}
        mover.add(name, Place((0.0, 0.0, 0.0)), visible=not is_ghost)
        for link, place in form.kinematics.rest():
            mover.add(self._frame(link), place)
        for link, data in (form.ghost if is_ghost else form.solid).items():
            scene.add_glb(self.skin(link), data, cast_shadow=not is_ghost, receive_shadow=not is_ghost)

    def skin(self, link: str) -> str:
        """Return the name of what is seen of a link while it is known; a link may be called skin."""
        return f"{self._frame(link)}/@skin"

    def shade(self, link: str) -> str:
        """Return the name of what is seen of a link while it is not."""
        return f"{self._frame(link)}/@shade"

    def doubt(self, doubt: Doubt) -> None:
        """Draw as shades what is not known, and nothing else so."""
        if doubt == self._doubt:
            return
        links = self.form.doubted(doubt)
        for link in links ^ self.doubted:
            self._set(self.skin(link), is_seen=link not in links)
            if self._scene.get_handle_by_name(self.shade(link)) is None:
                draw_shade(self._scene, self.shade(link), self.form.shade(link))
            self._set(self.shade(link), is_seen=link in links)
        self._doubt, self.doubted = doubt, links

    def show(self, body: Place, joints: Mapping[str, float]) -> int:
        """Bring it to a place and posture; return how many frames moved."""
        moved = int(self._mover.move(self.name, body))
        for link, place in self.form.kinematics.places(joints):
            moved += self._mover.move(self._frames[link], place)
        return moved

    def frames(self, body: Place, joints: Mapping[str, float]) -> list[tuple[str, Place]]:
        """Return where its frames would be for a posture, by their names."""
        own = [(self._frame(link), place) for link, place in self.form.kinematics.places(joints)]
        return [(self.name, body), *own]

    def remove(self) -> None:
        """Take it away."""
        self._mover.remove(self.name)

    def _frame(self, link: str) -> str:
        return f"{self.name}{self.form.kinematics.path(link)}"

    def _set(self, name: str, *, is_seen: bool) -> None:
        node = self._scene.get_handle_by_name(name)
        if node is not None:
            node.visible = is_seen


def draw_shade(scene: viser.SceneApi, name: str, glb: bytes) -> None:
    """Draw a link that is not known to stand there."""
    scene.add_glb(name, glb, cast_shadow=False, receive_shadow=False)


def _size(model: Model, skin: Skin) -> float:
    """How large the machine's body is, metres: the longest side of what its root link shows, else of everything."""
    shown = [skin.links[model.root]] if model.root in skin.links else list(skin.links.values())
    if not shown:
        return 1.0
    every = np.concatenate([one.corners for one in shown])
    return float((every.max(axis=0) - every.min(axis=0)).max())


def _tip(model: Model, kinematics: Kinematics) -> str:
    """The link called tool, else the one at the end of the longest chain."""
    names = [joint.child for joint in model.joints]
    return "tool" if "tool" in names else max(names, key=lambda link: kinematics.path(link).count("/"), default="")

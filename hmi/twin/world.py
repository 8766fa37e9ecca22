"""The shared scene: ground, layers, and every robot where it stands. Many viewers look at one world."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass

import viser

from hmi.twin.ground import GROUND, draw_grid, draw_ground
from hmi.twin.groups import HIDDEN_AT_FIRST, Group
from hmi.twin.kinematics import Place
from hmi.twin.machine import Form, MachineView
from hmi.twin.mover import Mover
from hmi.twin.posture import Posture

BEAT = "/beat"


@dataclass(slots=True)
class _Shown:
    solid: MachineView
    at_s: float | None = 0.0
    unheard: tuple[str, ...] = ()
    ghost: MachineView | None = None
    is_ghost_seen: bool = False


class World:
    """Draws robots; call it from one thread."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server, self._scene = server, server.scene
        self.mover = Mover(server.scene)
        self._robots: dict[str, _Shown] = {}
        server.scene.world_axes.visible = False
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.scene.configure_default_lights(enabled=True, cast_shadow=False)
        for group in Group:
            self._scene.add_frame(group.frame, show_axes=False, visible=group not in HIDDEN_AT_FIRST)
        self.mover.add(BEAT, Place((0.0, 0.0, 0.0)))
        draw_ground(self._scene, GROUND)
        draw_grid(self._scene, f"{Group.TERRAIN.frame}/grid")

    def at_once(self) -> AbstractContextManager[None]:
        """Send everything that is drawn within as one: pictures do not tear, and viser is woken once, not per frame."""
        return self._server.atomic()

    def robots(self) -> list[str]:
        """Return who is drawn."""
        return list(self._robots)

    def form_of(self, robot_id: str) -> Form | None:
        """Return the model a robot is drawn with."""
        shown = self._robots.get(robot_id)
        return None if shown is None else shown.solid.form

    def drawn_at_s(self, robot_id: str) -> float | None:
        """Return when the posture was true that a robot is drawn with; ``None`` while it is not drawn or unknown."""
        shown = self._robots.get(robot_id)
        return None if shown is None else shown.at_s

    def unheard(self, robot_id: str) -> tuple[str, ...]:
        """Return the joints that a robot is drawn with though they were not heard."""
        shown = self._robots.get(robot_id)
        return () if shown is None else shown.unheard

    def solid(self, robot_id: str) -> MachineView | None:
        """Return the drawing of a robot as measured."""
        shown = self._robots.get(robot_id)
        return None if shown is None else shown.solid

    def show(self, robot_id: str, form: Form, posture: Posture, now_s: float, *, has_ghost: bool) -> int:
        """Draw a robot; the ghost of where its joints are going only if somebody looks at it. Returns what moved.

        What is old at ``now_s``, by this process's monotonic clock, is drawn as a shade.
        """
        shown = self._robots.get(robot_id)
        if shown is None or shown.solid.form is not form:
            if shown is not None:
                self.remove(robot_id)
            solid = MachineView(self._scene, self.mover, Group.MACHINE.of(robot_id), form)
            shown = self._robots[robot_id] = _Shown(solid)
        moved = shown.solid.show(posture.body, posture.joints)
        shown.solid.doubt(posture.doubt(now_s))
        shown.at_s, shown.unheard = posture.at_s, posture.unheard
        return moved + self._show_ghost(robot_id, shown, posture, is_wanted=has_ghost and bool(posture.planned))

    def beat(self) -> None:
        """Move something nobody sees, so that a picture in which all stands still is known to be alive."""
        up_m = 0.0 if self.mover.place(BEAT).xyz[2] else 1.0
        self.mover.move(BEAT, Place((0.0, 0.0, up_m)))

    def remove(self, robot_id: str) -> None:
        """Take a robot away."""
        shown = self._robots.pop(robot_id, None)
        if shown is not None:
            shown.solid.remove()
            if shown.ghost is not None:
                shown.ghost.remove()

    def _show_ghost(self, robot_id: str, shown: _Shown, posture: Posture, *, is_wanted: bool) -> int:
        if is_wanted and shown.ghost is None:
            name = Group.PLANNED.of(robot_id)
            shown.ghost = MachineView(self._scene, self.mover, name, shown.solid.form, is_ghost=True)
        if shown.ghost is None:
            return 0
        if is_wanted != shown.is_ghost_seen:
            shown.is_ghost_seen = is_wanted
            frame = self._scene.get_handle_by_name(shown.ghost.name)
            if frame is not None:
                frame.visible = is_wanted
        return shown.ghost.show(posture.body, {**posture.joints, **posture.planned}) if is_wanted else 0

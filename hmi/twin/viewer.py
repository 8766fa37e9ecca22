"""One browser that looks: its view, its hidden layers, its replay. Nothing of it touches anybody else.

viser shows a viewer its own variant of a frame in place of everybody's: so layers are hidden and replays shown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
import viser

from hmi.twin.camera import Camera
from hmi.twin.ground import DARK, GROUND, tint_ground
from hmi.twin.groups import HIDDEN_AT_FIRST, Group
from hmi.twin.kinematics import Place
from hmi.twin.marks import draw_marks
from hmi.twin.model import Vector
from hmi.twin.moment import Moment
from hmi.twin.mover import Mover
from hmi.twin.past import NOT_RECORDED, Marks, Past, Skins
from hmi.twin.touched import draw_touched

SETTLE_S = 0.4  # a turned camera runs on a little after it was let go
HOLD_S = 0.6  # after a touch of the wheel or a key the camera is left alone this long
FOLLOW_M = 0.004  # smaller steps are not worth a message
MARK_M = 0.2


class View(StrEnum):
    """Where the camera stands."""

    FOLLOW = "follow"
    TOP = "top"
    SIDE = "side"
    HEAD = "head"
    FREE = "free"


@dataclass(slots=True)
class Viewer:
    """What one page asked for. ``client`` is there while its picture is connected.

    ``moment`` is what it wants to see of the record, ``past`` what it sees of it.
    """

    key: str
    robot_id: str
    may_replay: bool
    client: viser.ClientHandle | None = None
    view: View = View.FOLLOW
    hidden: set[Group] = field(default_factory=lambda: set(HIDDEN_AT_FIRST))
    moment: Moment | None = None
    past: Past | None = None
    is_aimed: bool = False
    is_held: bool = False
    held_until_s: float = 0.0
    is_dark: bool = False
    touched: tuple[float, float] | None = None
    touched_robot: str | None = None
    _mover: Mover | None = None
    _camera: Camera | None = None
    _base: Vector | None = None
    _overridden: set[str] = field(default_factory=set)
    _touched_from: Vector | None = None
    _height_m: float = 0.0
    _marks: Marks = field(default_factory=dict)
    _skins: Skins = field(default_factory=dict)

    def join(self, client: viser.ClientHandle) -> None:
        """Take the picture that connected; it starts blank, so everything of this viewer is told again."""
        self.client, self._base, self.is_aimed = client, None, False
        self._mover, self._camera = Mover(client.scene), Camera(client)
        self._overridden, self._marks, self._skins = set(), {}, {}
        for group in Group:
            self._tell(group)
        if self.is_dark:
            self.set_dark(is_dark=True)
        self.show_replay(self.past)
        if self.touched is not None:
            self._draw_touched()

    def leave(self, client_id: int) -> None:
        """Forget a picture that went, unless a newer one came already."""
        if self.client is not None and self.client.client_id == client_id:
            self.client = self._mover = self._camera = self._base = None

    def set_layer(self, group: Group, *, is_on: bool) -> None:
        """Show or hide a layer for this viewer."""
        self.hidden.discard(group) if is_on else self.hidden.add(group)
        self._tell(group)

    def hold(self, *, is_held: bool, now_s: float) -> None:
        """A person turns the picture: the camera is theirs until they let go."""
        self.is_held = is_held
        self.held_until_s = now_s + (SETTLE_S if not is_held else HOLD_S)
        self._base = None
        if self._camera is not None:
            self._camera.let_go()

    def show_replay(self, past: Past | None) -> None:
        """Show a robot where it was, to this viewer alone; ``None`` goes back to now.

        What is known of now only is hidden meanwhile, so that nothing of now is taken for then.
        """
        is_turn = (past is None) != (self.past is None)
        self.past = past
        if self.client is None or self._mover is None:
            return
        if past is None:
            self._show_marks({})
            self._show_skins({})
            for name in self._overridden:
                self._mover.remove(name)
            self._overridden = set()
        else:
            self._override(past, self._mover)
        for group in NOT_RECORDED if is_turn else ():
            self._tell(group)

    def aim(self, view: View, base: Place, size_m: float, head: Vector | None, now_s: float) -> None:
        """Stand the camera for a view of a machine of that size."""
        self.view, self._base = view, base.xyz
        if self._camera is None:
            return
        self.is_aimed = True
        look, stand = _stand(view, base, size_m, head)
        self._camera.stand(stand, look, now_s)

    def follow(self, base: Vector, now_s: float) -> None:
        """Carry the camera along with the robot, unless the person turns it at this moment."""
        if self._camera is None or self.is_held or now_s < self.held_until_s:
            self._base = None
            return
        self._camera.check(now_s)
        if self.view is View.FREE:
            return
        if self._base is None:
            self._base = base
            return
        step = np.subtract(base, self._base)
        if float(np.abs(step).max()) < FOLLOW_M:
            return
        self._base = base
        self._camera.carry(step)

    def zoom(self, factor: float) -> None:
        """Bring the camera nearer or further from what it looks at."""
        if self._camera is not None:
            self._camera.zoom(factor)

    def mark(self, place: tuple[float, float] | None, base: Vector | None, robot_id: str | None = None) -> None:
        """Show this viewer the place that was touched and the line to it; ``None`` takes it away.

        ``robot_id`` is who was touched there, ``base`` where the line begins; without it there is none.
        """
        self.touched, self.touched_robot, self._touched_from, self._height_m = place, robot_id, base, 0.0
        self._draw_touched()

    def mark_at(self, place: tuple[float, float]) -> None:
        """Move the mark to where the touched robot is now."""
        if self.touched is not None and math.dist(self.touched, place) > MARK_M:
            self.touched = place
            self._draw_touched()

    def mark_from(self, base: Vector) -> None:
        """Let the line to the touched place begin where the robot is now."""
        before = self._touched_from
        if self.touched is not None and (before is None or math.dist(before, base) > MARK_M):
            self._touched_from = base
            self._draw_touched()

    def lift(self, height_m: float) -> None:
        """Show this viewer how high above the touched place the tool would stand."""
        if self.touched is not None:
            self._height_m = height_m
            self._draw_touched()

    def set_dark(self, *, is_dark: bool) -> None:
        """Darken the ground for this viewer."""
        self.is_dark = is_dark
        if self.client is not None:
            tint_ground(self.client.scene, DARK if is_dark else GROUND)

    def _draw_touched(self) -> None:
        if self.client is not None:
            draw_touched(self.client.scene, self.touched, self._touched_from, self._height_m)

    def _override(self, past: Past, mover: Mover) -> None:
        for name in past.hidden:
            if not mover.has(name):
                mover.add(name, Place((0.0, 0.0, 0.0)), visible=False)
                self._overridden.add(name)
        for name, place in past.frames:
            if mover.has(name):
                mover.move(name, place)
            else:
                mover.add(name, place)
                self._overridden.add(name)
        self._show_marks(past.marks)
        self._show_skins(past.skins)

    def _show_marks(self, marks: Marks) -> None:
        """Show this viewer fewer marks than everybody; those of now again where nothing is said."""
        if marks is self._marks or self.client is None:
            return
        scene = self.client.scene
        for frame in self._marks.keys() - marks.keys():
            scene.remove_by_name(frame)
        for frame, (mark, places) in marks.items():
            if places:
                draw_marks(scene, frame, mark, places)
            else:
                scene.add_frame(frame, show_axes=False, visible=False)
        self._marks = marks

    def _show_skins(self, skins: Skins) -> None:
        """Show this viewer some links otherwise than everybody; as everybody where nothing is said."""
        if self.client is None:
            return
        scene = self.client.scene
        for name in self._skins.keys() - skins.keys():
            scene.remove_by_name(name)
        for name, glb in skins.items():
            if name in self._skins and self._skins[name] is glb:
                continue
            if glb is None:
                scene.add_frame(name, show_axes=False, visible=False)
            else:
                scene.add_glb(name, glb, cast_shadow=False, receive_shadow=False)
        self._skins = skins

    def _tell(self, group: Group) -> None:
        if self.client is None:
            return
        is_hidden = group in self.hidden or (self.past is not None and group in NOT_RECORDED)
        is_default = is_hidden == (group in HIDDEN_AT_FIRST)
        scene = self.client.scene
        if is_default:
            if scene.get_handle_by_name(group.frame) is not None:
                scene.remove_by_name(group.frame)
        else:
            scene.add_frame(group.frame, show_axes=False, visible=not is_hidden)


def _stand(view: View, base: Place, size_m: float, head: Vector | None) -> tuple[Vector, Vector]:
    """Return what is looked at and where from."""
    x, y, z = base.xyz
    w, _, _, qz = base.wxyz
    yaw = 2 * float(np.arctan2(qz, w))
    forward, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    away = max(size_m, 1.5)
    middle = (x, y, z + 0.25 * size_m)
    if view is View.TOP:
        return (x, y, z), (x - 0.01 * float(forward[0]), y - 0.01 * float(forward[1]), z + 3.2 * away)
    if view is View.SIDE:
        stand = np.array([x, y]) - left * 2.2 * away
        return middle, (float(stand[0]), float(stand[1]), z + 0.45 * away)
    if view is View.HEAD and head is not None:
        stand = np.array(head[:2]) + forward * 0.7 * away + left * 0.5 * away
        return head, (float(stand[0]), float(stand[1]), head[2] + 0.5 * away)
    stand = np.array([x, y]) + forward * 1.5 * away - left * 1.1 * away
    return middle, (float(stand[0]), float(stand[1]), z + 1.1 * away)

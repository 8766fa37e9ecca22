"""A robot as it was recorded, for one viewer: its body, its joints, and what of the scene cannot be told of then."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hmi.twin.doubt import Doubt
from hmi.twin.groups import Group
from hmi.twin.kinematics import Place
from hmi.twin.machine import MachineView
from hmi.twin.marks import Mark
from hmi.twin.model import Vector
from hmi.twin.moment import Moment

NOT_RECORDED = frozenset({Group.PLANNED, Group.SCAN, Group.LIMITS, Group.LABELS, Group.CAMERAS, Group.TRAIL})
"""Layers known of now only: beside a robot of ten minutes ago they would be taken for then."""
Marks = Mapping[str, tuple[Mark, list[tuple[float, float]]]]
Skins = Mapping[str, bytes | None]
"""What a viewer sees of links in place of what everybody sees: a GLB by its name, ``None`` for nothing."""
WITH_BODY = (Group.KEEPOUT, Group.REACH)
OF_OTHERS = (Group.MACHINE, Group.TREES, *WITH_BODY)
"""What is drawn of every robot in layers that show the replayed one as it was then."""


@dataclass(frozen=True, slots=True)
class Basis:
    """What a replayed moment is made from: it is good for as long as this stays.

    ``ends`` counts the places that are over by now. ``others`` are robots that are seen where they are now. ``doubt``
    is what was not recorded, ``doubted`` the links that everybody sees as shades now.
    """

    moment: Moment
    drawn: MachineView
    ends: int
    others: tuple[str, ...]
    doubt: Doubt
    doubted: frozenset[str]


@dataclass(frozen=True, slots=True)
class Past:
    """One recorded moment. ``body`` in the site's plane, ``frames`` by their names."""

    basis: Basis
    body: Place
    head: Vector | None
    frames: list[tuple[str, Place]]
    hidden: tuple[str, ...]
    undone: frozenset[str]
    marks: Marks
    skins: Skins


def past_of(robot_id: str, basis: Basis, body: Place, undone: frozenset[str], marks: Marks) -> Past:
    """Return the moment at which a robot stood at ``body``; the others are hidden.

    ``marks`` are the places that were over by then, where they are fewer than now, by their frame.
    """
    drawn, joints = basis.drawn, basis.moment.joints
    around = [(group.of(robot_id), body) for group in WITH_BODY]
    frames = [*drawn.frames(body, joints), *around]
    hidden = (worked_at(robot_id), *(group.of(other) for other in basis.others for group in OF_OTHERS))
    return Past(basis, body, drawn.form.head(body, joints), frames, hidden, undone, marks, _skins(basis))


def _skins(basis: Basis) -> Skins:
    """Shades for what was not recorded, and solid what is, whatever everybody sees of now."""
    drawn, then = basis.drawn, basis.drawn.form.doubted(basis.doubt)
    skins: dict[str, bytes | None] = {}
    for link in then - basis.doubted:
        skins |= {drawn.skin(link): None, drawn.shade(link): drawn.form.shade(link)}
    for link in basis.doubted - then:
        skins |= {drawn.skin(link): drawn.form.solid[link], drawn.shade(link): None}
    return skins


def worked_at(robot_id: str) -> str:
    """Return the frame of the places that are planned or worked at now."""
    return f"{Group.TREES.of(robot_id)}/now"

"""A robot as it was recorded, for one viewer: its body, its joints, and what of the scene cannot be told of then."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hmi.twin.groups import Group
from hmi.twin.kinematics import Place
from hmi.twin.machine import MachineView
from hmi.twin.marks import Mark
from hmi.twin.model import Vector

NOT_RECORDED = frozenset({Group.PLANNED, Group.SCAN, Group.LIMITS, Group.LABELS, Group.CAMERAS})
"""Layers known of now only: beside a robot of ten minutes ago they would be taken for then."""
Marks = Mapping[str, tuple[Mark, list[tuple[float, float]]]]
WITH_BODY = (Group.KEEPOUT, Group.REACH)


@dataclass(frozen=True, slots=True)
class Past:
    """One recorded moment. ``body`` in the site's plane, ``joints`` in rad or m, ``frames`` by their names."""

    body: Place
    joints: Mapping[str, float]
    head: Vector | None
    frames: list[tuple[str, Place]]
    hidden: tuple[str, ...]
    undone: frozenset[str]
    marks: Marks


def past_of(
    robot_id: str, drawn: MachineView, body: Place, joints: Mapping[str, float], undone: frozenset[str], marks: Marks
) -> Past:
    """Return the moment at which a robot stood at ``body`` with such joints.

    ``marks`` are the places that were over by then, where they are fewer than now, by their frame.
    """
    around = [(group.of(robot_id), body) for group in WITH_BODY]
    frames = [*drawn.frames(body, joints), *around]
    return Past(body, joints, drawn.form.head(body, joints), frames, (worked_at(robot_id),), undone, marks)


def worked_at(robot_id: str) -> str:
    """Return the frame of the places that are planned or worked at now."""
    return f"{Group.TREES.of(robot_id)}/now"

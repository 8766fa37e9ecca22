"""Where each moving part of a model stands for given joint values."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from hmi.twin.model import Model, ModelJoint, Quaternion, Vector
from hmi.twin.rotation import IDENTITY, about, from_rpy, product, turned


@dataclass(frozen=True, slots=True)
class Place:
    """Position in metres and turn, in the parent's frame."""

    xyz: Vector
    wxyz: Quaternion = IDENTITY


@dataclass(frozen=True, slots=True)
class _Hinge:
    joint: ModelJoint
    turn: Quaternion


class Kinematics:
    """The joints of one model, prepared once; ``path`` of a link names its frames from the root down."""

    def __init__(self, model: Model) -> None:
        self._hinges = tuple(_Hinge(joint, from_rpy(joint.rpy)) for joint in model.joints)
        self._moving = tuple(hinge for hinge in self._hinges if hinge.joint.moves)
        self._path = {model.root: ""}
        for joint in model.joints:
            self._path[joint.child] = f"{self._path[joint.parent]}/{joint.child}"

    def path(self, link: str) -> str:
        """Return the frames from below the root to a link, each with a slash before it; empty for the root."""
        return self._path[link]

    def rest(self) -> Iterator[tuple[str, Place]]:
        """Yield every link but the root with its place when all joints are at their lowest absolute value."""
        for hinge in self._hinges:
            yield hinge.joint.child, _place(hinge, _value(hinge.joint, {}))

    def places(self, values: Mapping[str, float]) -> Iterator[tuple[str, Place]]:
        """Yield the links that joints move, each with its place in its parent's frame.

        A value that is missing or not finite leaves the joint at rest, one outside its limits is held at the limit.
        """
        for hinge in self._moving:
            yield hinge.joint.child, _place(hinge, _value(hinge.joint, values))

    def moved_by(self, joints: Collection[str]) -> frozenset[str]:
        """Return the links whose place these joints decide, also as those that others follow."""
        found: set[str] = set()
        for hinge in self._hinges:
            joint = hinge.joint
            leader = joint.name if joint.mimic is None else joint.mimic.joint
            if joint.parent in found or (joint.moves and leader in joints):
                found.add(joint.child)
        return frozenset(found)

    def in_base(self, values: Mapping[str, float]) -> dict[str, Place]:
        """Return every link's place in the frame of the root."""
        found: dict[str, Place] = {}
        for hinge in self._hinges:
            held = found.get(hinge.joint.parent, Place((0.0, 0.0, 0.0)))
            own = _place(hinge, _value(hinge.joint, values))
            x, y, z = turned(held.wxyz, own.xyz)
            xyz = held.xyz[0] + x, held.xyz[1] + y, held.xyz[2] + z
            found[hinge.joint.child] = Place(xyz, product(held.wxyz, own.wxyz))
        return found


def _value(joint: ModelJoint, values: Mapping[str, float]) -> float:
    if joint.mimic is not None:
        followed = values.get(joint.mimic.joint)
        value = None if followed is None else followed * joint.mimic.factor + joint.mimic.offset
    else:
        value = values.get(joint.name)
    if value is None or not math.isfinite(value):
        value = 0.0
    if joint.lower is not None and joint.upper is not None:
        value = min(max(value, joint.lower), joint.upper)
    return value


def _place(hinge: _Hinge, value: float) -> Place:
    joint = hinge.joint
    if joint.kind == "prismatic":
        x, y, z = turned(hinge.turn, (joint.axis[0] * value, joint.axis[1] * value, joint.axis[2] * value))
        return Place((joint.xyz[0] + x, joint.xyz[1] + y, joint.xyz[2] + z), hinge.turn)
    if joint.moves:
        return Place(joint.xyz, product(hinge.turn, about(joint.axis, value)))
    return Place(joint.xyz, hinge.turn)

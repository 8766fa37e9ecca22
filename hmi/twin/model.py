"""A robot model as data: links with what is seen of them, joints that move them.

Lengths in metres, angles in radians, quaternions as w, x, y, z. A joint's frame is given in its parent's.
"""

from __future__ import annotations

from dataclasses import dataclass, field

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Colour = tuple[int, int, int]

MOVING = ("revolute", "continuous", "prismatic")
GREY: Colour = (120, 126, 130)


@dataclass(frozen=True, slots=True)
class Box:
    """A box around its origin."""

    size: Vector


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z around its origin."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball around its origin."""

    radius: float


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A mesh in a file of the model's folder."""

    name: str
    scale: Vector = (1.0, 1.0, 1.0)


Geometry = Box | Cylinder | Sphere | MeshFile


@dataclass(frozen=True, slots=True)
class Visual:
    """One shape of a link, placed in the link's frame."""

    geometry: Geometry
    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)
    colour: Colour | None = None


@dataclass(frozen=True, slots=True)
class Mimic:
    """A joint that follows another: ``value * factor + offset``."""

    joint: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class ModelJoint:
    """How ``child`` is held by ``parent``; ``kind`` is fixed or one of ``MOVING``."""

    name: str
    kind: str
    parent: str
    child: str
    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)
    axis: Vector = (1.0, 0.0, 0.0)
    lower: float | None = None
    upper: float | None = None
    mimic: Mimic | None = None

    @property
    def moves(self) -> bool:
        """Whether it is no fixed joint."""
        return self.kind in MOVING


@dataclass(frozen=True, slots=True)
class Model:
    """A whole machine; ``joints`` stand in the order of the tree, parents first."""

    name: str
    root: str
    links: dict[str, tuple[Visual, ...]]
    joints: tuple[ModelJoint, ...]
    notices: tuple[str, ...] = field(default=())

"""What moves on a machine, what it measures, what it sees, and the site it works at.

Positions are ENU metres of the factsheet's datum; joints are radians or metres by their ``unit``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hmi.domain.stamp import Stamp

HEIGHT_GAUGES = ("height", "altitude")
"""Gauges that say how high above the ground a robot is, metres; the first one that it has counts."""


def height_m(gauges: Mapping[str, float]) -> float | None:
    """Return how high above the ground a robot is; ``None`` for one that does not say."""
    return next((gauges[key] for key in HEIGHT_GAUGES if key in gauges), None)


@dataclass(frozen=True, slots=True)
class JointInfo:
    """A joint and its limits; beyond a soft limit it warns."""

    name: str
    label: str
    unit: str
    lower: float
    upper: float
    max_rate: float
    soft_lower: float | None
    soft_upper: float | None


@dataclass(frozen=True, slots=True)
class GaugeInfo:
    """A measured value: its scale and where it is normal."""

    key: str
    label: str
    unit: str
    lower: float
    upper: float
    ok_lower: float | None
    ok_upper: float | None
    limit_text: str


@dataclass(frozen=True, slots=True)
class NodeInfo:
    """A software node the robot has, its usual rate, what must be started before it, and how often it reports."""

    name: str
    label: str
    subsystem: str
    rate_hz: float | None
    starts_after: tuple[str, ...]
    period_s: float | None = None


@dataclass(frozen=True, slots=True)
class FunctionInfo:
    """Something the robot can do; off without one of ``depends_on``, limited without one of ``better_with``."""

    name: str
    label: str
    depends_on: tuple[str, ...]
    better_with: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Sighting:
    """Somebody or something near the robot. ``kind`` is person, animal, vehicle or object."""

    id: str
    kind: str
    x_m: float
    y_m: float
    distance_m: float


@dataclass(frozen=True, slots=True)
class SeenBox:
    """Something found in a picture, in shares of it from its upper left corner; ``hit`` by the tool, if known."""

    kind: str
    x: float
    y: float
    w: float
    h: float
    score: float
    hit: bool | None


@dataclass(frozen=True, slots=True)
class Sight:
    """What was found in one picture of a camera; the stamp is when the picture was taken."""

    camera: str
    captured_ms: int
    boxes: tuple[SeenBox, ...]
    stamp: Stamp


@dataclass(frozen=True, slots=True)
class Body:
    """Joints as measured and as planned, gauges, where the tool's tip is, who is near."""

    joints: dict[str, float]
    planned: dict[str, float]
    gauges: dict[str, float]
    tool: tuple[float, float, float] | None
    is_loaded: bool | None
    stock: int | None
    seen: tuple[Sighting, ...]
    stamp: Stamp


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A stump, stone or the like, as a standing cylinder."""

    id: str
    kind: str
    x_m: float
    y_m: float
    radius_m: float
    height_m: float


@dataclass(frozen=True, slots=True)
class Target:
    """A place to work at. ``status``: planned, current, done, failed_tool, failed_ground, failed_machine, skipped."""

    id: str
    x_m: float
    y_m: float
    status: str
    text: str


@dataclass(frozen=True, slots=True)
class Worksite:
    """Where it works now; a new ``stop`` begins with an empty surface."""

    stop: int
    area: tuple[tuple[float, float], ...]
    obstacles: tuple[Obstacle, ...]
    targets: tuple[Target, ...]
    stamp: Stamp

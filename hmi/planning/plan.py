"""What the planner answers: a path in pieces, and the numbers that go with it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from hmi.planning.projection import Floats

GENTLE_RAD = math.radians(15)
"""Largest change of heading inside a leg; a larger one is a corner, where a machine must pivot."""


class LegKind(StrEnum):
    """What a leg is for; the names of the wire contract."""

    APPROACH = "approach"
    ROW = "row"
    TURN = "turn"
    HEADLAND = "headland"
    EXIT = "exit"


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """A smooth (N, 2) line driven one way; backwards, the machine's rear leads."""

    points: Floats
    is_backward: bool = False

    @property
    def length_m(self) -> float:
        """Length of the line."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """One smooth piece of path. ``points`` is (N, 2) metres in the plan's plane, N >= 2, in driving order.

    ``row`` counts from 1 in driving order and is 0 off the rows. ``pivot``: stop before this leg and turn on
    the spot to its first direction. ``dose`` is times the usual one. ``is_continued``: a piece of the row or lap
    that the leg before it belongs to. ``is_backward``: the machine's rear leads; where that changes it stops.
    """

    kind: LegKind
    points: Floats
    speed_mps: float
    tool_on: bool = False
    row: int = 0
    pivot: bool = False
    dose: float = 1.0
    is_continued: bool = False
    is_backward: bool = False

    @property
    def length_m(self) -> float:
        """Length of the leg."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    @property
    def first_heading_rad(self) -> float:
        """Heading of the machine where the leg begins."""
        return _heading(self.points[0], self.points[1]) + math.pi * self.is_backward

    @property
    def last_heading_rad(self) -> float:
        """Heading of the machine where the leg ends."""
        return _heading(self.points[-2], self.points[-1]) + math.pi * self.is_backward


@dataclass(frozen=True, slots=True)
class Figures:
    """Numbers of a plan, SI.

    Areas: field, to be treated, worked, worked twice, to be treated and not worked, inner field (behind the
    headland) and worked of it.
    """

    length_m: float
    working_length_m: float
    duration_s: float
    working_s: float
    rows: int
    turns: int
    pivots: int
    area_m2: float
    covered_m2: float
    overlap_m2: float
    inner_m2: float
    inner_covered_m2: float
    energy_j: float
    battery_share: float
    angle_rad: float
    headland_passes: int
    wanted_m2: float
    missed_m2: float
    reversals: int = 0
    """Stops to drive the other way."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A complete path. ``notes`` are sentences about what the plan leaves out, for the planner to read."""

    legs: tuple[Leg, ...]
    figures: Figures
    notes: tuple[str, ...] = ()


def turn_between(before: Leg, after: Leg) -> float:
    """Return the signed change of heading from the end of one leg to the start of the next."""
    return math.remainder(after.first_heading_rad - before.last_heading_rad, 2 * math.pi)


def is_cusp(before: Leg, after: Leg) -> bool:
    """Say whether the machine stops between two legs to drive the other way."""
    return before.is_backward is not after.is_backward


def headings(points: Floats) -> Floats:
    """Return the heading of each of the N-1 pieces of an (N, 2) polyline."""
    steps = np.diff(points, axis=0)
    return np.arctan2(steps[:, 1], steps[:, 0])


def poses_along(points: Floats, step_m: float, *, is_backward: bool = False) -> Floats:
    """Return (M, 3) poses along a polyline, every vertex with both its headings, no further apart than ``step_m``.

    Headings are the machine's: driven backwards, against the line.
    """
    parts = []
    against = math.pi * is_backward
    for (x0, y0), (x1, y1), heading in zip(points[:-1], points[1:], headings(points), strict=True):
        count = max(1, math.ceil(math.hypot(x1 - x0, y1 - y0) / step_m))
        t = np.linspace(0.0, 1.0, count + 1)
        parts.append(np.column_stack([x0 + t * (x1 - x0), y0 + t * (y1 - y0), np.full(count + 1, heading + against)]))
    return np.vstack(parts)


def _heading(a: Floats, b: Floats) -> float:
    return math.atan2(b[1] - a[1], b[0] - a[0])

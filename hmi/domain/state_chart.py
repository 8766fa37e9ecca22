"""A robot's supervisor as data: nested states, parallel regions, transitions, and which states are active.

The robot declares it in its factsheet; nothing here knows any particular machine.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ChartState:
    """One state. ``kind`` is simple, composite, parallel, region or final; a parallel state's children are regions.

    ``normal_s`` is the usual time in it, ``None`` where there is none.
    """

    id: str
    label: str
    parent: str | None
    kind: str
    is_initial: bool
    subsystem: str
    normal_s: float | None
    entry: tuple[str, ...]
    exit: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ChartTransition:
    """A change of state: what causes it and what must be true."""

    source: str
    target: str
    event: str
    guard: str


@dataclass(frozen=True, slots=True)
class Chart:
    """All states and transitions, in the robot's order."""

    states: tuple[ChartState, ...]
    transitions: tuple[ChartTransition, ...]


@dataclass(frozen=True, slots=True)
class ActiveState:
    """A state that is active, and since when on the console's monotonic clock."""

    id: str
    since_s: float


@dataclass(frozen=True, slots=True)
class LastTransition:
    """The newest change of state, on the console's monotonic clock."""

    source: str
    target: str
    event: str
    result: str
    at_s: float

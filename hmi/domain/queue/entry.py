"""One place in a robot's queue: which mission, when, under which conditions, and whether a person has to start it."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum

from hmi.domain.queue.repeat import Repeat

WINDOW_S = 900  # a quarter of an hour: later than that, whoever planned the time reckons with something else
MAX_WINDOW_S = 86_400


class EntryState(StrEnum):
    """Where an entry is in its own life; the mission has one beside it."""

    OPEN = "open"
    DONE = "done"
    ENDED = "ended"
    REMOVED = "removed"


@dataclass(frozen=True, slots=True)
class Conditions:
    """What must hold before the queue starts a mission by itself; ``None`` asks nothing.

    Args:
        rain_below_mm_h, wind_below_mps: limits that must not be reached.
        needs_daylight: between sunrise and sunset, shortened by the two offsets in seconds.
        battery_reserve: share of a full battery that must be left after the mission.
        battery_min: state of charge at the start, 0 to 1.
        needs_rtk: a fixed position solution.
        needs_treatment_weather: what field stations measure is within the farm's treatment limits.
    """

    rain_below_mm_h: float | None = None
    wind_below_mps: float | None = None
    needs_daylight: bool = False
    after_sunrise_s: int = 0
    before_sunset_s: int = 0
    battery_reserve: float | None = 0.15
    battery_min: float | None = None
    needs_rtk: bool = True
    needs_treatment_weather: bool = False


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry; times aware UTC.

    Args:
        position: order in the robot's queue, growing.
        is_unattended: the queue starts it; else it is sent and a person starts it.
        earliest: not before; ``None`` as soon as it is its turn.
        window_s: how much later than ``earliest`` the queue may still start it.
        place: longitude and latitude of the field, for daylight.
        started_at: when the robot began to drive it.
        why: why it ended.
    """

    id: str
    farm_id: str
    robot_id: str
    mission_id: str
    position: int
    added_by: str
    added_at: datetime
    is_unattended: bool = False
    earliest: datetime | None = None
    window_s: int = WINDOW_S
    repeat: Repeat | None = None
    conditions: Conditions = field(default_factory=Conditions)
    place: tuple[float, float] | None = None
    state: EntryState = EntryState.OPEN
    started_at: datetime | None = None
    ended_at: datetime | None = None
    why: str = ""

    @property
    def is_open(self) -> bool:
        """Whether it still waits, or runs."""
        return self.state is EntryState.OPEN

    def is_due(self, now: datetime) -> bool:
        """Say whether its time has come; one without a time is always due."""
        return self.earliest is None or now >= self.earliest

    def is_missed(self, now: datetime) -> bool:
        """Say whether the queue is too late to start it."""
        return self.earliest is not None and (now - self.earliest).total_seconds() > self.window_s

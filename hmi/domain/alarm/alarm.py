"""One alarm as it stands: what the process says, what people answered, and what keeps it from being shown.

Two things are kept apart. ``phase`` is the life between condition and answer; it goes on whatever is shown.
Over it lie shelving, suppression by design and out of service, which change only what a person sees.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from hmi.domain.alarm.priority import Priority

CONSOLE = "console"
"""Source of alarms about the console itself."""


class Phase(StrEnum):
    """The life of an alarm between its condition and the answers of people."""

    NORMAL = "normal"
    UNACKNOWLEDGED = "unacknowledged"
    ACKNOWLEDGED = "acknowledged"
    RETURNED = "returned"
    """The condition is gone and nobody has seen it."""
    LATCHED = "latched"
    """The condition is gone and seen; somebody has to clear it."""


class AlarmState(StrEnum):
    """What a person is shown."""

    NORMAL = "normal"
    UNACKNOWLEDGED = "unacknowledged"
    ACKNOWLEDGED = "acknowledged"
    RETURNED = "returned"
    LATCHED = "latched"
    SHELVED = "shelved"
    SUPPRESSED = "suppressed"
    OUT_OF_SERVICE = "out_of_service"


@dataclass(frozen=True, slots=True)
class AlarmKey:
    """What an alarm is about: its type, the robot, node or station it comes from, and which one of several."""

    code: str
    source: str
    detail: str = ""

    @property
    def id(self) -> str:
        """The name of the alarm outside: ``link-lost.weeder-07``, ``node-failed.weeder-07.planner``."""
        return ".".join(part for part in (self.code, self.source, self.detail) if part)


@dataclass(frozen=True, slots=True)
class Shelf:
    """Put aside by a person for a while; it comes back by itself."""

    by: str
    reason: str
    at: datetime
    until: datetime


@dataclass(frozen=True, slots=True)
class OutOfService:
    """Taken out until somebody puts it back, for instance while a sensor is repaired.

    Args:
        holds_critical: whoever took it out may do so with priority 1 too, so it stays out if it becomes that.
    """

    by: str
    reason: str
    at: datetime
    holds_critical: bool = False


@dataclass(frozen=True, slots=True)
class Alarm:
    """One alarm; times aware UTC.

    Args:
        is_latching: stays until a person clears it, also when the condition is gone.
        text: what is so now, with values: ``Wind 11.4 m/s, limit 11.0``.
        raised_at: when the present, or last, occurrence began; ``None`` never.
        returned_at: when its condition went away.
        seen_by, seen_at: who acknowledged the present occurrence.
        suppressed_by: keys of causes that make this alarm say nothing new, or names of designed states.
        occurrences: how often it was raised since it was last normal.
        priority: where the source itself says how urgent it is; else that of its type counts.
        advice: what the source itself says can be done.
    """

    key: AlarmKey
    is_latching: bool = False
    phase: Phase = Phase.NORMAL
    text: str = ""
    raised_at: datetime | None = None
    returned_at: datetime | None = None
    seen_by: str = ""
    seen_at: datetime | None = None
    shelf: Shelf | None = None
    suppressed_by: frozenset[str] = frozenset()
    out_of_service: OutOfService | None = None
    occurrences: int = 0
    priority: Priority | None = None
    advice: str = ""

    @property
    def is_active(self) -> bool:
        """Whether its condition holds."""
        return self.phase in (Phase.UNACKNOWLEDGED, Phase.ACKNOWLEDGED)

    @property
    def needs_seeing(self) -> bool:
        """Whether nobody has acknowledged the present occurrence."""
        return self.phase in (Phase.UNACKNOWLEDGED, Phase.RETURNED)

    @property
    def state(self) -> AlarmState:
        """What is shown: the strongest of what lies over the phase, else the phase."""
        if self.out_of_service is not None:
            return AlarmState.OUT_OF_SERVICE
        if self.suppressed_by:
            return AlarmState.SUPPRESSED
        if self.shelf is not None:
            return AlarmState.SHELVED
        return AlarmState(self.phase.value)

    @property
    def is_aside(self) -> bool:
        """Whether it is shelved, suppressed or out of service."""
        return self.state.value != self.phase.value

    @property
    def is_annunciated(self) -> bool:
        """Whether it asks for attention now: listed as active, and heard if it is not acknowledged."""
        return self.phase is not Phase.NORMAL and not self.is_aside

    @property
    def awaits_answer(self) -> bool:
        """Whether it is shown and nobody has acknowledged it."""
        return self.is_annunciated and self.needs_seeing

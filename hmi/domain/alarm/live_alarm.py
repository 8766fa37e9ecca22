"""An alarm with what the console adds to its life: which group it stands in, whether it waits too long."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from hmi.domain.alarm.alarm import Alarm
from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.priority import Priority


class What(StrEnum):
    """A step in the life of an alarm, as the journal and the screens name it."""

    RAISED = "raised"
    RETURNED = "returned"
    ACKNOWLEDGED = "acknowledged"
    CLEARED = "cleared"
    SHELVED = "shelved"
    UNSHELVED = "unshelved"
    SUPPRESSED = "suppressed"
    UNSUPPRESSED = "unsuppressed"
    OUT_OF_SERVICE = "out_of_service"
    IN_SERVICE = "in_service"
    ESCALATED = "escalated"


@dataclass(frozen=True, slots=True)
class LiveAlarm:
    """One alarm as it is listed.

    Args:
        raised_s: when it was raised, on the console's monotonic clock.
        unanswered_at, unanswered_s: since when it is shown and waits for an answer, on the wall clock and on the
            monotonic one; ``None`` while it does not. It waits on when it comes back before anybody saw it.
        first: id of the first-out alarm of its group; ``place`` counts from 1 in a group of ``group``.
        escalated_at: when it had waited too long for an answer.
    """

    alarm: Alarm
    type: AlarmType
    raised_s: float
    unanswered_at: datetime | None = None
    unanswered_s: float = 0.0
    is_chattering: bool = False
    first: str = ""
    place: int = 1
    group: int = 1
    escalated_at: datetime | None = None

    @property
    def id(self) -> str:
        """Its id outside."""
        return self.alarm.key.id

    @property
    def priority(self) -> Priority:
        """How urgent it is: what its source says where the type leaves it open, else its type's."""
        return self.alarm.priority or self.type.priority


@dataclass(frozen=True, slots=True)
class Step:
    """One step in the life of one alarm, for the journal; ``by`` is a person, or empty for the console.

    Args:
        unanswered_at: since when it waited for an answer before this step.
        rose_from: the priority before, where one that was active already is raised anew because it is more urgent.
    """

    what: What
    live: LiveAlarm
    at: datetime
    by: str = ""
    device: str = ""
    text: str = ""
    unanswered_at: datetime | None = None
    rose_from: Priority | None = None

"""Something that happened on a robot at one moment; never conflated, kept once by robot and id."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from hmi.domain.robot import Stamp


@dataclass(frozen=True, slots=True)
class RobotEvent:
    """One event.

    ``kind`` is what the wire says (state_entered, state_left, alarm_raised, alarm_cleared, treatment, mission, safety)
    or ``mode``, which the recorder adds. ``at_utc`` is the wall clock of the console mapped back to when it happened;
    ``stamp`` is the same on the monotonic clock, ``None`` for events read back from the history.
    """

    robot_id: str
    event_id: str
    kind: str
    name: str
    text: str
    data: dict[str, Any] = field(default_factory=dict)
    at_utc: datetime = field(kw_only=True)
    stamp: Stamp | None = field(default=None, kw_only=True)
    mission_id: str | None = field(default=None, kw_only=True)

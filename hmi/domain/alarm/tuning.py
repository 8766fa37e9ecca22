"""How a farm sets an alarm type apart from the catalogue: delays, limit and dead-band, within bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.priority import Priority
from hmi.domain.alarm.steady import Limit

MOST_ON_S, MOST_ON_CRITICAL_S = 600.0, 5.0  # an alarm that waits longer is switched off in all but name
MOST_OFF_S = 3600.0
LEAST_SHARE, MOST_SHARE = 0.2, 5.0  # of the limit in the catalogue


class BadTuning(ValueError):
    """It cannot be used.

    Args:
        text: one sentence for a person.
        field: which value.
    """

    def __init__(self, text: str, field: str) -> None:
        super().__init__(text)
        self.text, self.field = text, field


@dataclass(frozen=True, slots=True)
class Tuning:
    """What is set of one type.

    Args:
        on_s, off_s: how long the condition lasts, and is gone, before it counts.
        at, deadband: limit of the measured value and its dead-band, ``None`` where the type has none.
    """

    on_s: float
    off_s: float
    at: float | None = None
    deadband: float | None = None


def shipped(kind: AlarmType) -> Tuning:
    """Return what the catalogue says of a type."""
    limit = kind.limit
    return Tuning(kind.on_s, kind.off_s, limit.at if limit else None, limit.deadband if limit else None)


def most_on_s(kind: AlarmType) -> float:
    """Return how long a condition may be made to last before it counts."""
    return MOST_ON_CRITICAL_S if kind.priority is Priority.CRITICAL else MOST_ON_S


def tuned(kind: AlarmType, to: Tuning) -> AlarmType:
    """Return a type of the catalogue with other values.

    Raises:
        BadTuning: a value is out of bounds, or the type has no limit.
    """
    _check("on_s", to.on_s, most_on_s(kind), "The delay")
    _check("off_s", to.off_s, MOST_OFF_S, "The time until it is gone")
    if kind.limit is None:
        if to.at is not None or to.deadband is not None:
            raise BadTuning("This alarm has no limit.", "at")
        return replace(kind, on_s=to.on_s, off_s=to.off_s)
    at, deadband = to.at, to.deadband if to.deadband is not None else 0.0
    least, most = bounds(kind.limit)
    if at is None or not math.isfinite(at) or not least <= at <= most:
        raise BadTuning(f"The limit is between {least:g} and {most:g} {kind.unit}.", "at")
    if not math.isfinite(deadband) or not 0 <= deadband < at:
        raise BadTuning("The dead-band is 0 or more, and less than the limit.", "deadband")
    return replace(kind, on_s=to.on_s, off_s=to.off_s, limit=Limit(at, deadband, kind.limit.is_lower))


def bounds(limit: Limit) -> tuple[float, float]:
    """Return the least and the most a limit of the catalogue may be set to."""
    return round(limit.at * LEAST_SHARE, 4), round(limit.at * MOST_SHARE, 4)


def _check(field: str, value_s: float, most_s: float, what: str) -> None:
    if not math.isfinite(value_s) or not 0 <= value_s <= most_s:
        raise BadTuning(f"{what} is between 0 and {most_s:g} s.", field)

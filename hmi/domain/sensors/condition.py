"""A station as a guided check looks at it."""

from __future__ import annotations

from dataclasses import dataclass

from hmi.domain.sensors.freshness import State


@dataclass(frozen=True, slots=True)
class StationCondition:
    """How one station does.

    Args:
        skew_s: how far its clock seems to be ahead.
        implausible: values that cannot be, in words.
        others, others_heard: the other accepted stations, and how many of them are heard.
    """

    name: str
    state: State
    age_s: float | None
    battery: float | None = None
    skew_s: float = 0.0
    is_clock_wrong: bool = False
    implausible: tuple[str, ...] = ()
    others: int = 0
    others_heard: int = 0

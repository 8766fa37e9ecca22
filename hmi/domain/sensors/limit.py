"""Limits of measured values: those that treatment has to keep, and those that only warn."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime

from hmi.domain.sensors.quantity import Channel


@dataclass(frozen=True, slots=True)
class SensorLimit:
    """From ``low`` to ``high`` is good, both included, in the unit of the wire; ``None`` asks nothing.

    Args:
        is_treatment: treatment waits while a value is beyond it.
    """

    channel: Channel
    low: float | None = None
    high: float | None = None
    is_treatment: bool = False
    note: str = ""
    by: str = ""
    at: datetime | None = None

    def is_over(self, value: float) -> bool:
        """Say whether a value is beyond it."""
        return (self.low is not None and value < self.low) or (self.high is not None and value > self.high)

    def sentence(self, value: float, label: str = "") -> str:
        """Return ``Wind 6.1 m/s, limit 5.0``; ``label`` instead of that of the limit."""
        about = self.channel.about()
        bound = self.low if self.low is not None and value < self.low else self.high
        shown = "" if bound is None else f", limit {bound * about.factor:.{about.digits}f}"
        return f"{label or self.channel.label} {about.text(value)}{shown}"


def revision_of(limits: Iterable[SensorLimit]) -> str:
    """Return a mark that changes with any of the limits, empty for none."""
    said = sorted(repr(one) for one in limits)
    return hashlib.sha256("\n".join(said).encode()).hexdigest()[:16] if said else ""


def limit_for(limits: Iterable[SensorLimit], channel: Channel) -> SensorLimit | None:
    """Return the limit of a channel; one without a depth holds for every depth that has none of its own."""
    found = None
    for one in limits:
        if one.channel == channel:
            return one
        if one.channel.quantity == channel.quantity and one.channel.depth_cm is None:
            found = one
    return found

"""When a value was true and when the console had it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Stamp:
    """When something was true and when we heard it.

    ``source_s`` is the robot's own time mapped on the console's monotonic clock (see
    ``hmi.domain.freshness.ClockMap``), so that a burst of held frames keeps its true age.
    """

    source_s: float
    received_s: float

"""Delays of the last minutes as median and 99th percentile."""

from __future__ import annotations

import statistics
from collections import deque
from dataclasses import dataclass

KEPT = 2000


@dataclass(frozen=True, slots=True)
class Delay:
    """Seconds; ``None`` where nothing was measured."""

    mean_s: float | None = None
    p50_s: float | None = None
    p99_s: float | None = None
    count: int = 0


class Delays:
    """The newest delays of one way.

    Args:
        kept: how many.
    """

    def __init__(self, kept: int = KEPT) -> None:
        self._found: deque[float] = deque(maxlen=kept)

    def add(self, delay_s: float) -> None:
        """Take one; clocks are matched to some milliseconds, so one before its time counts as none."""
        self._found.append(max(0.0, delay_s))

    def told(self) -> Delay:
        """Return what they are."""
        if not self._found:
            return Delay()
        found = sorted(self._found)
        last = len(found) - 1
        mean_s = statistics.fmean(found)
        return Delay(mean_s, found[round(0.5 * last)], found[round(0.99 * last)], len(found))

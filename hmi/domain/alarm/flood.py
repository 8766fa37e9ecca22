"""More alarms than a person can read: ten in ten minutes (ISA-18.2). Decides when a flood begins and ends."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

WINDOW_S = 600.0
BEGINS_AT, ENDS_BELOW = 10, 5


@dataclass(slots=True)
class Flood:
    """Counts alarms of one operator's desk; times in seconds of one monotonic clock."""

    _raised: deque[float] = field(default_factory=deque, init=False)
    since_s: float | None = field(default=None, init=False)

    @property
    def is_on(self) -> bool:
        """Whether there is a flood."""
        return self.since_s is not None

    def raised(self, now_s: float) -> bool:
        """Count an alarm; return whether there is a flood now."""
        self._raised.append(now_s)
        return self.pass_time(now_s)

    def pass_time(self, now_s: float) -> bool:
        """Return whether there is a flood now."""
        while self._raised and now_s - self._raised[0] >= WINDOW_S:
            self._raised.popleft()
        if self.since_s is None and len(self._raised) >= BEGINS_AT:
            self.since_s = now_s
        elif self.since_s is not None and len(self._raised) < ENDS_BELOW:
            self.since_s = None
        return self.is_on

    def count(self, now_s: float) -> int:
        """Return how many came in the last ten minutes."""
        self.pass_time(now_s)
        return len(self._raised)

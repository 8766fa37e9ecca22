"""At most so many a second, out of what comes more often, without losing time to rounding."""

from __future__ import annotations

EARLY = 0.3  # of a period: pictures never come to the millisecond


class Pace:
    """Says of each picture whether it is due. Times on one monotonic clock, seconds."""

    def __init__(self, fps: float) -> None:
        self._period_s = 1.0 / fps
        self._due_s: float | None = None

    def is_due(self, now_s: float) -> bool:
        """Return whether a picture that comes now is one of those to send."""
        due_s = now_s if self._due_s is None else self._due_s
        if now_s < due_s - EARLY * self._period_s:
            return False
        self._due_s = max(due_s, now_s - self._period_s) + self._period_s
        return True

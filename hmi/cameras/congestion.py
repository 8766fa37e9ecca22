"""Asks less of a line on which pictures wait: fewer fresh pictures are worth more than many old ones."""

from __future__ import annotations

WAITS_MS = 1000.0  # a picture that waited so long is frozen already when it comes
LASTS_MS = 2000.0  # a gap in the radio is over by then, and its burst of held pictures with it
AT_LEAST_MS = 10_000.0  # once the least is asked for, only what waits is thrown away, and not all the time
CALM_MS, MOST_CALM_MS = 60_000.0, 960_000.0
LEAST_SHARE = 0.25
LEAST_FPS = 2.5  # fewer would be a slow camera, whose pictures freeze later


class Congestion:
    """What share of the wanted pictures one line carries. Times in ms on one monotonic clock."""

    def __init__(self, share: float = 1.0) -> None:
        self.share = share
        self.renewals = 0
        """Counts when the source is to be opened anew: that throws away what waits in the robot."""
        self._full_ms: float | None = None
        self._calm_ms = 0.0
        self._patience_ms = CALM_MS / 2

    def note(self, waited_ms: float, at_ms: float) -> None:
        """Take how long a picture waited on its way."""
        if waited_ms <= WAITS_MS:
            self._full_ms = None
            if at_ms - self._calm_ms >= self._patience_ms:
                self._calm_ms = at_ms
                self._more()
            return
        self._calm_ms = at_ms
        if self._full_ms is None:
            self._full_ms = at_ms
        if at_ms - self._full_ms >= (LASTS_MS if self.share > LEAST_SHARE else AT_LEAST_MS):
            self._full_ms = None
            self.share = max(LEAST_SHARE, self.share / 2)
            self._patience_ms = min(MOST_CALM_MS, 2 * self._patience_ms)  # one that never carries more is seldom tried
            self.renewals += 1

    def fps(self, wanted: float) -> float:
        """Return how many pictures a second are asked for where so many are wanted."""
        return max(min(wanted, LEAST_FPS), wanted * self.share)

    def _more(self) -> None:
        if self.share < 1.0:
            self.share = min(1.0, 2 * self.share)
        else:
            self._patience_ms = CALM_MS / 2

"""From a restless condition to one that can be trusted: limits with a dead-band, delays, chattering.

All times are seconds of one monotonic clock, handed in.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

CHATTER_TIMES, CHATTER_S = 3, 60.0  # three times a minute is chattering, after EEMUA 191
QUIET_S = 60.0


@dataclass(frozen=True, slots=True)
class Limit:
    """A limit of a measured value; it is passed at ``at`` and left ``deadband`` before it.

    Raises:
        ValueError: the dead-band is negative or a value is not finite.
    """

    at: float
    deadband: float = 0.0
    is_lower: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.at) and math.isfinite(self.deadband) and self.deadband >= 0):
            raise ValueError("a limit is a finite number with a dead-band of 0 or more")

    def is_passed(self, value: float | None, *, was_passed: bool) -> bool:
        """Say whether the value is past the limit; one that is not known stays as it was."""
        if value is None or not math.isfinite(value):
            return was_passed
        sign = -1.0 if self.is_lower else 1.0
        beyond = sign * value
        return beyond >= sign * self.at or (was_passed and beyond > sign * self.at - self.deadband)


@dataclass(slots=True)
class Steady:
    """A condition that has to last before it counts, and to be gone a while before it is gone.

    Args:
        on_s, off_s: how long it has to last.
    """

    on_s: float = 0.0
    off_s: float = 0.0
    is_on: bool = False
    _since: tuple[bool, float] | None = field(default=None, init=False)

    def see(self, *, is_so: bool, now_s: float, most_on_s: float = math.inf) -> bool:
        """Take in the raw condition; return the steady one.

        Args:
            most_on_s: bound of ``on_s`` this time.
        """
        if is_so == self.is_on:
            self._since = None
            return self.is_on
        if self._since is None or self._since[0] != is_so:
            self._since = (is_so, now_s)
        if now_s - self._since[1] >= (min(self.on_s, most_on_s) if is_so else self.off_s):
            self.is_on, self._since = is_so, None
        return self.is_on

    def due_s(self) -> float | None:
        """Return when it may change without anything new being seen."""
        if self._since is None:
            return None
        is_so, since_s = self._since
        return since_s + (self.on_s if is_so else self.off_s)


@dataclass(slots=True)
class Chatter:
    """Notices an alarm that comes and goes, and holds it until it was quiet for a minute."""

    _raised: deque[float] = field(default_factory=lambda: deque(maxlen=CHATTER_TIMES), init=False)
    _last_s: float = field(default=-math.inf, init=False)
    is_chattering: bool = field(default=False, init=False)

    def changed(self, *, is_on: bool, now_s: float) -> None:
        """Note that the condition came or went."""
        self._last_s = now_s
        if is_on:
            self._raised.append(now_s)
            if len(self._raised) == CHATTER_TIMES and now_s - self._raised[0] <= CHATTER_S:
                self.is_chattering = True

    def pass_time(self, now_s: float) -> bool:
        """Return whether it chatters still; it ends after a minute without a change."""
        if self.is_chattering and now_s - self._last_s >= QUIET_S:
            self.is_chattering = False
            self._raised.clear()
        return self.is_chattering

    def is_remembered(self, now_s: float) -> bool:
        """Say whether a change was so lately that the next one could make it chatter."""
        return now_s - self._last_s < CHATTER_S

"""The two clocks: aware UTC for facts, monotonic seconds for durations; both can be faked."""

from __future__ import annotations

import time
from datetime import UTC, datetime, timedelta
from typing import Protocol

_BOOT_TIME: int | None = getattr(time, "CLOCK_BOOTTIME", None)  # Linux; its monotonic clock stands while it sleeps


def mono_s() -> float:
    """Return the machine's monotonic clock, the same in all of its processes; on Linux it goes on while it sleeps.

    Whatever was true before the machine slept is old when it wakes, so nothing from then is taken for fresh.
    """
    return time.monotonic() if _BOOT_TIME is None else time.clock_gettime(_BOOT_TIME)


class Clock(Protocol):
    """Where the time comes from."""

    def utc(self) -> datetime:
        """Return the wall clock, aware, UTC. For people and records, never for rules."""
        ...

    def mono_s(self) -> float:
        """Return a clock that never jumps, in seconds from an arbitrary start."""
        ...


class SystemClock:
    """The machine's clocks."""

    def utc(self) -> datetime:
        """See ``Clock``."""
        return datetime.now(UTC)

    def mono_s(self) -> float:
        """See ``Clock``."""
        return mono_s()


class FakeClock:
    """A clock that moves only when told; wall and monotonic move apart if asked."""

    def __init__(self, start: datetime | None = None) -> None:
        self._utc = start or datetime(2026, 5, 4, 12, tzinfo=UTC)
        self._mono_s = 1000.0

    def utc(self) -> datetime:
        """See ``Clock``."""
        return self._utc

    def mono_s(self) -> float:
        """See ``Clock``."""
        return self._mono_s

    def advance(self, seconds: float) -> None:
        """Let both clocks run for ``seconds``."""
        self._mono_s += seconds
        self._utc += timedelta(seconds=seconds)

    def jump_wall(self, seconds: float) -> None:
        """Set the wall clock off by ``seconds``, as NTP or a person would."""
        self._utc += timedelta(seconds=seconds)

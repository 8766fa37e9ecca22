"""How old a value is, on clocks that never have to agree.

Three clocks meet here: the robot's monotonic clock (its zero is its boot), the console's monotonic clock and
the browser's. Wall clocks take no part, but for one: where the console's own runs ahead, its machine was paused.
All times are seconds unless the name says ``_ms``.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

FAST_PERIOD_S = 0.5  # streams of 2 Hz and more share one set of limits
LATE_S, STALE_S, LOST_S = 1.0, 2.0, 3.5  # safety.md: clock glyph, hatched, banner
LATE_PERIODS, STALE_PERIODS = 1.5, 3.0  # slower streams: one and a half, and three, missed periods
WALL_AHEAD_S = 2.0  # the wall clock runs ahead of the monotonic one by no more unless the machine was paused
TICK_MAX_AGE_S = 2.0  # an order that echoes an older tick was decided on an old picture
WINDOW_BUCKETS, BUCKET_S = 12, 5.0  # one minute of hearing; 200 ppm of drift is 12 ms of it
CLOCK_JUMP_MARGIN_S = 0.25  # jitter of a loaded machine that is not yet a jump of the robot's clock


class Freshness(StrEnum):
    """What an operator may take a value for."""

    FRESH = "fresh"
    LATE = "late"
    STALE = "stale"
    LOST = "lost"
    MISSING = "missing"


def freshness(age_s: float | None, period_s: float = FAST_PERIOD_S) -> Freshness:
    """Judge a value by its age and the period its stream declares.

    Slow streams are never ``lost``: whether the link is lost is told by the heartbeat, which is fast.
    """
    if age_s is None:
        return Freshness.MISSING
    is_fast = period_s <= FAST_PERIOD_S
    if is_fast and age_s >= LOST_S:
        return Freshness.LOST
    if age_s >= (STALE_S if is_fast else STALE_PERIODS * period_s):
        return Freshness.STALE
    if age_s >= (LATE_S if is_fast else LATE_PERIODS * period_s):
        return Freshness.LATE
    return Freshness.FRESH


@dataclass(slots=True)
class _Bucket:
    """Smallest ``received - source`` of one stretch of hearing, and when the stretch began."""

    began_s: float
    least_s: float


class ClockMap:
    """Maps one robot's monotonic clock, per boot, on the console's.

    The smallest ``received - source`` of the last minute of hearing is the offset: a frame can be late, never
    early, so the fastest frame of the window tells the clocks apart and every other frame shows its true age.
    The window counts only time in which the robot was heard: after a silence the old buckets still stand, so
    that a burst of held frames is not taken for fresh. Old buckets fall out one by one, which follows drift.
    """

    def __init__(self) -> None:
        self._boot: str | None = None
        self._buckets: deque[_Bucket] = deque(maxlen=WINDOW_BUCKETS)
        self._least_s = 0.0

    @property
    def boot(self) -> str | None:
        """The boot being mapped; ``None`` until the first frame."""
        return self._boot

    def observe(self, boot: str, mono_ms: int, received_s: float) -> float:
        """Take one live frame into account and return when it was made, on the console's clock."""
        offset_s = received_s - mono_ms / 1000
        if boot != self._boot:
            self._restart(boot, received_s, offset_s)
        elif received_s - self._buckets[-1].began_s >= BUCKET_S:
            self._buckets.append(_Bucket(received_s, offset_s))
            self._least_s = min(b.least_s for b in self._buckets)
        elif offset_s < self._buckets[-1].least_s:
            self._buckets[-1].least_s = offset_s
            self._least_s = min(self._least_s, offset_s)
        return mono_ms / 1000 + self._least_s

    def confirm(self, boot: str, mono_ms: int, received_s: float, rtt_s: float) -> float:
        """Use a measured round trip as the upper bound of this frame's age; return when it was made.

        A frame that answers our ping cannot be older than the ping. If the window says so, the robot's clock
        stood still (suspended machine) or the window is from another life: it is dropped.
        """
        source_s = self.observe(boot, mono_ms, received_s)
        if received_s - source_s > max(rtt_s, 0.0) + CLOCK_JUMP_MARGIN_S:
            self._restart(boot, received_s, received_s - mono_ms / 1000)
            source_s = received_s
        return source_s

    def source_s(self, boot: str, mono_ms: int) -> float | None:
        """Return when something was true without learning from it; ``None`` for a boot not mapped."""
        return mono_ms / 1000 + self._least_s if boot == self._boot else None

    def _restart(self, boot: str, received_s: float, offset_s: float) -> None:
        self._boot, self._least_s = boot, offset_s
        self._buckets.clear()
        self._buckets.append(_Bucket(received_s, offset_s))


@dataclass(frozen=True, slots=True)
class Tick:
    """One beat of the console: its id and when it was issued, monotonic seconds and wall clock."""

    id: str
    at_s: float
    utc: datetime


class TickRing:
    """Issues tick ids and judges the ones that come back.

    The monotonic clock of a paused virtual machine stands still, and its wall clock is put right afterwards. So a
    tick since which the wall clock ran ahead by more than 2 s is as old as the wall clock says. A wall clock that
    is set forward looks the same: what was sent just before is refused, and the next tick is judged as ever.

    Args:
        boot: names this run of the console; ids of another run are refused.
        mono_s: the console's monotonic clock.
        utc: its wall clock.
    """

    def __init__(self, boot: str, mono_s: Callable[[], float], utc: Callable[[], datetime]) -> None:
        self.boot = boot
        self._mono_s, self._utc = mono_s, utc
        self._number = 0
        self._issued: deque[Tick] = deque()

    @property
    def newest(self) -> Tick | None:
        """The tick issued last."""
        return self._issued[-1] if self._issued else None

    def issue(self) -> Tick:
        """Make the next tick."""
        self._number += 1
        now_s = self._mono_s()
        tick = Tick(f"{self.boot}-{self._number}", now_s, self._utc())
        self._issued.append(tick)
        while now_s - self._issued[0].at_s > TICK_MAX_AGE_S:
            self._issued.popleft()
        return tick

    def age_s(self, tick_id: str) -> float | None:
        """Return the age of a tick; ``None`` if it is of another run, was never issued or is too old to know."""
        boot, _, digits = tick_id.rpartition("-")
        if boot != self.boot or not self._issued or not (digits.isascii() and digits.isdigit()) or len(digits) > 16:
            return None
        behind = self._number - int(digits)
        if not 0 <= behind < len(self._issued):
            return None
        tick = self._issued[-1 - behind]
        if tick.id != tick_id:
            return None
        age_s, wall_s = self._mono_s() - tick.at_s, (self._utc() - tick.utc).total_seconds()
        return wall_s if wall_s - age_s > WALL_AHEAD_S else age_s

    def is_fresh(self, tick_id: str) -> bool:
        """Say whether an order that echoes ``tick_id`` was decided on a picture at most 2 s old."""
        age_s = self.age_s(tick_id)
        return age_s is not None and age_s <= TICK_MAX_AGE_S

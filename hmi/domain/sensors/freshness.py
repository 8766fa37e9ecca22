"""How old what a station said is: by the console's own monotonic clock, and by when the station measured.

A station's clock may be wrong in either direction, and what it sends may have waited in its memory.
So a value's age when it arrives is taken as large as either can make it:
the delay the two wall clocks show, and that plus the lead of a clock that was seen to run ahead.
A clock that runs behind therefore makes values look old, and one that runs ahead makes none look fresh.
Where a delay leaps, the clock was set or values waited, and nobody can tell which: no decision goes by them before the
next message comes as late as the one before. A station that tells its monotonic clock, too, shows which of the two it
was: then a lead goes as its clock is set right, at once or slowly.
"""

from __future__ import annotations

from collections import OrderedDict, deque
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from enum import StrEnum

LATE_PERIODS, SILENT_PERIODS = 1.5, 3.0
USABLE_MOST_S = 900.0  # as long as the queue goes by a report of the weather, whatever period a station declares
CLOCK_WRONG_S = 60.0
STEP_S = 2.0  # the console's wall clock was set, and did not just drift
RECENT = 8  # messages whose delays are compared: what comes late by now is believed to be late after so many
FADE = 0.01  # of the time it is heard, a lead is forgotten: clocks drift, and small steps back leave no other trace
STEADY_PERIODS = 0.5  # messages whose delays differ by more do not come alike: one waited, or the clock was set
KEPT_S = 14 * 86_400.0  # what waited longer is not kept: its time is rather wrong
BOOTS, SEEN = 4, 256  # remembered of one station


class State(StrEnum):
    """How far a value or a station can be relied on."""

    FRESH = "fresh"
    LATE = "late"
    SILENT = "silent"
    NEVER = "never"


def state_of(age_s: float | None, period_s: float) -> State:
    """Judge an age; ``None`` was never heard."""
    if age_s is None:
        return State.NEVER
    if age_s > silent_after_s(period_s):
        return State.SILENT
    return State.LATE if age_s > LATE_PERIODS * period_s else State.FRESH


def silent_after_s(period_s: float) -> float:
    """Return the age from which on a station counts as silent."""
    return SILENT_PERIODS * period_s


def is_usable(age_s: float, period_s: float, *, is_slow: bool = False) -> bool:
    """Say whether a decision may still go by a value of this age: never by a stale one.

    Args:
        is_slow: it changes in hours, as moisture of the soil does; weather changes in minutes.
    """
    limit_s = silent_after_s(period_s)
    return age_s <= (limit_s if is_slow else min(limit_s, USABLE_MOST_S))


class Fate(StrEnum):
    """What becomes of a message."""

    NEWEST = "newest"
    HISTORY = "history"
    REPEATED = "repeated"
    TOO_OLD = "too_old"


@dataclass(frozen=True, slots=True)
class Arrival:
    """One message judged.

    Args:
        measured_s: when it was measured at the latest, on the console's monotonic clock.
        measured_at: the same as wall time, for the history.
        skew_s: how far the station's clock seems to be ahead; below zero it is behind, or its messages come late.
        is_ahead: by boot and number nothing newer has come, whatever the clocks say.
        is_dated: its age is known well enough for a decision.
    """

    fate: Fate
    measured_s: float
    measured_at: datetime
    skew_s: float
    is_ahead: bool = False
    is_dated: bool = False


@dataclass(slots=True)
class Receipt:
    """Judges the messages of one station in the order in which they come."""

    newest_s: float = float("-inf")
    skew_s: float = 0.0
    _wall_s: float | None = None
    _delays: deque[float] = field(default_factory=lambda: deque(maxlen=RECENT))
    _lead_s: float = float("-inf")  # of the station's clock, as far as it was seen
    _delay_s: float = 0.0  # of the message before; of the first one, what a clock that is right shows
    _heard_s: float | None = None
    _utc: datetime | None = None
    _mono: tuple[str, float, float] | None = None  # boot, the station's monotonic clock and ours, of the message before
    _boots: OrderedDict[str, deque[int]] = field(default_factory=OrderedDict)
    _top: dict[str, int] = field(default_factory=dict)

    def judge(
        self,
        boot: str,
        seq: int,
        utc: datetime,
        *,
        now: datetime,
        now_s: float,
        period_s: float,
        mono_s: float | None = None,
    ) -> Arrival:
        """Judge one message.

        Args:
            utc: when the station says it measured.
            now, now_s: the console's clocks when it arrived.
            period_s: between two messages, as the station declares it.
            mono_s: when it measured by its monotonic clock, ``None`` if it does not say.
        """
        self._step(now.timestamp() - now_s)
        if self._is_repeated(boot, seq):
            return Arrival(Fate.REPEATED, now_s, now, self.skew_s)
        delay_s, is_ahead = (now - utc).total_seconds(), self._is_ahead(boot, seq)
        self._note(boot, seq)
        waited_s = self._waited_more_s(boot, mono_s, now_s) if is_ahead else None
        is_dated = is_ahead and self._follow(utc, delay_s, now_s, period_s, waited_s)
        age_s = max(0.0, delay_s + max(0.0, self._lead_s))
        if not is_ahead:  # it was measured before what is known
            age_s = max(age_s, now_s - self.newest_s)
        measured_s = now_s - age_s
        if age_s > KEPT_S:
            return Arrival(Fate.TOO_OLD, measured_s, now, self.skew_s, is_ahead)
        is_newest = is_ahead and measured_s >= self.newest_s
        if is_newest:
            self.newest_s = measured_s
        fate = Fate.NEWEST if is_newest else Fate.HISTORY
        return Arrival(fate, measured_s, now - timedelta(seconds=age_s), self.skew_s, is_ahead, is_dated)

    @property
    def is_clock_wrong(self) -> bool:
        """Whether even the quickest of the last messages does not fit the console's clock."""
        return len(self._delays) >= 2 and abs(self.skew_s) > CLOCK_WRONG_S

    def _step(self, wall_s: float) -> None:
        """Count delays from before the console's wall clock was set as that clock counts now.

        Args:
            wall_s: wall minus monotonic time of the console.
        """
        step_s = 0.0 if self._wall_s is None else wall_s - self._wall_s
        self._wall_s = wall_s
        if abs(step_s) > STEP_S:
            self._delays = deque((one + step_s for one in self._delays), maxlen=RECENT)
            self._lead_s -= step_s
            self._delay_s += 0.0 if self._heard_s is None else step_s

    def _waited_more_s(self, boot: str, mono_s: float | None, now_s: float) -> float | None:
        """Return by how much a message was longer on its way than the one before, ``None`` where nobody knows."""
        before, self._mono = self._mono, None if mono_s is None else (boot, mono_s, now_s)
        if mono_s is None or before is None or before[0] != boot or mono_s < before[1]:
            return None
        return (now_s - before[2]) - (mono_s - before[1])

    def _set(self, delay_s: float, waited_s: float, *, is_steady: bool) -> None:
        """Move what is known of the station's clock by as much as it was set since the message before.

        A lead is forgotten only as far as the delay grew, and by a message that came as the one before: a monotonic
        clock that runs wrong makes nothing look fresh.
        """
        grown_s = delay_s - self._delay_s
        ahead_s = waited_s - grown_s
        if ahead_s < 0 and not is_steady:
            return
        moved_s = ahead_s if ahead_s >= 0 else max(ahead_s, -max(0.0, grown_s))
        self._lead_s += moved_s
        self._delays = deque((one - moved_s for one in self._delays), maxlen=RECENT)

    def _follow(
        self, utc: datetime, delay_s: float, now_s: float, period_s: float, waited_s: float | None = None
    ) -> bool:
        """Take what a message that is ahead tells of the station's clock; return whether its age is known.

        Args:
            waited_s: see ``_waited_more_s``.
        """
        leapt_s = delay_s - self._delay_s if waited_s is None else waited_s
        is_dated = abs(leapt_s) <= max(STEP_S, STEADY_PERIODS * period_s)
        if waited_s is not None:
            self._set(delay_s, waited_s, is_steady=is_dated)
        elif self._utc is not None and utc < self._utc:  # measured later and called earlier: the clock was set back
            self._delays.clear()
            self._lead_s = float("-inf")
        if is_dated and self._heard_s is not None:
            self._lead_s -= FADE * min(now_s - self._heard_s, period_s)
        self._lead_s = max(self._lead_s, -delay_s)
        self._delays.append(delay_s)
        self.skew_s = self._lead_s if self._lead_s > 0.0 else -min(self._delays)
        self._utc, self._delay_s, self._heard_s = utc, delay_s, now_s
        return is_dated

    def _is_repeated(self, boot: str, seq: int) -> bool:
        return seq in self._boots.get(boot, ())

    def _is_ahead(self, boot: str, seq: int) -> bool:
        """A new boot is ahead of those before; within one the number decides."""
        if boot not in self._boots:
            return True
        return boot == next(reversed(self._boots)) and seq > self._top[boot]

    def _note(self, boot: str, seq: int) -> None:
        if boot not in self._boots:
            self._boots[boot] = deque(maxlen=SEEN)
            if len(self._boots) > BOOTS:
                gone, _ = self._boots.popitem(last=False)
                self._top.pop(gone, None)
        self._boots[boot].append(seq)
        self._top[boot] = max(seq, self._top.get(boot, seq))

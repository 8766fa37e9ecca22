"""What a station does with notices of treatment and with triggers: the rules, without a wire."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date, datetime

from backend_clients.field import messages as m

LONGEST_S = 3600.0  # a notice that nobody renews ends after this, whatever it says
SHORTEST_GAP_S = 5.0
MOST_A_DAY = 100  # pictures
KEPT = 64  # answers
Answer = tuple[m.Outcome, str]


class Answers:
    """Answers given, so that a repeat gets the same one and has no second effect."""

    def __init__(self) -> None:
        self._given: OrderedDict[object, Answer] = OrderedDict()

    def once(self, key: object, make: Callable[[], Answer]) -> Answer:
        """Return the answer to ``key``, made the first time."""
        if key not in self._given:
            self._given[key] = make()
            while len(self._given) > KEPT:
                self._given.popitem(last=False)
        return self._given[key]


@dataclass(frozen=True, slots=True)
class _Obeyed:
    notice: m.Notice
    until_s: float  # on the station's monotonic clock


class Treatment:
    """Which notice a station obeys; it ends by itself, on whichever of its two clocks comes first."""

    def __init__(self) -> None:
        self._obeyed: _Obeyed | None = None
        self._newest: datetime | None = None
        self._answers = Answers()

    def hear(self, notice: m.Notice, utc: datetime, mono_s: float) -> Answer:
        """Return the answer to a notice, obeyed from now on if it is accepted."""
        key = (notice.id, notice.until_utc, notice.is_treating)
        return self._answers.once(key, lambda: self._judge(notice, utc, mono_s))

    def now(self, utc: datetime, mono_s: float) -> m.Notice | None:
        """Return the notice in force, ``None`` from its end on."""
        obeyed = self._obeyed
        if obeyed is not None and (utc >= obeyed.notice.until_utc or mono_s >= obeyed.until_s):
            self._obeyed = obeyed = None
        return obeyed.notice if obeyed is not None else None

    @property
    def ends_s(self) -> float | None:
        """When the notice in force ends at the latest, on the monotonic clock."""
        return self._obeyed.until_s if self._obeyed is not None else None

    def _judge(self, notice: m.Notice, utc: datetime, mono_s: float) -> Answer:
        if self._newest is not None and notice.utc < self._newest:
            return "rejected", "A newer notice was heard before this one."
        if not notice.is_treating:
            self._newest, self._obeyed = notice.utc, None
            return "accepted", "Treatment is over."
        left_s = (notice.until_utc - utc).total_seconds()
        if left_s <= 0:
            return "rejected", f"The notice ended {said(-left_s)} before it came."
        self._newest = notice.utc
        self._obeyed = _Obeyed(notice, mono_s + min(left_s, LONGEST_S))
        return "accepted", f"Treatment under way, for {said(min(left_s, LONGEST_S))}."


class Shutter:
    """When a camera may take a picture."""

    def __init__(self) -> None:
        self._last_s: float | None = None
        self._day: date | None = None
        self.taken = 0
        self._answers = Answers()

    def trigger(self, order: m.Trigger, utc: datetime, mono_s: float, *, is_retained: bool) -> tuple[Answer, bool]:
        """Return the answer to a trigger, and whether a picture is to be taken now."""
        is_new = False

        def judge() -> Answer:
            nonlocal is_new
            refusal = self._stale(order, utc, is_retained=is_retained) or self.refusal(utc, mono_s)
            if refusal:
                return "rejected", refusal
            is_new = True
            self.take(utc, mono_s)
            return "accepted", "The picture follows."

        return self._answers.once(order.id, judge), is_new

    def refusal(self, utc: datetime, mono_s: float) -> str:
        """Say why no picture is taken now; empty if one may be."""
        since_s = None if self._last_s is None else mono_s - self._last_s
        if since_s is not None and since_s < SHORTEST_GAP_S:
            return f"The last picture was {said(since_s)} ago, at most one in {SHORTEST_GAP_S:g} s."
        if self._day == utc.date() and self.taken >= MOST_A_DAY:
            return f"{MOST_A_DAY} pictures were taken today, that is the limit."
        return ""

    def take(self, utc: datetime, mono_s: float) -> None:
        """Count a picture."""
        if self._day != utc.date():
            self._day, self.taken = utc.date(), 0
        self._last_s = mono_s
        self.taken += 1

    def _stale(self, order: m.Trigger, utc: datetime, *, is_retained: bool) -> str:
        age_s = (utc - order.utc).total_seconds()
        if is_retained:
            return "A trigger that the broker kept is not taken."
        if age_s > order.ttl_s:
            return f"Trigger is {said(age_s)} old, limit {order.ttl_s:g} s."
        if age_s < -order.ttl_s:
            return f"Trigger is {said(-age_s)} ahead of the station's clock, limit {order.ttl_s:g} s."
        return ""


def said(seconds: float) -> str:
    """Return a span in words."""
    if seconds < 90:
        return f"{seconds:.1f} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.0f} h"

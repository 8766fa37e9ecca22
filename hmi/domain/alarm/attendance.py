"""How many alarms a person gets who is there to answer them (ISA-18.2: alarms per operator and hour)."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

WINDOW_S = 8 * 3600.0
SLOT_S = 600.0
LEAST_S = 600.0  # of attendance; before that one alarm would look like a storm
MOST_GAP_S = 10.0  # time that nobody looked at counts for nobody


@dataclass(slots=True)
class _Slot:
    began_s: float
    person_s: float = 0.0
    raised: int = 0


@dataclass(slots=True)
class Attendance:
    """Adds up the last eight hours in slots of ten minutes; times in seconds of one monotonic clock.

    Alarms that came while nobody was there are no load on anybody and count for nobody.
    """

    _slots: deque[_Slot] = field(default_factory=deque, init=False)
    _people: int = field(default=0, init=False)
    _seen_s: float | None = field(default=None, init=False)

    def see(self, now_s: float, people: int) -> None:
        """Take how many people who may answer alarms are signed in."""
        gap_s = 0.0 if self._seen_s is None else min(MOST_GAP_S, max(0.0, now_s - self._seen_s))
        self._slot(now_s).person_s += gap_s * self._people
        self._seen_s, self._people = now_s, people

    def raised(self, now_s: float) -> None:
        """Count an alarm that was shown."""
        if self._people:
            self._slot(now_s).raised += 1

    def per_hour(self, now_s: float) -> float | None:
        """Return alarms per person and hour; ``None`` before ten minutes of anybody's attendance."""
        self._let_go(now_s)
        person_s = sum(one.person_s for one in self._slots)
        return None if person_s < LEAST_S else sum(one.raised for one in self._slots) / (person_s / 3600)

    def _slot(self, now_s: float) -> _Slot:
        self._let_go(now_s)
        if not self._slots or now_s - self._slots[-1].began_s >= SLOT_S:
            self._slots.append(_Slot(now_s))
        return self._slots[-1]

    def _let_go(self, now_s: float) -> None:
        while self._slots and now_s - self._slots[0].began_s >= WINDOW_S:
            self._slots.popleft()

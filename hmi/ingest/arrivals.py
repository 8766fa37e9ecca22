"""Counts what was sent by robots and did not arrive, or arrived twice, per robot and kind of message.

By the number that a robot gives each message of a kind (``header_id``); robots that give none are not counted.
A restart of the robot or of this console, a number that wraps around and messages out of order are no losses.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from msgspec import UNSET

from backend_clients.edge.fields import HEADER_IDS, Header
from backend_clients.edge.topics import Up

LATE_S = 10.0  # what is missing for so long counts as lost; radios and brokers deliver again within seconds
MOST_GAPS = 64  # of one kind at a time: every other message lost for some seconds
GAPS_REMEMBERED = 16
FAR_BACK = 1000  # numbers that fall back further begin anew: a robot that restarted without saying so
MOST_PER_S, MOST_AT_ONCE = 200, 200  # a gap larger than any robot can have sent begins anew, too
BOOTS_REMEMBERED = 8


@dataclass(slots=True)
class Gap:
    """Numbers that are missing, first and last, and since when."""

    first: int
    last: int
    since_s: float

    @property
    def size(self) -> int:
        """Return how many."""
        return self.last - self.first + 1


@dataclass(slots=True)
class Count:
    """What became of the messages of one kind, or of several.

    Args:
        received: that have a number and arrived for the first time.
        lost: missing for ``LATE_S``; ``late`` of them arrived after all.
        twice: arrived again.
        out_of_order: overtaken by later ones, and none of the lost.
        lost_s: when the newest loss was seen, on the console's clock.
    """

    received: int = 0
    lost: int = 0
    late: int = 0
    twice: int = 0
    out_of_order: int = 0
    lost_s: float | None = None

    def add(self, other: Count) -> None:
        """Add what another counted."""
        self.received += other.received
        self.lost += other.lost
        self.late += other.late
        self.twice += other.twice
        self.out_of_order += other.out_of_order
        self.lost_s = max((one for one in (self.lost_s, other.lost_s) if one is not None), default=None)


class Row:
    """The messages of one kind of one robot."""

    def __init__(self) -> None:
        self.count = Count()
        self.gaps: list[Gap] = []
        self._given_up: list[Gap] = []
        self._boot = ""
        self._retired: deque[str] = deque(maxlen=BOOTS_REMEMBERED)
        self._newest: int | None = None  # counted on beyond a wrap-around
        self._heard_s = 0.0

    def take(self, boot: str, number: int, now_s: float) -> None:
        """Take one message."""
        count = self.count
        if boot != self._boot:
            if boot in self._retired:  # of the last life: nothing can be said of what is between
                count.received += 1
                return
            self._begin(boot, now_s)
        if self._newest is None:
            count.received += 1
            self._newest, self._heard_s = number, now_s
            return
        ahead = (number - self._newest) % HEADER_IDS
        if ahead == 1:
            count.received += 1
            self._newest += 1
        elif ahead == 0:
            count.twice += 1
        elif ahead < HEADER_IDS // 2:
            self._skipped(ahead, now_s)
        else:
            self._behind(HEADER_IDS - ahead, number)
        self._heard_s = now_s

    def begin_anew(self) -> None:
        """Count on from the next message: some were left unread here, so that nobody knows what is missing."""
        self._newest = None
        self.gaps.clear()

    def settle(self, before_s: float) -> bool:
        """Give up what is missing since before a moment; return whether something is missing still."""
        while self.gaps and self.gaps[0].since_s <= before_s:
            self._give_up()
        return bool(self.gaps)

    def _begin(self, boot: str, now_s: float) -> None:
        if self._boot:
            self._retired.append(self._boot)
        self._boot = boot
        self.settle(now_s)
        self._given_up.clear()
        self._newest = None

    def _skipped(self, ahead: int, now_s: float) -> None:
        assert self._newest is not None
        self.count.received += 1
        if ahead - 1 > MOST_AT_ONCE + MOST_PER_S * (now_s - self._heard_s):
            self._newest = (self._newest + ahead) % HEADER_IDS
            return
        self.gaps.append(Gap(self._newest + 1, self._newest + ahead - 1, now_s))
        if len(self.gaps) > MOST_GAPS:
            self._give_up()
        self._newest += ahead

    def _behind(self, back: int, number: int) -> None:
        assert self._newest is not None
        place = self._newest - back
        if _fill(self.gaps, place):
            self.count.received += 1
            self.count.out_of_order += 1
            if len(self.gaps) > MOST_GAPS:
                self._give_up()
        elif _fill(self._given_up, place):
            self.count.received += 1
            self.count.late += 1
            del self._given_up[:-GAPS_REMEMBERED]
        elif back <= FAR_BACK:
            self.count.twice += 1
        else:
            self.count.received += 1
            self._newest = number

    def _give_up(self) -> None:
        gap = self.gaps.pop(0)
        self.count.lost += gap.size
        self.count.lost_s = gap.since_s
        self._given_up = [*self._given_up[-GAPS_REMEMBERED:], gap]


def _fill(gaps: list[Gap], place: int) -> bool:
    """Take a number out of the gap it is in; return whether there was one."""
    for at, gap in enumerate(gaps):
        if gap.first <= place <= gap.last:
            parts = (Gap(gap.first, place - 1, gap.since_s), Gap(place + 1, gap.last, gap.since_s))
            gaps[at : at + 1] = [one for one in parts if one.size]
            return True
    return False


class Arrivals:
    """All robots of one broker; on the event loop.

    Args:
        mono_s: the console's monotonic clock.
    """

    def __init__(self, mono_s: Callable[[], float]) -> None:
        self._mono_s = mono_s
        self._rows: dict[str, dict[Up, Row]] = {}
        self._missing: dict[int, Row] = {}
        self._gone: dict[Up, Count] = {}  # of robots that were taken out: a total never falls

    def take(self, robot: str, kind: Up, message: Header, now_s: float) -> None:
        """Take a message of a registered robot."""
        if message.header_id is UNSET:
            return
        rows = self._rows.get(robot)
        if rows is None:
            rows = self._rows[robot] = {}
        row = rows.get(kind)
        if row is None:
            row = rows[kind] = Row()
        row.take(message.boot, message.header_id, now_s)
        if row.gaps:
            self._missing[id(row)] = row

    def begin_anew(self, robot: str, kind: Up) -> None:
        """Take that messages came and were not read here."""
        row = self._rows.get(robot, {}).get(kind)
        if row is not None:
            row.begin_anew()

    def settle(self, registered: Iterable[str]) -> None:
        """Give up what is missing for long, and forget robots that are registered no more; called twice a second."""
        before_s = self._mono_s() - LATE_S
        self._missing = {key: row for key, row in self._missing.items() if row.settle(before_s)}
        for robot in self._rows.keys() - set(registered):
            for kind, row in self._rows.pop(robot).items():
                self._gone.setdefault(kind, Count()).add(row.count)

    def by_kind(self) -> dict[Up, Count]:
        """Return what became of each kind of message, of all robots together since the start."""
        found: dict[Up, Count] = {}
        counted = [self._gone, *self.by_robot().values()]
        for kind, count in (pair for counts in counted for pair in counts.items()):
            found.setdefault(kind, Count()).add(count)
        return found

    def by_robot(self) -> dict[str, dict[Up, Count]]:
        """Return what became of each kind of message of each robot that numbers them."""
        return {robot: {kind: row.count for kind, row in rows.items()} for robot, rows in self._rows.items()}

"""How the link to a service outside is, a context broker among them: one state, when it is asked again, since when.

It is a circuit breaker too: after failures nobody waits for the service; a look beside finds out when it is back.
"""

from __future__ import annotations

import logging
import random
from collections import deque
from dataclasses import dataclass
from datetime import datetime
from email.utils import parsedate_to_datetime
from enum import StrEnum

from backend_clients.http.trouble import OutsideError, Trouble
from hmi.clock import Clock

LATE_PAUSE_S = 60.0
LONGEST_ASKED_S = 300.0  # no service may ask to be left alone for longer
BAD_ANSWERS = 3  # one answer that cannot be used may be about one request
TIMES_KEPT = 50
SKEW_TOLD_S = 2.0
MAX_WHY = 300
log = logging.getLogger(__name__)


class LinkState(StrEnum):
    """States a person is shown; only ``OK`` and ``SLOW`` answer."""

    OFF = "off"
    CONNECTING = "connecting"
    OK = "ok"
    SLOW = "slow"
    UNREACHABLE = "unreachable"
    SILENT = "silent"
    UNTRUSTED = "untrusted"
    REFUSED = "refused"
    FAILING = "failing"
    BUSY = "busy"
    NARROW = "narrow"
    NOT_UNDERSTOOD = "not_understood"
    MISSET = "misset"
    OTHER_TENANT = "other_tenant"  # of a context broker only, as the next
    OTHER_CONSOLE = "other_console"


NOT_OURS = frozenset({LinkState.OTHER_TENANT, LinkState.OTHER_CONSOLE})
ANSWERS = frozenset({LinkState.OK, LinkState.SLOW})
NEEDS_PERSON = frozenset(
    {LinkState.UNTRUSTED, LinkState.REFUSED, LinkState.NARROW, LinkState.NOT_UNDERSTOOD, LinkState.MISSET,
     LinkState.OTHER_TENANT, LinkState.OTHER_CONSOLE}
)  # fmt: skip
"""States that no waiting mends."""


def state_of(error: OutsideError) -> LinkState:
    """Return what a failed call means for the link as a whole."""
    return LinkState((error.trouble or Trouble.NOT_UNDERSTOOD).value)


@dataclass(frozen=True, slots=True)
class Pauses:
    """How long a service that failed is left alone: ``first_s``, then twice as long each time, up to ``longest_s``."""

    first_s: float = 10.0
    longest_s: float = 300.0

    def after(self, failures: int, chance: float, asked_s: float) -> float:
        """Return the pause after so many failures before this one.

        Args:
            chance: 0..1, spreads consoles that lost the same service.
            asked_s: how long the service asks for; it is never asked sooner.
        """
        own_s = min(self.longest_s, self.first_s * 2.0**failures) * (0.5 + 0.5 * chance)
        return max(own_s, min(asked_s, LONGEST_ASKED_S))


@dataclass(frozen=True, slots=True)
class LastError:
    """The last failure, kept after the link is well again."""

    text: str
    at: datetime


class ServiceLink:
    """The link to one service.

    Args:
        slow_s: an answer that takes longer is slow.
        jitter: see ``Pauses.after``; by chance if left out.
        name: of the service, for the log.
    """

    def __init__(
        self,
        clock: Clock,
        slow_s: float = 2.0,
        pauses: Pauses | None = None,
        jitter: float | None = None,
        *,
        name: str = "service",
    ) -> None:
        self.name = name
        self._clock, self._slow_s, self._jitter = clock, slow_s, jitter
        self._pauses = pauses or Pauses()
        self.state = LinkState.CONNECTING
        self.since_s = clock.mono_s()
        self.why = self.mend = ""
        self.heard_at: datetime | None = None
        self.last_error: LastError | None = None
        self.skew_s: float | None = None
        self._failures = self._bad = 0
        self._next_s = float("-inf")
        self._times: deque[float] = deque(maxlen=TIMES_KEPT)

    @property
    def is_well(self) -> bool:
        """Whether the last call was answered."""
        return self.state in ANSWERS

    @property
    def is_away(self) -> bool:
        """Whether the last call failed; not so before the first one."""
        return self.state not in ANSWERS | {LinkState.OFF, LinkState.CONNECTING}

    @property
    def clock_off_s(self) -> float:
        """By how much the service's clock and ours differ, seconds; nothing while it is not known."""
        return abs(self.skew_s or 0.0)

    @property
    def may_ask(self) -> bool:
        """Whether a call may be made now: a link that failed is left alone for a while."""
        return self._clock.mono_s() >= self._next_s

    @property
    def again_in_s(self) -> float:
        """Seconds until it is asked again."""
        return max(0.0, self._next_s - self._clock.mono_s())

    @property
    def median_s(self) -> float | None:
        """Median of the last answers' times, ``None`` without one."""
        return sorted(self._times)[len(self._times) // 2] if self._times else None

    def well(self, took_s: float, date: str = "") -> None:
        """Take an answer that can be used.

        Args:
            took_s: how long it took.
            date: the ``Date`` header, which tells the service's clock.
        """
        self._times.append(took_s)
        self.heard_at = self._clock.utc()
        self.skew_s = self._skew(date) if date else self.skew_s
        self._next_s = float("-inf")
        if self._bad >= BAD_ANSWERS:
            return  # that it is there does not make its work usable; the next work shows
        self._failures = 0
        is_slow = took_s > self._slow_s
        self._be(
            LinkState.SLOW if is_slow else LinkState.OK, f"The last answer took {took_s:.1f} s." if is_slow else "", ""
        )

    def worked(self, took_s: float) -> None:
        """Take work that can be used; it may take its time."""
        self._times.append(took_s)
        self._failures = self._bad = 0
        self._next_s = float("-inf")
        self.heard_at = self._clock.utc()
        self._be(LinkState.OK, "", "")

    def late(self, error: OutsideError) -> None:
        """Take work that was not done in time by a service that answers: for a while nobody waits for more of it."""
        self._note(f"{error}")
        self._next_s = self._clock.mono_s() + LATE_PAUSE_S
        self._be(LinkState.SLOW, f"{error}"[:MAX_WHY], error.mend)

    def bad_work(self, error: OutsideError) -> None:
        """Take work that cannot be used: once may be about this work, again and again it is the service."""
        self._note(f"{error}")
        self._bad += 1
        if self._bad >= BAD_ANSWERS:
            self.failed(error)

    def failed(self, error: OutsideError) -> None:
        """Take a call that failed: the service is left alone for a while."""
        self.leave(state_of(error), f"{error}", error.mend, error.retry_after_s or 0.0)

    def leave(self, state: LinkState, why: str, mend: str, asked_s: float = 0.0) -> None:
        """Leave the service alone for a while, for a reason that is no error of a call."""
        self._note(why)
        chance = random.random() if self._jitter is None else self._jitter  # noqa: S311 - spreads load
        self._next_s = self._clock.mono_s() + self._pauses.after(self._failures, chance, asked_s)
        self._failures = min(self._failures + 1, 10)
        self._be(state, why[:MAX_WHY], mend)

    def ask_now(self) -> None:
        """Let it be asked at once: a person changed something."""
        self._next_s = float("-inf")

    def set_clock(self, date: str) -> None:
        """Take a ``Date`` header."""
        self.skew_s = self._skew(date)

    def _note(self, text: str) -> None:
        self.last_error = LastError(text[:MAX_WHY], self._clock.utc())

    def _skew(self, date: str) -> float | None:
        """Return how far the service's clock is ahead of ours; it tells whole seconds."""
        try:
            ahead_s = (parsedate_to_datetime(date) - self._clock.utc()).total_seconds()
        except (ValueError, TypeError):
            return None
        return ahead_s if abs(ahead_s) > SKEW_TOLD_S else 0.0

    def _be(self, state: LinkState, why: str, mend: str) -> None:
        self.why, self.mend = why, mend
        if state is not self.state:
            log.info("%s: %s %s", self.name, state.value, why)
            self.state, self.since_s = state, self._clock.mono_s()

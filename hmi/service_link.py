"""How the link to a service outside is: one state, when it is asked again, and for how long it has been so.

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

from backend_clients.service import errors as service
from hmi.clock import Clock

FIRST_PAUSE_S, LONGEST_PAUSE_S = 10.0, 300.0
LATE_PAUSE_S = 60.0
BAD_ANSWERS = 3  # one answer that cannot be used may be about one request
TIMES_KEPT = 50
SKEW_TOLD_S = 2.0
MAX_WHY = 300
log = logging.getLogger(__name__)


class ServiceState(StrEnum):
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
    NOT_UNDERSTOOD = "not_understood"


ANSWERS = frozenset({ServiceState.OK, ServiceState.SLOW})
_STATES: tuple[tuple[type[service.ServiceError], ServiceState], ...] = (
    (service.Untrusted, ServiceState.UNTRUSTED),
    (service.NoAnswer, ServiceState.SILENT),
    (service.Unreachable, ServiceState.UNREACHABLE),
    (service.NotAllowed, ServiceState.REFUSED),
    (service.Busy, ServiceState.BUSY),
    (service.ServiceFailed, ServiceState.FAILING),
)


def state_of(error: service.ServiceError) -> ServiceState:
    """Return what a failed call means for the link as a whole."""
    return next((state for kind, state in _STATES if isinstance(error, kind)), ServiceState.NOT_UNDERSTOOD)


@dataclass(frozen=True, slots=True)
class LastError:
    """The last failure, kept after the link is well again."""

    text: str
    at: datetime


class ServiceLink:
    """The link to one service.

    Args:
        slow_s: an answer that takes longer is slow.
        jitter: 0..1, spreads consoles that lost the same service.
    """

    def __init__(self, clock: Clock, slow_s: float = 2.0, jitter: float | None = None) -> None:
        self._clock, self._slow_s, self._jitter = clock, slow_s, jitter
        self.state = ServiceState.CONNECTING
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
        self._be(ServiceState.SLOW if is_slow else ServiceState.OK, f"{took_s:.1f} s." if is_slow else "", "")

    def worked(self, took_s: float) -> None:
        """Take work that can be used; it may take its time."""
        self._times.append(took_s)
        self._failures = self._bad = 0
        self._next_s = float("-inf")
        self.heard_at = self._clock.utc()
        self._be(ServiceState.OK, "", "")

    def late(self, error: service.ServiceError) -> None:
        """Take work that was not done in time by a service that answers: for a while nobody waits for more of it."""
        self._note(error)
        self._next_s = self._clock.mono_s() + LATE_PAUSE_S
        self._be(ServiceState.SLOW, f"{error}"[:MAX_WHY], error.mend)

    def bad_work(self, error: service.ServiceError) -> None:
        """Take work that cannot be used: once may be about this work, again and again it is the service."""
        self._note(error)
        self._bad += 1
        if self._bad >= BAD_ANSWERS:
            self.failed(error)

    def failed(self, error: service.ServiceError) -> None:
        """Take a call that failed: the service is left alone for a while."""
        self._note(error)
        asked_s = getattr(error, "retry_after_s", None) or 0.0
        pause_s = min(LONGEST_PAUSE_S, max(asked_s, FIRST_PAUSE_S * 2.0**self._failures))
        self._failures = min(self._failures + 1, 10)
        chance = random.random() if self._jitter is None else self._jitter  # noqa: S311 - spreads load
        self._next_s = self._clock.mono_s() + pause_s * (0.75 + 0.25 * chance)
        self._be(state_of(error), f"{error}"[:MAX_WHY], error.mend)

    def _note(self, error: service.ServiceError) -> None:
        self.last_error = LastError(f"{error}"[:MAX_WHY], self._clock.utc())

    def _skew(self, date: str) -> float | None:
        """Return how far the service's clock is ahead of ours; it tells whole seconds."""
        try:
            ahead_s = (parsedate_to_datetime(date) - self._clock.utc()).total_seconds()
        except (ValueError, TypeError):
            return None
        return ahead_s if abs(ahead_s) > SKEW_TOLD_S else 0.0

    def _be(self, state: ServiceState, why: str, mend: str) -> None:
        self.why, self.mend = why, mend
        if state is not self.state:
            log.info("service link: %s %s", state.value, why)
            self.state, self.since_s = state, self._clock.mono_s()

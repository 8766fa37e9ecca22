"""Who may move a robot: one control lease a robot, with a fencing token that only grows.

Pure: no clock, no database, no tasks. Every call gets ``now_s`` on the console's monotonic clock.
A robot refuses every token lower than the highest it has seen, so an old holder is shut out
even when its last order is still under way.

Source: docs/protocols/lane.md (``here`` frames are the proof of life), safety rules on leases.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

TTL_S = 10.0  # three missed renewals; long enough for a tablet that changes its access point
RENEW_S = 3.0  # a page proves life at least this often; it sends each second
ASK_TTL_S = 30.0  # an asker who left the page must not be given control minutes later
MAX_ASKS = 8  # one robot is asked for by a handful of people, never by a list without end
TOKEN_BITS = 20  # a million grants an epoch; the epoch grows at each start of the console


@dataclass(frozen=True, slots=True)
class Holder:
    """The browser that holds or wants a lease; all pages of the same sign-in are one holder.

    ``is_system`` is the console itself, for an armed queue: it gives way to any person who asks.
    """

    session_id: str
    user_id: str
    user_name: str
    device_name: str
    is_system: bool = False


@dataclass(frozen=True, slots=True)
class Ask:
    """Somebody waits to be given control."""

    holder: Holder
    asked_s: float


@dataclass(frozen=True, slots=True)
class Lease:
    """Control of one robot by one browser. Times on the console's monotonic clock."""

    robot_id: str
    holder: Holder
    token: int
    since_s: float
    renewed_s: float
    asks: tuple[Ask, ...] = ()

    def is_live(self, now_s: float) -> bool:
        """Say whether the holder proved life within the time to live."""
        return now_s - self.renewed_s < TTL_S

    def open_asks(self, now_s: float) -> tuple[Ask, ...]:
        """Return who still waits, oldest first."""
        return tuple(ask for ask in self.asks if now_s - ask.asked_s < ASK_TTL_S)


class LeaseCode(StrEnum):
    """What a lease operation came to."""

    GRANTED = "granted"
    ASKED = "asked"
    RELEASED = "released"
    KEPT = "kept"
    HELD_BY_OTHER = "held_by_other"
    NOT_HOLDER = "not_holder"
    NOBODY_ASKS = "nobody_asks"
    TOO_MANY_ASK = "too_many_ask"
    NO_TOKENS = "no_tokens"


@dataclass(frozen=True, slots=True)
class LeaseAnswer:
    """Result of an operation: the code, the lease in force after it, and the one it ended."""

    code: LeaseCode
    lease: Lease | None
    ended: Lease | None = None

    @property
    def is_ok(self) -> bool:
        """Whether the caller got what it asked for (waiting counts as not yet)."""
        return self.code in (LeaseCode.GRANTED, LeaseCode.RELEASED, LeaseCode.KEPT)


class LeaseBook:
    """All leases of one console.

    Args:
        epoch: from the counter that grows at each start; makes tokens grow across restarts.
    """

    def __init__(self, epoch: int) -> None:
        self._epoch = epoch
        self._grants = 0
        self._leases: dict[str, Lease] = {}
        self._seq: dict[int, int] = {}

    @property
    def is_low_on_tokens(self) -> bool:
        """Whether half of the epoch is used up and ``begin_epoch`` is due."""
        return self._grants >= 1 << (TOKEN_BITS - 1)

    def begin_epoch(self, epoch: int) -> None:
        """Go on with a higher epoch; leases in force keep their tokens.

        Raises:
            ValueError: the epoch does not grow.
        """
        if epoch <= self._epoch:
            raise ValueError(f"lease epoch {epoch} does not follow {self._epoch}")
        self._epoch, self._grants = epoch, 0

    def of(self, robot_id: str, now_s: float) -> Lease | None:
        """Return the lease in force, ``None`` if nobody holds the robot."""
        lease = self._leases.get(robot_id)
        return lease if lease is not None and lease.is_live(now_s) else None

    def held_by(self, session_id: str, now_s: float) -> tuple[Lease, ...]:
        """Return every lease in force of one browser."""
        live = (self.of(robot_id, now_s) for robot_id in self._leases)
        return tuple(lease for lease in live if lease is not None and lease.holder.session_id == session_id)

    def next_seq(self, lease: Lease) -> int:
        """Return the next order number under ``lease``; it starts at 1 with each token.

        An ended lease still has numbers until ``forget``, for the one setpoint that brings the robot to rest.

        Raises:
            ValueError: the lease was forgotten.
        """
        if lease.token not in self._seq:
            raise ValueError(f"lease {lease.token} of {lease.robot_id} is over")
        self._seq[lease.token] += 1
        return self._seq[lease.token]

    def forget(self, lease: Lease) -> None:
        """Let no further order be numbered under an ended lease."""
        self._seq.pop(lease.token, None)

    def request(self, robot_id: str, holder: Holder, now_s: float) -> LeaseAnswer:
        """Take a free robot, or wait to be given a held one. Asking twice changes nothing.

        What the system holds, a person gets by asking: nobody is there who could answer.
        """
        lease = self.of(robot_id, now_s)
        if lease is None or (lease.holder.is_system and not holder.is_system):
            return self._issue(robot_id, holder, now_s)
        if lease.holder.session_id == holder.session_id:
            return LeaseAnswer(LeaseCode.GRANTED, self._put(replace(lease, renewed_s=now_s)))
        others = tuple(a for a in lease.open_asks(now_s) if a.holder.session_id != holder.session_id)
        if len(others) >= MAX_ASKS:
            return LeaseAnswer(LeaseCode.TOO_MANY_ASK, lease)
        return LeaseAnswer(LeaseCode.ASKED, self._put(replace(lease, asks=(*others, Ask(holder, now_s)))))

    def acquire_free(self, robot_id: str, holder: Holder, now_s: float) -> LeaseAnswer:
        """Take a robot that nobody holds, or confirm one's own; never ask, never take from another."""
        lease = self.of(robot_id, now_s)
        if lease is None:
            return self._issue(robot_id, holder, now_s)
        is_own = lease.holder.session_id == holder.session_id
        return LeaseAnswer(LeaseCode.GRANTED if is_own else LeaseCode.HELD_BY_OTHER, lease)

    def take(self, robot_id: str, holder: Holder, now_s: float) -> LeaseAnswer:
        """Take control from whoever holds it; the right to do so is asked before."""
        lease = self.of(robot_id, now_s)
        if lease is not None and lease.holder.session_id == holder.session_id:
            return LeaseAnswer(LeaseCode.GRANTED, self._put(replace(lease, renewed_s=now_s)))
        return self._issue(robot_id, holder, now_s)

    def renew(self, robot_id: str, session_id: str, now_s: float) -> Lease | None:
        """Note a proof of life; return the lease, or ``None`` if this browser does not hold it."""
        lease = self.of(robot_id, now_s)
        if lease is None or lease.holder.session_id != session_id:
            return None
        return self._put(replace(lease, renewed_s=now_s))

    def release(self, robot_id: str, session_id: str, now_s: float) -> LeaseAnswer:
        """Give control back, or stop waiting for it."""
        lease = self.of(robot_id, now_s)
        if lease is None:
            return LeaseAnswer(LeaseCode.NOT_HOLDER, None)
        if lease.holder.session_id == session_id:
            del self._leases[robot_id]
            return LeaseAnswer(LeaseCode.RELEASED, None, ended=lease)
        left = tuple(ask for ask in lease.asks if ask.holder.session_id != session_id)
        if len(left) == len(lease.asks):
            return LeaseAnswer(LeaseCode.NOT_HOLDER, lease)
        return LeaseAnswer(LeaseCode.RELEASED, self._put(replace(lease, asks=left)))

    def grant(self, robot_id: str, session_id: str, to_session: str | None, now_s: float) -> LeaseAnswer:
        """Hand over to one who asks (the first if ``to_session`` is ``None``); only the holder may."""
        lease, ask, answer = self._asked(robot_id, session_id, to_session, now_s)
        if lease is None or ask is None:
            return answer
        waiting = tuple(a for a in lease.open_asks(now_s) if a is not ask)
        return self._issue(robot_id, ask.holder, now_s, asks=waiting)

    def keep(self, robot_id: str, session_id: str, to_session: str | None, now_s: float) -> LeaseAnswer:
        """Answer an asker with no; only the holder may."""
        lease, ask, answer = self._asked(robot_id, session_id, to_session, now_s)
        if lease is None or ask is None:
            return answer
        waiting = tuple(a for a in lease.open_asks(now_s) if a is not ask)
        return LeaseAnswer(LeaseCode.KEPT, self._put(replace(lease, asks=waiting)))

    def revoke(self, robot_id: str) -> Lease | None:
        """End a lease at once, e.g. after a STOP; return what was ended."""
        return self._leases.pop(robot_id, None)

    def end_session(self, session_id: str, now_s: float) -> tuple[Lease, ...]:
        """Forget a browser that signed out; return the leases this ended."""
        ended = self.held_by(session_id, now_s)
        for lease in ended:
            del self._leases[lease.robot_id]
        for lease in tuple(self._leases.values()):
            left = tuple(ask for ask in lease.asks if ask.holder.session_id != session_id)
            if len(left) != len(lease.asks):
                self._put(replace(lease, asks=left))
        return ended

    def drop_old_asks(self, now_s: float) -> tuple[Lease, ...]:
        """Forget who asked too long ago; return the leases this changed."""
        changed = []
        for lease in tuple(self._leases.values()):
            waiting = lease.open_asks(now_s)
            if len(waiting) != len(lease.asks):
                changed.append(self._put(replace(lease, asks=waiting)))
        return tuple(changed)

    def expire(self, now_s: float) -> tuple[Lease, ...]:
        """Drop every lease whose holder fell silent; return what was ended."""
        ended = tuple(lease for lease in self._leases.values() if not lease.is_live(now_s))
        for lease in ended:
            del self._leases[lease.robot_id]
        return ended

    def _asked(
        self, robot_id: str, session_id: str, to_session: str | None, now_s: float
    ) -> tuple[Lease | None, Ask | None, LeaseAnswer]:
        lease = self.of(robot_id, now_s)
        if lease is None or lease.holder.session_id != session_id:
            return None, None, LeaseAnswer(LeaseCode.NOT_HOLDER, lease)
        wanted = (a for a in lease.open_asks(now_s) if to_session in (None, a.holder.session_id))
        return lease, next(wanted, None), LeaseAnswer(LeaseCode.NOBODY_ASKS, lease)

    def _issue(self, robot_id: str, holder: Holder, now_s: float, *, asks: tuple[Ask, ...] = ()) -> LeaseAnswer:
        before = self.of(robot_id, now_s)
        if self._grants + 1 >= 1 << TOKEN_BITS:
            return LeaseAnswer(LeaseCode.NO_TOKENS, before)
        self._grants += 1
        token = self._epoch << TOKEN_BITS | self._grants
        self._seq[token] = 0
        return LeaseAnswer(
            LeaseCode.GRANTED, self._put(Lease(robot_id, holder, token, now_s, now_s, asks)), ended=before
        )

    def _put(self, lease: Lease) -> Lease:
        self._leases[lease.robot_id] = lease
        return lease

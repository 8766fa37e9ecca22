"""Orders under way: sent once, answered once, remembered, audited, and told to every screen.

An id answers for ever (ten minutes) with the same result, so that a repeated request never acts twice. An
answer that comes after the time-out corrects the result: the audit and the screens learn what really happened.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace

from hmi.clock import Clock
from hmi.commands.ports import AuditSink, FleetReader, LaneEvent
from hmi.commands.refusal import BUSY, ID_REUSED, LEASE_REVOKED, NOT_CONNECTED, OrderRefused
from hmi.domain.command import Acknowledgement, CommandOrder, Order, OrderSender, Outcome, ResetOrder
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry

ACK_LIMIT_S = 2.0  # the order's own time to live: after it the robot refuses it as late
KEEP_S = 600.0  # far beyond any retry; a replay after that has a stale tick
MIN_KEEP_S = 10.0  # a request repeated this late has a stale tick, so even under pressure nothing acts twice
MAX_KEPT, MAX_REFUSALS = 10_000, 1_000  # bounds memory when somebody sends without end
LOOK = "It may have done it: look at the machine."
MAX_PENDING, MAX_PENDING_URGENT = 8, 32  # per robot; an honest screen has one. Pausing has room of its own.


@dataclass(frozen=True, slots=True)
class Ticket:
    """Names one order. ``kind`` is the one its acknowledgement carries; ``what`` the word for people.

    ``about`` is what it is done to, such as a node, where that is not the robot as a whole.
    """

    kind: str
    ref: str
    robot_id: str
    what: str
    actor: SessionInfo
    content: tuple[str, ...] = ()
    is_urgent: bool = False
    about: str = ""

    @property
    def fingerprint(self) -> tuple[str, ...]:
        """What must be equal for a repeated id to be the same order."""
        return (self.kind, self.robot_id, self.what, self.actor.session_id, *self.content)


@dataclass(frozen=True, slots=True)
class CommandResult:
    """What became of an order; ``ms`` from sending to the answer, ``None`` without one."""

    ref: str
    robot_id: str
    what: str
    outcome: Outcome
    code: str
    text: str
    ms: int | None = None

    @property
    def is_accepted(self) -> bool:
        """Whether the robot said yes."""
        return self.outcome is Outcome.ACCEPTED


@dataclass(slots=True)
class _Entry:
    """An order that went out, and who waits for it."""

    ticket: Ticket
    sent_s: float
    robot_name: str
    boot: str | None
    result: CommandResult
    answer: asyncio.Future[Acknowledgement]
    final: asyncio.Future[CommandResult]
    lease_token: int


ResultHook = Callable[[Ticket, CommandResult], None]
RevokedHook = Callable[[str, int], None]


class OrderLedger:
    """Sends orders and keeps account of what became of them.

    Args:
        ack_limit_s: how long a caller waits for the robot's answer.
    """

    def __init__(
        self,
        sender: OrderSender,
        fleet: FleetReader,
        clock: Clock,
        audit: AuditSink,
        on_event: LaneEvent,
        *,
        ack_limit_s: float = ACK_LIMIT_S,
    ) -> None:
        self._sender, self._fleet, self._clock = sender, fleet, clock
        self._audit, self._on_event, self._ack_limit_s = audit, on_event, ack_limit_s
        self._entries: OrderedDict[str, _Entry] = OrderedDict()
        self._refusals: OrderedDict[str, tuple[tuple[str, ...], CommandResult]] = OrderedDict()
        self._tasks: set[asyncio.Task[None]] = set()
        self._hooks: list[ResultHook] = []
        self._revoked_hooks: list[RevokedHook] = []

    def when_settled(self, hook: ResultHook) -> None:
        """Call ``hook`` with every result, ``pending`` ones and late corrections included."""
        self._hooks.append(hook)

    def when_revoked(self, hook: RevokedHook) -> None:
        """Call ``hook`` with robot and lease token of each order that its robot refused because a STOP ended that."""
        self._revoked_hooks.append(hook)

    async def place(self, ticket: Ticket, prepare: Callable[[], Order]) -> CommandResult:
        """Send what ``prepare`` makes, once, and return what became of it.

        ``prepare`` asks every question and builds the order without waiting; from there to the wire nothing
        else runs. A caller that goes away does not end the order: its outcome is still recorded.
        """
        known = self._known(ticket)
        if known is not None:
            return await asyncio.shield(known)
        try:
            self._make_room(ticket)
            entry = self._send(ticket, prepare())
        except OrderRefused as refused:
            result = self.refuse(ticket, refused)
            self._refusals[ticket.ref] = (ticket.fingerprint, result)
            while len(self._refusals) > MAX_REFUSALS:
                self._refusals.popitem(last=False)
            return result
        self._report(ticket, entry.result)
        task = asyncio.create_task(self._follow(entry), name=f"order {ticket.what} {ticket.ref}")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return await asyncio.shield(entry.final)

    def refuse(self, ticket: Ticket, refused: OrderRefused) -> CommandResult:
        """Record that the console did not send an order."""
        result = _result(ticket, Outcome.REJECTED, refused.code, refused.text)
        self._report(ticket, result)
        return result

    def acknowledged(self, ack: Acknowledgement) -> bool:
        """Take a robot's answer; return whether it belonged to an order of ours."""
        entry = self._entries.get(ack.ref)
        if entry is None or (entry.ticket.robot_id, entry.ticket.kind) != (ack.robot_id, ack.kind):
            return False
        if not entry.final.done():
            if not entry.answer.done():
                entry.answer.set_result(ack)
        elif entry.result.outcome in (Outcome.TIMED_OUT, Outcome.UNKNOWN):
            entry.final = entry.final.get_loop().create_future()
            self._settle(entry, self._from_ack(entry, ack), is_late=True)
        return True

    async def close(self) -> None:
        """End every wait; what is still open becomes ``unknown``, which is the truth."""
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        for entry in [e for e in self._entries.values() if not e.final.done()]:
            text = f"The console was stopped before {entry.robot_name} answered. {LOOK}"
            self._settle(entry, _result(entry.ticket, Outcome.UNKNOWN, "console_stopped", text), is_late=False)

    def _known(self, ticket: Ticket) -> asyncio.Future[CommandResult] | None:
        entry, refusal = self._entries.get(ticket.ref), self._refusals.get(ticket.ref)
        if entry is None and refusal is None:
            return None
        fingerprint = entry.ticket.fingerprint if entry is not None else refusal[0] if refusal is not None else ()
        if entry is not None and fingerprint == ticket.fingerprint:
            return entry.final
        answered: asyncio.Future[CommandResult] = asyncio.get_running_loop().create_future()
        if refusal is not None and fingerprint == ticket.fingerprint:
            answered.set_result(refusal[1])
        else:
            reused = OrderRefused(ID_REUSED, "This command id was used for something else. Nothing was sent.")
            answered.set_result(self.refuse(ticket, reused))
        return answered

    def _send(self, ticket: Ticket, order: Order) -> _Entry:
        loop = asyncio.get_running_loop()
        robot = self._fleet.robot(ticket.robot_id)
        entry = self._entries[ticket.ref] = _Entry(
            ticket=ticket,
            sent_s=self._clock.mono_s(),
            robot_name=robot.name if robot is not None else ticket.robot_id,
            boot=robot.link.boot if robot is not None else None,
            result=_result(ticket, Outcome.PENDING, "pending", "Waiting for the robot."),
            answer=loop.create_future(),
            final=loop.create_future(),
            lease_token=order.lease_token if isinstance(order, CommandOrder | ResetOrder) else 0,
        )
        if not self._sender.send(order):
            del self._entries[ticket.ref]
            raise OrderRefused(NOT_CONNECTED, "There is no connection to the robots. Nothing was sent.")
        return entry

    async def _follow(self, entry: _Entry) -> None:
        await asyncio.wait({entry.answer}, timeout=self._ack_limit_s)
        result = self._from_ack(entry, entry.answer.result()) if entry.answer.done() else self._silence(entry)
        self._settle(entry, result, is_late=False)

    def _from_ack(self, entry: _Entry, ack: Acknowledgement) -> CommandResult:
        outcome = Outcome.ACCEPTED if ack.is_accepted else Outcome.REJECTED
        ms = round((self._clock.mono_s() - entry.sent_s) * 1000)
        return replace(_result(entry.ticket, outcome, ack.code, ack.text), ms=ms)

    def _silence(self, entry: _Entry) -> CommandResult:
        robot = self._fleet.robot(entry.ticket.robot_id)
        if robot is None or not robot.link.is_broker_up or robot.link.boot != entry.boot:
            text = f"The link to {entry.robot_name} broke before it answered. {LOOK}"
            return _result(entry.ticket, Outcome.UNKNOWN, "link_lost", text)
        text = f"{entry.robot_name} did not answer within {self._ack_limit_s:g} s. {LOOK}"
        return _result(entry.ticket, Outcome.TIMED_OUT, "timed_out", text)

    def _settle(self, entry: _Entry, result: CommandResult, *, is_late: bool) -> None:
        entry.result = result
        entry.final.set_result(result)  # first, so that nothing below can leave a caller waiting
        self._report(entry.ticket, result, is_late=is_late)
        if result.code == LEASE_REVOKED and entry.lease_token:
            for hook in self._revoked_hooks:
                hook(entry.ticket.robot_id, entry.lease_token)

    def _make_room(self, ticket: Ticket) -> None:
        now_s = self._clock.mono_s()
        while self._entries:
            oldest = next(iter(self._entries.values()))
            age_s = now_s - oldest.sent_s
            is_due = age_s > KEEP_S or (len(self._entries) >= MAX_KEPT and age_s > MIN_KEEP_S)
            if not (oldest.final.done() and is_due):
                break
            self._entries.popitem(last=False)
        limit = MAX_PENDING_URGENT if ticket.is_urgent else MAX_PENDING
        if len(self._entries) >= MAX_KEPT or self._pending(ticket) >= limit:
            raise OrderRefused(BUSY, f"{limit} commands to this robot wait for an answer already.")

    def _pending(self, ticket: Ticket) -> int:
        alike = (ticket.robot_id, ticket.is_urgent)
        waiting = (e.ticket for e in reversed(self._entries.values()) if not e.final.done())
        return sum((other.robot_id, other.is_urgent) == alike for other in waiting)

    def _report(self, ticket: Ticket, result: CommandResult, *, is_late: bool = False) -> None:
        actor, outcome = ticket.actor, result.outcome.value
        detail = {"action": ticket.what, "code": result.code, "ms": result.ms, "is_late": is_late}
        if ticket.about:
            detail["about"] = ticket.about
        robot_id, text = ticket.robot_id, result.text
        self._audit.append(
            AuditEntry(
                actor.farm_id,
                actor.user_name,
                actor.device_name,
                ticket.kind,
                outcome,
                robot_id,
                ticket.ref,
                text,
                detail,
            )
        )
        event = {"kind": "command", "robot": robot_id, "command_id": ticket.ref, "outcome": outcome, "text": text}
        self._on_event({**event, **detail, "by": actor.user_name, "session": actor.session_id})
        for hook in self._hooks:
            hook(ticket, result)


def _result(ticket: Ticket, outcome: Outcome, code: str, text: str) -> CommandResult:
    return CommandResult(ticket.ref, ticket.robot_id, ticket.what, outcome, code, text)

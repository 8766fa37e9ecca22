"""Control leases in use: who asks, who gives, what a STOP revokes, and who is told.

The rules are in ``hmi.domain.lease``; here are the clock, the rights, the audit and the lane.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from enum import StrEnum

from hmi.clock import Clock
from hmi.commands.gate import Gate
from hmi.commands.lease_words import lease_event, lease_text
from hmi.commands.ports import AuditSink, LaneEvent
from hmi.commands.refusal import REASON_MISSING, OrderRefused
from hmi.domain.lease import Holder, Lease, LeaseAnswer, LeaseBook, LeaseCode
from hmi.domain.robot import Robot
from hmi.domain.role import Permission
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry

LeaseEnded = Callable[[Lease], None]
MAX_KNOWN_PRESSES = 256  # a robot lists at most 64 presses; older ids cannot come back unreset


class LeaseOp(StrEnum):
    """What a browser can do about control."""

    REQUEST = "request"
    RELEASE = "release"
    GRANT = "grant"
    KEEP = "keep"
    TAKE = "take"


@dataclass(frozen=True, slots=True)
class LeaseResult:
    """Answer to a lease operation; ``lease`` is what is in force now, whoever holds it."""

    is_granted: bool
    code: str
    text: str
    lease: Lease | None


class LeaseService:
    """All leases of this console.

    Args:
        epoch: from the counter repository at start.
        next_epoch: draws a further one when half of the tokens are used up.
        is_signed_in: whether a browser is still signed in; nobody who left is handed a robot.
        on_event: told of every change, for the lane.
    """

    def __init__(
        self,
        gate: Gate,
        clock: Clock,
        audit: AuditSink,
        on_event: LaneEvent,
        *,
        epoch: int,
        next_epoch: Callable[[], Awaitable[int]],
        is_signed_in: Callable[[str], bool] = lambda _session_id: True,
    ) -> None:
        self._book = LeaseBook(epoch)
        self._gate, self._clock, self._audit, self._on_event = gate, clock, audit, on_event
        self._next_epoch, self._is_signed_in = next_epoch, is_signed_in
        self._on_ended: list[LeaseEnded] = []
        self._presses: dict[str, dict[str, None]] = {}
        self._buttons: set[str] = set()  # robots whose button on the machine is pressed
        self._farms: dict[str, str] = {}

    def when_ended(self, callback: LeaseEnded) -> None:
        """Call ``callback`` with each lease that ends, before anybody is told who comes next."""
        self._on_ended.append(callback)

    def of(self, robot_id: str) -> Lease | None:
        """Return the lease in force."""
        return self._book.of(robot_id, self._clock.mono_s())

    def holds(self, session_id: str, robot_id: str) -> Lease | None:
        """Return the lease if this browser holds it."""
        lease = self.of(robot_id)
        return lease if lease is not None and lease.holder.session_id == session_id else None

    def next_seq(self, lease: Lease) -> int:
        """Return the next order number under a lease in force."""
        return self._book.next_seq(lease)

    def operate(
        self,
        actor: SessionInfo,
        robot_id: str,
        op: LeaseOp,
        *,
        tick_id: str,
        reason: str = "",
        to_session: str | None = None,
    ) -> LeaseResult:
        """Do one lease operation for a browser; a refusal comes back as a result, never as an error."""
        try:
            robot = self._admit(actor, robot_id, op, tick_id, reason)
        except OrderRefused as refused:
            self._write(actor, robot_id, op, refused.code, refused.text, reason)
            return LeaseResult(False, refused.code, refused.text, self.of(robot_id))
        before = self.of(robot_id)
        answer = self._apply(actor, robot_id, op, to_session)
        text = lease_text(robot.name, answer)
        self._settle(actor, robot, op, answer, text, before=before, reason=reason)
        return LeaseResult(answer.is_ok, answer.code.value, text, answer.lease)

    def control(self, actor: SessionInfo, robot: Robot) -> Lease:
        """Return this browser's lease; a free robot is taken by the order itself, a held one never.

        The person has just slid to confirm, so asking for a free robot in a step of its own would only add a
        way to fail between the two. A robot held by somebody else has to be asked for.

        Raises:
            OrderRefused: somebody else holds it.
        """
        self._sweep()
        self.observe(robot)
        before = self.of(robot.id)
        answer = self._book.acquire_free(robot.id, _holder(actor), self._clock.mono_s())
        text = lease_text(robot.name, answer)
        if answer.code is not LeaseCode.GRANTED or answer.lease is None:
            raise OrderRefused(answer.code.value, text)
        if answer.lease != before:
            self._settle(actor, robot, LeaseOp.REQUEST, answer, text, before=before, reason="")
        return answer.lease

    def hold_for_system(self, system: SessionInfo, robot: Robot, person: SessionInfo) -> Lease:
        """Give the robot to the console itself, because ``person`` has just armed its queue; shown to everybody.

        A free robot is taken, and one that this person holds; nobody else loses control by it.

        Raises:
            OrderRefused: somebody else has control.
        """
        self._sweep()
        self.observe(robot)
        before, now_s = self.of(robot.id), self._clock.mono_s()
        is_free = before is None or before.holder.is_system or before.holder.session_id == person.session_id
        holder = replace(_holder(system), is_system=True)
        take = self._book.take if is_free else self._book.acquire_free
        answer = take(robot.id, holder, now_s)
        text = lease_text(robot.name, answer)
        if answer.code is not LeaseCode.GRANTED or answer.lease is None:
            raise OrderRefused(answer.code.value, text)
        self._settle(system, robot, LeaseOp.REQUEST, answer, text, before=before, reason=f"armed by {person.user_name}")
        return answer.lease

    def give_back(self, system: SessionInfo, robot_id: str, text: str) -> None:
        """End what the console itself holds; nothing happens if it holds it no more."""
        lease = self.holds(system.session_id, robot_id)
        if lease is not None:
            self._book.release(robot_id, system.session_id, self._clock.mono_s())
            self._end(lease, "released", text)

    def prove_life(self, session_id: str, robot_id: str) -> Lease | None:
        """Renew by a proof of life from the browser; ``None`` if it does not hold the robot."""
        return self._book.renew(robot_id, session_id, self._clock.mono_s())

    def observe(self, robot: Robot) -> None:
        """Revoke the lease if the robot reports a STOP press or a press of its own button not seen before.

        Control taken while the button is still pressed is newer than what the robot has ended, and stays.
        """
        self._observe_button(robot)
        known = self._presses.get(robot.id, {})
        for press in robot.safety.presses if robot.safety is not None else ():
            if not press.is_reset and press.stop_id not in known:
                self.stopped(robot.id, press.stop_id, press.by or press.device)

    def stopped(self, robot_id: str, stop_id: str, by: str) -> None:
        """Revoke the lease because of a STOP; once for each ``stop_id``, so that a reset can follow."""
        known = self._presses.setdefault(robot_id, {})
        if stop_id in known:
            return
        known[stop_id] = None
        while len(known) > MAX_KNOWN_PRESSES:
            del known[next(iter(known))]
        self._revoke(robot_id, f"STOP by {by or 'somebody'}")

    def revoked_by_robot(self, robot_id: str, token: int) -> None:
        """Revoke the lease with this token because the robot says that a STOP ended it.

        The press was not told here, or came to the robot after control was taken anew; a newer lease stays.
        """
        lease = self.of(robot_id)
        if lease is not None and lease.token == token:
            self._revoke(robot_id, "A STOP")

    def end_session(self, session_id: str) -> None:
        """Give back everything a browser held, because it signed out or was signed out."""
        for lease in self._book.end_session(session_id, self._clock.mono_s()):
            self._end(lease, "released", f"{lease.holder.user_name} signed out and gave control back.")

    def robot_removed(self, robot_id: str) -> None:
        """End control of a robot that left the registry."""
        lease = self._book.revoke(robot_id)
        if lease is not None:
            self._end(lease, "revoked", f"{robot_id} was removed from the list of robots.")

    async def tend(self) -> None:
        """End the control of silent holders and draw a new epoch in time; call every second or so."""
        self._sweep()
        for lease in self._book.drop_old_asks(self._clock.mono_s()):
            text = f"{lease.holder.user_name} did not answer; ask again."
            self._on_event(lease_event(lease.robot_id, "unanswered", text, lease, by=lease.holder.user_name))
        if self._book.is_low_on_tokens:
            self._book.begin_epoch(await self._next_epoch())

    def _observe_button(self, robot: Robot) -> None:
        if robot.safety is None:
            return
        was_pressed, is_pressed = robot.id in self._buttons, robot.safety.hardware_stop
        if is_pressed and not was_pressed:
            self._buttons.add(robot.id)
            self._revoke(robot.id, "The red button on the machine")
        elif was_pressed and not is_pressed:
            self._buttons.discard(robot.id)

    def _revoke(self, robot_id: str, by: str) -> None:
        lease = self._book.revoke(robot_id)
        if lease is not None:
            self._end(lease, "revoked", f"{by} ended the control of {lease.holder.user_name}.")

    def _admit(self, actor: SessionInfo, robot_id: str, op: LeaseOp, tick_id: str, reason: str) -> Robot:
        permission = Permission.TAKE_LEASE if op is LeaseOp.TAKE else Permission.LEASE
        robot = self._gate.right(actor, permission, robot_id)
        self._sweep()
        self.observe(robot)
        # Giving control back and keeping it are never refused for being late: neither gives power to anybody.
        if op not in (LeaseOp.RELEASE, LeaseOp.KEEP):
            self._gate.decided_now(tick_id)
        if op is LeaseOp.TAKE and not reason.strip():
            raise OrderRefused(REASON_MISSING, "Say why you take control.")
        return robot

    def _apply(self, actor: SessionInfo, robot_id: str, op: LeaseOp, to_session: str | None) -> LeaseAnswer:
        now_s = self._clock.mono_s()
        if op is LeaseOp.REQUEST:
            return self._book.request(robot_id, _holder(actor), now_s)
        if op is LeaseOp.TAKE:
            return self._book.take(robot_id, _holder(actor), now_s)
        if op is LeaseOp.RELEASE:
            return self._book.release(robot_id, actor.session_id, now_s)
        if op is LeaseOp.KEEP:
            return self._book.keep(robot_id, actor.session_id, to_session, now_s)
        self._forget_absent(robot_id, now_s)
        return self._book.grant(robot_id, actor.session_id, to_session, now_s)

    def _forget_absent(self, robot_id: str, now_s: float) -> None:
        lease = self._book.of(robot_id, now_s)
        for ask in lease.asks if lease is not None else ():
            if not self._is_signed_in(ask.holder.session_id):
                self._book.release(robot_id, ask.holder.session_id, now_s)

    def _settle(
        self,
        actor: SessionInfo,
        robot: Robot,
        op: LeaseOp,
        answer: LeaseAnswer,
        text: str,
        *,
        before: Lease | None,
        reason: str,
    ) -> None:
        self._farms[robot.id] = robot.farm_id
        if answer.ended is not None:
            self._announce_end(answer.ended)
        self._write(actor, robot.id, op, answer.code.value, text, reason)
        if answer.lease != before:
            self._on_event(lease_event(robot.id, op.value, text, answer.lease, by=actor.user_name))

    def _sweep(self) -> None:
        for lease in self._book.expire(self._clock.mono_s()):
            name = lease.holder.user_name
            self._end(lease, "expired", f"{name} lost control: no sign of life from the page for 10 s.")

    def _announce_end(self, lease: Lease) -> None:
        for callback in self._on_ended:
            callback(lease)
        self._book.forget(lease)

    def _end(self, lease: Lease, op: str, text: str) -> None:
        self._announce_end(lease)
        who, robot_id = lease.holder, lease.robot_id
        farm_id = self._farms.get(robot_id, "")
        entry = AuditEntry(
            farm_id, who.user_name, who.device_name, "lease", op, robot_id, str(lease.token), text, {"op": op}
        )
        self._audit.append(entry)
        self._on_event(lease_event(robot_id, op, text, None, by=who.user_name))

    def _write(self, actor: SessionInfo, robot_id: str, op: LeaseOp, outcome: str, text: str, reason: str) -> None:
        lease = self.of(robot_id)
        token = str(lease.token) if lease is not None else ""
        data = {"op": op.value, "reason": reason}
        entry = AuditEntry(
            actor.farm_id, actor.user_name, actor.device_name, "lease", outcome, robot_id, token, text, data
        )
        self._audit.append(entry)


def _holder(actor: SessionInfo) -> Holder:
    return Holder(actor.session_id, actor.user_id, actor.user_name, actor.device_name)

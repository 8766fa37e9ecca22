"""After STOP ALL the whole queue stands still until a person releases it; also over a restart of the console."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from hmi.clock import Clock
from hmi.commands.gate import Gate
from hmi.commands.ports import AuditSink, LaneEvent
from hmi.commands.queue_arming import QueueArming
from hmi.commands.refusal import REASON_MISSING, OrderRefused
from hmi.domain.robot import Robot
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry
from hmi.store.queue import Freeze, QueueStore

FEW = 2  # one press on this many robots was a STOP ALL, even if only the STOP gateway heard it


class QueueFreeze:
    """Freezes and releases.

    Args:
        robots: every robot as it is known now.
    """

    def __init__(
        self,
        store: QueueStore,
        arming: QueueArming,
        gate: Gate,
        authorize: Authorize,
        audit: AuditSink,
        clock: Clock,
        on_event: LaneEvent,
        *,
        farm_id: str,
        robots: Callable[[], list[Robot]],
    ) -> None:
        self._store, self._arming, self._gate, self._authorize = store, arming, gate, authorize
        self._audit, self._clock, self._on_event = audit, clock, on_event
        self._farm_id, self._robots = farm_id, robots

    @property
    def is_frozen(self) -> bool:
        """Whether nothing may be sent or started by a queue."""
        freeze = self._store.freeze()
        return freeze is not None and freeze.is_frozen

    def stop_all(self, stop_id: str, by: str) -> None:
        """Freeze because somebody stopped all robots; the same press freezes once."""
        freeze = self._store.freeze()
        known = freeze.stop_ids if freeze is not None else ()
        if stop_id in known:
            return
        self._arming.end_all(f"{by or 'Somebody'} pressed STOP ALL.")
        after = Freeze(is_frozen=True, by=by, at=self._clock.utc(), stop_ids=(*known, stop_id))
        if freeze is not None and freeze.is_frozen:
            after = replace(freeze, stop_ids=after.stop_ids)
        self._keep(after)
        self._write("frozen", by or "Somebody", "", f"STOP ALL by {by or 'somebody'} froze the queue.", {})

    def observe(self, robot: Robot) -> None:
        """Freeze if robots report one press together, which is how a STOP ALL shows that only the gateway heard."""
        freeze = self._store.freeze()
        known = freeze.stop_ids if freeze is not None else ()
        for press in robot.safety.presses if robot.safety is not None else ():
            if not press.is_reset and press.stop_id not in known and self._count(press.stop_id) >= FEW:
                self.stop_all(press.stop_id, press.by or press.device)

    def release(self, session: SessionInfo, reason: str, tick_id: str) -> None:
        """Let the queue go on; it is not armed by it.

        Raises:
            OrderRefused: no reason, an old picture, or it is not frozen.
        """
        self._authorize(session, Permission.RESET)
        self._gate.decided_now(tick_id)
        freeze = self._store.freeze()
        if freeze is None or not freeze.is_frozen:
            raise OrderRefused("not_frozen", "The queue is not frozen.")
        if not reason.strip():
            raise OrderRefused(REASON_MISSING, "Say why the queue may go on.")
        live = {p.stop_id for r in self._robots() if r.safety is not None for p in r.safety.presses if not p.is_reset}
        known = (*(one for one in freeze.stop_ids if one not in live), *sorted(live))
        now = self._clock.utc()
        self._keep(
            replace(
                freeze,
                is_frozen=False,
                stop_ids=known,
                released_by=session.user_name,
                released_at=now,
                reason=reason.strip(),
            )
        )
        self._write(
            "released", session.user_name, session.device_name, "The queue was released.", {"reason": reason.strip()}
        )

    def _keep(self, freeze: Freeze) -> None:
        self._store.remember_freeze(freeze)
        self._arming.later(self._store.write_freeze, "freeze of the queue")

    def _count(self, stop_id: str) -> int:
        pressed = (r.safety.presses for r in self._robots() if r.is_registered and r.safety is not None)
        return sum(any(p.stop_id == stop_id and not p.is_reset for p in presses) for presses in pressed)

    def _write(self, outcome: str, by: str, device: str, text: str, data: dict[str, str]) -> None:
        self._audit.append(AuditEntry(self._farm_id, by, device, "queue", outcome, None, "", text, data))
        self._on_event({"kind": "queue", "robot": None, "what": outcome, "text": text})

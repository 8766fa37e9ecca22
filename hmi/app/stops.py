"""STOP in the console: the second path, wired to registry, leases and audit."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from hmi.clock import Clock
from hmi.commands.lease_service import LeaseService
from hmi.commands.ports import AuditSink, Pressers
from hmi.commands.stop import MovedOn, StopService
from hmi.domain.command import OrderSender
from hmi.domain.stop import StopTarget
from hmi.domain.stop_token import StopToken
from hmi.stop_gateway.outbox import open_presses
from hmi.store.audit_chain import AuditEntry
from hmi.store.robots import Robots

log = logging.getLogger(__name__)


class StopDesk:
    """Presses of people as REST takes them; each is audited after it was sent, and ends the robot's lease.

    Args:
        outbox: the gateway's file of open presses; it may be missing.
        on_stop: told robot and person of each new press, after it was sent.
        on_stop_all: told press and person of each STOP ALL, after it was sent.
        on_move: told the robots at which a press moved on.
        on_new: told each new press and who made it, after it was sent.
    """

    def __init__(
        self,
        sender: OrderSender,
        clock: Clock,
        robots: Robots,
        audit: AuditSink,
        leases: LeaseService,
        outbox: Path,
        *,
        on_stop: Callable[[str, str], None] = lambda _robot_id, _by: None,
        on_stop_all: Callable[[str, str], None] = lambda _stop_id, _by: None,
        on_move: MovedOn = lambda _robots: None,
        on_new: Callable[[str, StopToken], None] = lambda _stop_id, _token: None,
    ) -> None:
        self._on_new = on_new
        self._audit, self._robots, self._leases, self._outbox = audit, robots, leases, outbox
        self._on_stop, self._on_stop_all = on_stop, on_stop_all
        self.service = StopService(sender, clock, self, on_press=self._pressed, on_move=on_move)
        self._task: asyncio.Task[None] | None = None

    def stop_targets(self) -> Mapping[str, StopTarget]:
        """Return every registered robot by its id."""
        return {
            r.id: StopTarget(r.id, r.name, r.decel_mps2, r.ack_limit_s, r.standstill_limit_s)
            for r in self._robots.all()
        }

    def press(self, stop_id: str, robots: Sequence[str] | Literal["all"], token: StopToken) -> list[dict[str, Any]]:
        """Send at once; then note who pressed."""
        is_new = not self.service.steps(stop_id)
        steps = self.service.press(stop_id, robots, token.who, token.device_name, token.user_id)
        if robots == "all":
            self._tell(lambda: self._on_stop_all(stop_id, token.who))
        if is_new:
            self._tell(lambda: self._on_new(stop_id, token))
            for step in steps:
                self._audit.append(
                    AuditEntry(token.farm_id, token.who, token.device_name, "stop", "sent", str(step["robot"]), stop_id)
                )
        return steps

    def _pressed(self, robot_id: str, stop_id: str, by: str) -> None:
        self._tell(lambda: self._on_stop(robot_id, by))
        self._leases.stopped(robot_id, stop_id, by)

    @staticmethod
    def _tell(work: Callable[[], None]) -> None:
        try:
            work()
        except Exception:  # whoever is told must never stand between a person and STOP
            log.exception("somebody could not be told of a STOP")

    def steps(self, stop_id: str | None = None) -> list[dict[str, Any]]:
        """Return the steps of one press."""
        return self.service.steps(stop_id) if stop_id else []

    async def is_open_at(self, robot_id: str) -> bool:
        """Say whether console or gateway hold a press at this robot that is not reset."""
        if self.service.attempts_at(robot_id):
            return True
        held = await asyncio.to_thread(open_presses, self._outbox)
        return any(press.robot == robot_id for press in held)

    async def pressers(self, robot_id: str) -> Pressers:
        """Return who pressed what is open at a robot, as the signed tokens told console and gateway."""
        found: dict[str, set[str]] = {}
        held = await asyncio.to_thread(open_presses, self._outbox)
        pairs = [(press.stop_id, press.user_id) for press in self.service.attempts_at(robot_id)]
        pairs += [(press.stop_id, press.user_id) for press in held if press.robot == robot_id]
        for stop_id, user_id in pairs:
            if user_id is not None:
                found.setdefault(stop_id, set()).add(user_id)
        return found

    def start(self) -> None:
        """Begin to repeat what is not confirmed."""
        self._task = asyncio.create_task(self.service.run(), name="console-stop")

    async def stop(self) -> None:
        """End the task."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task
        await self.service.close()

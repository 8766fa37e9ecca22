"""Everything that sends orders, put together once for the composition root."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from hmi.clock import Clock
from hmi.commands.drive import DriveRelay
from hmi.commands.gate import Gate
from hmi.commands.lease_service import LeaseService
from hmi.commands.ledger import ACK_LIMIT_S, OrderLedger
from hmi.commands.mission_send import MissionSender
from hmi.commands.operator_pulse import OperatorPulseRelay
from hmi.commands.ports import AuditSink, FleetReader, LaneEvent, MissionStore, Pressers, StartRules, TickJudge
from hmi.commands.reset import ResetService, nobody_known
from hmi.commands.seen import SeenService
from hmi.commands.service import CommandService
from hmi.domain.command import OrderSender
from hmi.security.authorization import Authorize

TEND_S = 0.5  # a lease ends at most this long after its time
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class CommandPorts:
    """What the services are wired to.

    Args:
        epoch: a number greater than at any start before (``Counters.next_epoch("lease")``).
        next_epoch: draws a further one.
        is_signed_in: whether a session id is still open.
        pressers: who pressed what is open at a robot.
    """

    fleet: FleetReader
    ticks: TickJudge
    sender: OrderSender
    audit: AuditSink
    missions: MissionStore
    clock: Clock
    authorize: Authorize
    on_event: LaneEvent
    epoch: int
    next_epoch: Callable[[], Awaitable[int]]
    is_signed_in: Callable[[str], bool] = lambda _session_id: True
    ack_limit_s: float = ACK_LIMIT_S
    start_rules: StartRules | None = None
    pressers: Callable[[str], Awaitable[Pressers]] = nobody_known


class CommandDesk:
    """The command services of one console, with the task that ends leases and manual driving in time.

    The composition root calls ``ledger.acknowledged`` with every acknowledgement, ``leases.observe`` or
    ``leases.stopped`` on STOP, ``leases.end_session`` at sign-out, ``drive.connection_lost`` when a lane ends.
    """

    def __init__(self, ports: CommandPorts) -> None:
        gate = Gate(ports.fleet, ports.ticks, ports.clock, ports.authorize)
        self.leases = LeaseService(
            gate,
            ports.clock,
            ports.audit,
            ports.on_event,
            epoch=ports.epoch,
            next_epoch=ports.next_epoch,
            is_signed_in=ports.is_signed_in,
        )
        self.ledger = OrderLedger(
            ports.sender, ports.fleet, ports.clock, ports.audit, ports.on_event, ack_limit_s=ports.ack_limit_s
        )
        self.gate = gate
        self.commands = CommandService(gate, self.leases, self.ledger, ports.start_rules)
        self.resets = ResetService(gate, self.leases, self.ledger, ports.fleet, ports.pressers)
        self.seen = SeenService(gate, ports.audit)
        self.missions = MissionSender(gate, ports.missions, ports.sender, ports.audit, ports.on_event)
        self.pulse = OperatorPulseRelay(self.leases, ports.fleet, ports.ticks, ports.sender, ports.clock)
        self.drive = DriveRelay(
            gate,
            self.leases,
            ports.fleet,
            ports.ticks,
            ports.sender,
            ports.clock,
            ports.on_event,
            self.commands.close_drive,
        )
        self.ledger.when_settled(self.drive.command_settled)
        self.ledger.when_revoked(self.leases.revoked_by_robot)
        self._task: asyncio.Task[None] | None = None

    def start(self) -> None:
        """Begin to end leases and manual driving in time."""
        self._task = asyncio.create_task(self._tend(), name="command-desk")

    async def close(self) -> None:
        """End the task and every wait; orders still open are recorded as unknown."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task
            self._task = None
        await self.ledger.close()

    async def tend(self) -> None:
        """Do once what ``start`` does twice a second."""
        await self.drive.tend()
        await self.leases.tend()

    async def _tend(self) -> None:
        while True:
            try:
                await self.tend()
            except Exception:  # a full database must not stop leases from ending
                log.exception("tending leases failed; trying again")
            await asyncio.sleep(TEND_S)

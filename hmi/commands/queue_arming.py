"""Who lets a queue start missions without a person at the moment, and everything that ends it.

The invariant: a queue is armed only as long as the console holds the robot's control lease for it. Whatever ends
that lease (a stop, a person who asks for control, the robot's removal, silence) ends the arming, and the other way
round.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import timedelta
from typing import Any
from zoneinfo import ZoneInfo

from hmi.clock import Clock
from hmi.commands.gate import Gate
from hmi.commands.lease_service import LeaseService
from hmi.commands.ports import AuditSink, LaneEvent
from hmi.commands.refusal import OrderRefused
from hmi.domain.ids import new_id
from hmi.domain.lease import Lease
from hmi.domain.queue.arming import MAX_S, MIN_S, Arming, ArmingBook
from hmi.domain.queue.reason import clock_text
from hmi.domain.robot import Robot
from hmi.domain.role import Permission, Role
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.errors import StoreError
from hmi.store.queue import QueueStore
from hmi.store.queue_armings import QueueArmings
from hmi.store.robots import Robots

RESTARTED = "The console was restarted."
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ArmingParts:
    """What arming is wired to."""

    store: QueueStore
    armings: QueueArmings
    robots: Robots
    database: Database
    gate: Gate
    leases: LeaseService
    audit: AuditSink
    clock: Clock
    zone: ZoneInfo
    farm_id: str
    on_event: LaneEvent


class QueueArming:
    """Arms and disarms queues. Everything but ``arm`` and ``load`` acts at once, without waiting."""

    def __init__(self, parts: ArmingParts, book: ArmingBook) -> None:
        self._parts, self.book = parts, book
        self._tasks: set[asyncio.Task[None]] = set()
        parts.leases.when_ended(self._lease_ended)

    async def load(self) -> None:
        """End on paper what a console before this one left armed; remember why queues are not armed."""
        parts, now = self._parts, self._parts.clock.utc()
        for robot_id in await parts.database.run(parts.armings.end_all, RESTARTED, now):
            self._write(robot_id, "disarmed", RESTARTED, {})
        for robot_id, (why, at) in (await parts.database.run(parts.armings.last)).items():
            self.book.note_ended(robot_id, why, at)

    async def arm(
        self, session: SessionInfo, wanted: Mapping[str, int], duration_s: float, tick_id: str
    ) -> tuple[Arming, ...]:
        """Arm the queues of these robots until now + ``duration_s``; all of them or none.

        Args:
            wanted: robot to the revision of its queue that the person saw.

        Raises:
            OrderRefused: with the sentence why not.
        """
        parts = self._parts
        try:
            robots = self._admit(session, wanted, duration_s, tick_id)
            now = parts.clock.utc()
            made = self._made(session, wanted, now + timedelta(seconds=duration_s))
            self._take_control(session, robots, made)
        except OrderRefused as refused:
            for robot_id in wanted:
                self._write(robot_id, "refused", refused.text, {"code": refused.code}, session)
            raise
        try:
            await parts.database.run(parts.armings.begin, made)
            self._confirm(wanted, made)
        except (StoreError, OrderRefused):
            for one in made:
                self._undo(one)
            raise
        for one in made:
            self.book.put(one)
            text = f"{one.by} armed the queue until {self._clock_of(one)}."
            self._write(one.robot_id, "armed", text, {"arming": one.id, "revision": one.revision}, session)
            self._tell(one.robot_id, "armed", text)
        return made

    def disarm(self, session: SessionInfo, robots: Sequence[str]) -> None:
        """End arming because a person says so; as free as STOP is."""
        for robot_id in robots:
            self._parts.gate.right(session, Permission.STOP, robot_id)
        for robot_id in robots:
            self.end(robot_id, f"{session.user_name} disarmed it.", session)

    def end(self, robot_id: str, why: str, session: SessionInfo | None = None) -> bool:
        """Disarm one robot's queue; return whether it was armed."""
        arming = self.book.end(robot_id, why, self._parts.clock.utc())
        if arming is None:
            return False
        self._give_back(arming, f"The queue is not armed any more. {why}")
        self._write(robot_id, "disarmed", why, {"arming": arming.id}, session)
        self._tell(robot_id, "disarmed", why)
        ended = self._parts.clock.utc()
        self.later(lambda: self._parts.armings.end(arming, why, ended), f"disarming of {robot_id}")
        return True

    def end_all(self, why: str) -> None:
        """Disarm everything."""
        for arming in self.book.live():
            self.end(arming.robot_id, why)

    def stopped(self, robot_id: str, by: str) -> None:
        """Disarm because STOP was pressed for this robot, on whatever way it is learnt."""
        self.end(robot_id, f"{by or 'Somebody'} pressed STOP.")

    def observe(self, robot: Robot) -> None:
        """Disarm if the robot says that it is stopped."""
        safety = robot.safety
        if safety is None or not (safety.latched or safety.hardware_stop) or self.book.of(robot.id) is None:
            return
        by = next((p.by for p in safety.presses if not p.is_reset and p.by), "")
        pressed = f"{by or 'Somebody'} pressed STOP."
        self.end(robot.id, "The red button on the machine was pressed." if safety.hardware_stop else pressed)

    def tend(self) -> None:
        """End what is over, keep the leases of the rest alive; call every second."""
        now, now_s = self._parts.clock.utc(), self._parts.clock.mono_s()
        if self.book.was_held_up(now, now_s):
            self.end_all("The console was held up, or its clock was set. Nothing starts late.")
        for arming in self.book.due(now, now_s):
            self.end(arming.robot_id, f"Its time was over at {self._clock_of(arming)}.")
        for arming in self.book.live():
            if self._parts.leases.prove_life(session_id(arming), arming.robot_id) is None:
                self.end(arming.robot_id, "The queue lost control of the robot.")

    async def close(self) -> None:
        """Disarm everything and write it down."""
        self.end_all("The console was shut down.")
        await asyncio.gather(*self._tasks, return_exceptions=True)

    def later(self, work: Callable[[], None], what: str) -> None:
        """Write something without anybody waiting for it."""

        async def run() -> None:
            try:
                await self._parts.database.run(work)
            except StoreError:
                log.exception("%s was not written", what)

        task = asyncio.get_running_loop().create_task(run(), name=f"queue: {what}")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def system(self, arming: Arming) -> SessionInfo:
        """Return whom the console acts as: the queue, with who armed it and until when; shown as owner."""
        name = f"Queue, armed by {arming.by} until {self._clock_of(arming)}"
        return system_session(self._parts.farm_id, session_id(arming), name, self._parts.clock)

    def _admit(
        self, session: SessionInfo, wanted: Mapping[str, int], duration_s: float, tick_id: str
    ) -> list[Robot]:  # fmt: skip
        gate, store = self._parts.gate, self._parts.store
        robots = [gate.right(session, Permission.START, robot_id) for robot_id in wanted]
        gate.decided_now(tick_id)
        freeze = store.freeze()
        if freeze is not None and freeze.is_frozen:
            raise OrderRefused("frozen", "The queue is frozen since STOP ALL. Release it first.")
        if not robots or not MIN_S <= duration_s <= MAX_S:
            raise OrderRefused("bad_duration", "Arm at least one robot, for 5 minutes to 12 hours.")
        for robot in robots:
            self._admit_robot(session, robot, wanted[robot.id])
        return robots

    def _admit_robot(self, session: SessionInfo, robot: Robot, revision: int) -> None:
        entry, store = self._parts.robots.get(robot.id), self._parts.store
        if entry is None or not entry.is_unattended_allowed:
            text = f"{robot.name} may not run without a person. An admin can allow it with `headland robot unattended`."
            raise OrderRefused("robot_attended", text)
        if store.revision(robot.id) != revision:
            raise OrderRefused("queue_changed", f"The queue of {robot.name} was changed. Look again, then arm it.")
        if not any(one.is_unattended for one in store.entries(robot.id)):
            text = f"Nothing in the queue of {robot.name} starts by itself. Mark a mission unattended first."
            raise OrderRefused("nothing_unattended", text)
        self._parts.gate.may_move(robot)
        lease = self._parts.leases.of(robot.id)
        if lease is not None and not lease.holder.is_system and lease.holder.session_id != session.session_id:
            raise OrderRefused("held_by_other", f"{lease.holder.user_name} has control of {robot.name}. Ask for it.")

    def _made(self, session: SessionInfo, wanted: Mapping[str, int], until: Any) -> tuple[Arming, ...]:
        now, now_s = self._parts.clock.utc(), self._parts.clock.mono_s()
        arming_id, until_s = new_id()[:16], now_s + (until - now).total_seconds()
        return tuple(
            Arming(arming_id, robot_id, revision, session.user_name, session.user_id, now, until, until_s)
            for robot_id, revision in wanted.items()
        )

    def _take_control(self, session: SessionInfo, robots: Sequence[Robot], made: Sequence[Arming]) -> None:
        taken: list[Arming] = []
        try:
            for robot, arming in zip(robots, made, strict=True):
                self._parts.leases.hold_for_system(self.system(arming), robot, session)
                taken.append(arming)
        except OrderRefused:
            for arming in taken:
                self._give_back(arming, "It was not armed.")
            raise

    def _confirm(self, wanted: Mapping[str, int], made: Sequence[Arming]) -> None:
        """Ask again what may have changed while the record was written."""
        freeze = self._parts.store.freeze()
        for arming in made:
            is_held = self._parts.leases.holds(session_id(arming), arming.robot_id) is not None
            is_same = self._parts.store.revision(arming.robot_id) == wanted[arming.robot_id]
            if not is_held or not is_same or (freeze is not None and freeze.is_frozen):
                raise OrderRefused("queue_changed", "Something changed meanwhile. Look again, then arm it.")

    def _undo(self, arming: Arming) -> None:
        self._give_back(arming, "It was not armed.")
        ended = self._parts.clock.utc()
        self.later(lambda: self._parts.armings.end(arming, "Not armed.", ended), f"arming of {arming.robot_id}")

    def _give_back(self, arming: Arming, text: str) -> None:
        self._parts.leases.give_back(self.system(arming), arming.robot_id, text)

    def _lease_ended(self, lease: Lease) -> None:
        arming = self.book.of(lease.robot_id)
        if arming is None or lease.holder.session_id != session_id(arming):
            return
        now = self._parts.leases.of(lease.robot_id)
        taken = now is not None and now.holder.session_id != lease.holder.session_id
        if taken and now is not None:
            why = "It was armed anew." if now.holder.is_system else f"{now.holder.user_name} took control."
        else:
            why = "The queue lost control of the robot, by a stop or by silence."
        self.end(lease.robot_id, why)

    def _clock_of(self, arming: Arming) -> str:
        return clock_text(arming.until, self._parts.clock.utc(), self._parts.zone)

    def _tell(self, robot_id: str, what: str, text: str) -> None:
        self._parts.on_event({"kind": "queue", "robot": robot_id, "what": what, "text": text})

    def _write(
        self, robot_id: str, outcome: str, text: str, data: dict[str, Any], session: SessionInfo | None = None
    ) -> None:
        by = ("Queue", "") if session is None else (session.user_name, session.device_name)
        self._parts.audit.append(
            AuditEntry(self._parts.farm_id, *by, "queue", outcome, robot_id, str(data.get("arming", "")), text, data)
        )


def session_id(arming: Arming) -> str:
    """Return the name under which an arming holds its lease."""
    return f"queue-{arming.id}"


def system_session(farm_id: str, session: str, name: str, clock: Clock) -> SessionInfo:
    """Return the console's own session for what a queue does; it opens nothing and has no cookie."""
    return SessionInfo(
        session_id=session,
        user_id="queue",
        user_name=name[:80],
        role=Role.OPERATOR,
        device_id="",
        device_name="",
        farm_id=farm_id,
        csrf="",
        expires_utc=clock.utc() + timedelta(minutes=1),
    )


__all__ = ["RESTARTED", "ArmingParts", "QueueArming", "session_id", "system_session"]

"""Works through the queues: looks each second what every entry waits for, sends what is next, starts what is armed.

Sending moves nothing and happens as soon as a robot is free. Starting is decided in the very moment of sending the
order, from facts of that moment; a start that was not taken is never repeated by itself: the queue is disarmed.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from datetime import datetime, timedelta

from hmi.clock import Clock
from hmi.commands.ledger import CommandResult
from hmi.commands.mission_send import MissionSender
from hmi.commands.ports import LaneEvent
from hmi.commands.queue_arming import QueueArming, system_session
from hmi.commands.queue_facts import FactDesk
from hmi.commands.queue_life import QueueLife
from hmi.commands.refusal import NOT_NOW, OrderRefused
from hmi.commands.service import CommandService, UnattendedStart
from hmi.domain.command import Outcome
from hmi.domain.ids import new_id
from hmi.domain.mission import ON_ROBOT
from hmi.domain.queue.arming import Arming
from hmi.domain.queue.entry import Entry
from hmi.domain.queue.reason import Waiting, Who
from hmi.domain.queue.waiting import Step, Verdict, why_waiting
from hmi.store.errors import StoreError
from hmi.store.missions import Missions
from hmi.store.queue import QueueStore

LOOK_S = 1.0
AGAIN_S = 30.0  # after a mission could not be sent; sending moves nothing, so it may be tried again
READ_BACK_S = 5.0  # how long a robot may take to tell that it holds what it was sent
DRIVES_WITHIN_S = 10.0  # the horn takes 3 s; after this a start that was taken and shows nothing is not trusted
CANNOT_JUDGE = "Something is wrong with this queue; see the console's log."
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RunnerParts:
    """What the runner is wired to.

    Args:
        may_still_start: whether the person who armed is still somebody who may; asked before each start.
        on_sent: told of the robot and the hash of each mission the queue itself has sent.
    """

    store: QueueStore
    missions: Missions
    facts: FactDesk
    life: QueueLife
    arming: QueueArming
    sender: MissionSender
    commands: CommandService
    clock: Clock
    on_event: LaneEvent
    farm_id: str
    may_still_start: Callable[[str], Awaitable[bool]]
    on_sent: Callable[[str, str], None]


@dataclass(frozen=True, slots=True)
class Shown:
    """What an entry waits for, and since when."""

    verdict: Verdict
    since: datetime


class QueueRunner:
    """A task beside the console's work. ``look`` does once what ``start`` does each second."""

    def __init__(self, parts: RunnerParts) -> None:
        self._parts = parts
        self._shown: dict[str, Shown] = {}
        self._pauses: dict[str, tuple[str, datetime]] = {}
        self._started: dict[str, float] = {}
        self._sent: dict[str, float] = {}
        self._under_way: dict[str, asyncio.Task[None]] = {}
        self._task: asyncio.Task[None] | None = None

    def shown(self, entry_id: str) -> Shown | None:
        """Return what an entry waits for, as of the last look."""
        return self._shown.get(entry_id)

    def start(self) -> None:
        """Begin to look."""
        self._task = asyncio.create_task(self._run(), name="mission-queue")

    async def close(self) -> None:
        """End; an order that is under way keeps its own account."""
        tasks = [*self._under_way.values(), *([self._task] if self._task is not None else [])]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        self._task = None

    async def look(self) -> None:
        """Judge every entry now, and begin with what is next; returns before a mission is sent."""
        parts = self._parts
        parts.arming.tend()
        for robot_id in {one.robot_id for one in parts.store.entries()}:
            if robot_id not in self._under_way:
                await self._look_alone(robot_id)
        known = {one.id for one in parts.store.entries()}
        self._shown = {key: one for key, one in self._shown.items() if key in known}
        self._started = {key: at for key, at in self._started.items() if key in known}
        self._pauses = {key: one for key, one in self._pauses.items() if key in known}
        self._sent = {key: at for key, at in self._sent.items() if key in known}

    async def settled(self) -> None:
        """Wait until nothing is being sent or started."""
        await asyncio.gather(*self._under_way.values(), return_exceptions=True)

    async def _look_alone(self, robot_id: str) -> None:
        """Look at one robot; what cannot be judged there holds up nobody else, and nothing starts by itself there."""
        try:
            await self._look_at(robot_id)
        except StoreError:
            raise
        except Exception:
            log.exception("the queue of %s cannot be judged", robot_id)
            self._parts.arming.end(robot_id, CANNOT_JUDGE)
            for entry in self._parts.store.entries(robot_id):
                waiting = Waiting("not_judged", CANNOT_JUDGE, "Take it out and queue it again.", Who.PLANNER)
                self._show(entry, Verdict(Step.WAIT, waiting))

    async def _look_at(self, robot_id: str) -> None:
        await self._parts.life.follow(robot_id)
        entries = self._in_order(robot_id)
        verdicts = self._judge(entries)
        for entry in entries:
            self._show(entry, verdicts[entry.id])
        await self._parts.life.mark(robot_id, {one.id: verdicts[one.id] for one in entries})
        chosen = next((one for one in entries if verdicts[one.id].step in (Step.SEND, Step.START)), None)
        if chosen is not None and not self._is_under_way(chosen, verdicts[chosen.id]):
            work = self._send if verdicts[chosen.id].step is Step.SEND else self._begin
            self._do(robot_id, work(chosen))
        await self._notice_no_start(entries)

    def _in_order(self, robot_id: str) -> list[Entry]:
        """Return a robot's entries in the order in which they are looked at: what is on the robot first."""
        return sorted(self._parts.store.entries(robot_id), key=lambda one: (not self._is_on_robot(one), one.position))

    def _judge(self, entries: list[Entry]) -> dict[str, Verdict]:
        verdicts: dict[str, Verdict] = {}
        ahead = None
        for entry in entries:
            verdicts[entry.id] = self._verdict(entry, ahead)
            # what is not due yet does not hold up what could go now
            if ahead is None and verdicts[entry.id].waiting.code not in ("not_due", "mission_gone", "missed"):
                ahead = entry
        return verdicts

    def _verdict(self, entry: Entry, ahead: Entry | None) -> Verdict:
        before = None if ahead is None else self._parts.missions.known(ahead.mission_id)
        facts = self._parts.facts.of(entry, before, self._pauses.get(entry.id))
        return why_waiting(entry, facts)

    def _is_on_robot(self, entry: Entry) -> bool:
        mission = self._parts.missions.known(entry.mission_id)
        return mission is not None and mission.status in ON_ROBOT

    def _is_under_way(self, entry: Entry, verdict: Verdict) -> bool:
        """Say whether the step was made a moment ago and the robot has yet to tell of it."""
        at_s = self._sent.get(entry.id)
        is_sent = at_s is not None and self._parts.clock.mono_s() - at_s < READ_BACK_S
        return entry.id in self._started or (verdict.step is Step.SEND and is_sent)

    def _show(self, entry: Entry, verdict: Verdict) -> None:
        before = self._shown.get(entry.id)
        is_same = before is not None and before.verdict.waiting.code == verdict.waiting.code
        since = before.since if before is not None and is_same else self._parts.clock.utc()
        self._shown[entry.id] = Shown(verdict, since)
        if not is_same:
            waiting = verdict.waiting
            told = {"kind": "queue", "robot": entry.robot_id, "what": "waiting", "entry": entry.id}
            self._parts.on_event({**told, "code": waiting.code, "text": waiting.text})

    def _do(self, robot_id: str, work: Awaitable[None]) -> None:
        async def run() -> None:
            try:
                await work
            except Exception:
                log.exception("the queue of %s failed at its next mission", robot_id)
                self._parts.arming.end(robot_id, "Something went wrong in the queue; see the console's log.")
            finally:
                self._under_way.pop(robot_id, None)

        self._under_way[robot_id] = asyncio.create_task(run(), name=f"mission-queue {robot_id}")

    async def _send(self, entry: Entry) -> None:
        actor = system_session(self._parts.farm_id, f"queue-{entry.robot_id}", "Queue", self._parts.clock)
        sent = await self._parts.sender.send(actor, entry.robot_id, entry.mission_id)
        if sent.outcome is Outcome.ACCEPTED:
            self._parts.on_sent(entry.robot_id, str(sent.sha256))
            self._pauses.pop(entry.id, None)
            self._sent[entry.id] = self._parts.clock.mono_s()
            return
        self._pauses[entry.id] = (f"Not sent: {sent.text}", self._parts.clock.utc() + timedelta(seconds=AGAIN_S))

    async def _begin(self, entry: Entry) -> None:
        parts = self._parts
        arming, mission = parts.arming.book.of(entry.robot_id), parts.missions.known(entry.mission_id)
        if arming is None or mission is None:
            return
        if not await parts.may_still_start(arming.user_id):
            parts.arming.end(entry.robot_id, f"{arming.by} may not start robots any more.")
            return
        request = UnattendedStart(entry.robot_id, new_id(), entry.mission_id, mission.sha256)
        self._started[entry.id] = parts.clock.mono_s()
        result = await parts.commands.start_unattended(
            parts.arming.system(arming), request, lambda: self._still(entry, arming)
        )
        self._after_start(entry, result)

    def _still(self, entry: Entry, arming: Arming) -> None:
        """Judge once more in the moment of sending; nothing runs between this and the wire.

        Raises:
            OrderRefused: anything is not as it was.
        """
        parts = self._parts
        now, now_s = parts.clock.utc(), parts.clock.mono_s()
        is_same = parts.store.revision(entry.robot_id) == arming.revision
        is_same = is_same and parts.arming.book.of(entry.robot_id) is arming
        if not is_same or arming.is_over(now, now_s):
            raise OrderRefused("not_armed", "The queue is not armed any more.")
        entries = self._in_order(entry.robot_id)
        verdict = self._judge(entries).get(entry.id)
        if verdict is None or verdict.step is not Step.START:
            raise OrderRefused(NOT_NOW, "Not started." if verdict is None else verdict.waiting.text)

    def _after_start(self, entry: Entry, result: CommandResult) -> None:
        if result.is_accepted:
            return
        del self._started[entry.id]
        if result.code == NOT_NOW:  # nothing was sent; the next look sees why
            return
        self._parts.arming.end(entry.robot_id, f"The start was not taken: {result.text}")

    async def _notice_no_start(self, entries: list[Entry]) -> None:
        now_s = self._parts.clock.mono_s()
        for entry in entries:
            at_s = self._started.get(entry.id)
            if at_s is None:
                continue
            if entry.started_at is not None:
                del self._started[entry.id]
            elif now_s - at_s > DRIVES_WITHIN_S and entry.robot_id not in self._under_way:
                del self._started[entry.id]
                self._parts.arming.end(entry.robot_id, "The robot took the start and does not drive.")

    async def _run(self) -> None:
        while True:
            try:
                await self.look()
            except StoreError as error:
                log.warning("the queue waits: %s", error)
            except Exception:
                log.exception("a look at the queue failed; nothing stays armed")
                with contextlib.suppress(Exception):
                    self._parts.arming.end_all("Something went wrong in the queue; see the console's log.")
            await asyncio.sleep(LOOK_S)

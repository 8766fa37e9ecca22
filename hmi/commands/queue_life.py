"""Keeps entries and missions in step: what ended leaves the queue, what repeats comes again, what waits is marked."""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Any
from zoneinfo import ZoneInfo

from hmi.clock import Clock
from hmi.commands.mission_book import MissionBook
from hmi.commands.ports import AuditSink, FleetReader, LaneEvent
from hmi.commands.queue_arming import QueueArming
from hmi.domain.ids import new_id
from hmi.domain.mission import ENDED, UNDER_WAY, BadMove, MissionStatus, Mover
from hmi.domain.queue.entry import Entry, EntryState
from hmi.domain.queue.reason import clock_text
from hmi.domain.queue.repeat import kept, next_start
from hmi.domain.queue.waiting import Verdict
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.missions import Mission, Missions
from hmi.store.queue import QueueStore

BY = "Queue"
_IN_LINE = ("not_due", "not_first")
_DATED = re.compile(r", (Mon|Tue|Wed|Thu|Fri|Sat|Sun) \d{1,2} [A-Z][a-z]{2}$")
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class LifeParts:
    """What the life of entries is wired to.

    Args:
        may_replace: as in ``QueueHandover``.
    """

    store: QueueStore
    missions: Missions
    book: MissionBook
    arming: QueueArming
    database: Database
    fleet: FleetReader
    audit: AuditSink
    clock: Clock
    zone: ZoneInfo
    on_event: LaneEvent
    may_replace: Callable[[str, str], bool]


class QueueLife:
    """Moves missions on as their entries go, and entries as their missions do."""

    def __init__(self, parts: LifeParts) -> None:
        self._parts = parts

    async def follow(self, robot_id: str) -> None:
        """Take over what happened to the missions of a robot's queue."""
        for entry in self._parts.store.entries(robot_id):
            try:
                await self._follow(entry)
            except NotFound:  # a person took it out at the same moment
                log.info("entry %s of %s is gone", entry.id, robot_id)

    async def _follow(self, entry: Entry) -> None:
        mission = self._parts.missions.known(entry.mission_id)
        if mission is None:
            return
        if mission.status in ENDED:
            await self._end(entry, mission)
        elif mission.status in UNDER_WAY and entry.started_at is None:
            await self._amend(entry, started_at=self._parts.clock.utc())
        elif mission.status is MissionStatus.VALIDATED:
            await self._back_in_line(entry, mission)
        elif entry.is_missed(self._parts.clock.utc()) and entry.repeat is not None and entry.is_unattended:
            await self._skip(entry, mission)

    async def mend(self, farm_id: str) -> None:
        """Give back missions that stand in line without a place, after a console that died while one was put in."""
        placed = {one.mission_id for one in self._parts.store.entries()}
        for mission in self._parts.missions.all_known(farm_id):
            if mission.status in (MissionStatus.QUEUED, MissionStatus.WAITING) and mission.id not in placed:
                await self._move(mission, MissionStatus.VALIDATED, "It stands in no queue.", Mover.PERSON)

    async def mark(self, robot_id: str, verdicts: Mapping[str, Verdict]) -> None:
        """Let missions say whether they stand in line or wait for something."""
        for entry in self._parts.store.entries(robot_id):
            mission, verdict = self._parts.missions.known(entry.mission_id), verdicts.get(entry.id)
            if mission is None or verdict is None:
                continue
            waits = verdict.waiting.code not in _IN_LINE
            if mission.status is MissionStatus.QUEUED and waits and verdict.step.value == "wait":
                await self._move(mission, MissionStatus.WAITING, verdict.waiting.text)
            elif mission.status is MissionStatus.WAITING and not waits:
                await self._move(mission, MissionStatus.QUEUED, verdict.waiting.text)

    async def _end(self, entry: Entry, mission: Mission) -> None:
        is_done = mission.status is MissionStatus.DONE
        now = self._parts.clock.utc()
        state = EntryState.DONE if is_done else EntryState.ENDED
        why = "Done." if is_done else f"The mission {'was aborted' if mission.status.value == 'aborted' else 'failed'}."
        if not is_done:
            # whoever ended it had a reason; the next mission must not drive off from it
            self._parts.arming.end(entry.robot_id, f"{mission.name}: {why[0].lower()}{why[1:]}")
        following = await self._following(entry, mission, now)
        added = [] if following is None else [following]
        fields = {"state": state, "ended_at": now, "why": why}
        await self._parts.database.run(lambda: self._parts.store.write(amended={entry.id: fields}, added=added))
        self._note(entry, state.value, f"{mission.name}: {why}")

    async def _following(self, entry: Entry, mission: Mission, now: datetime) -> Entry | None:
        """Make the next occurrence of a repeating job, as a copy of its mission."""
        start = self._next(entry, now)
        if start is None or entry.repeat is None or entry.earliest is None:
            return None
        parts, local = self._parts, start.astimezone(self._parts.zone)
        base = _DATED.sub("", mission.name)[:64]
        name = f"{base}, {local.strftime('%a')} {local.day} {local.strftime('%b')}"
        copy = await parts.book.again(entry.farm_id, mission.id, name, entry.added_by)
        await self._move(copy, MissionStatus.QUEUED, f"Repeats: {clock_text(start, now, parts.zone)}.", Mover.PERSON,
                         entry.added_by, entry.robot_id)  # fmt: skip
        last = max(one.position for one in parts.store.entries(entry.robot_id))
        return replace(
            entry,
            id=f"q-{new_id()[:12]}",
            mission_id=copy.id,
            position=last + 10,
            earliest=start,
            repeat=kept(entry.repeat, entry.earliest, parts.zone),
            added_at=now,
            started_at=None,
        )

    def _next(self, entry: Entry, now: datetime) -> datetime | None:
        if entry.repeat is None or entry.earliest is None:
            return None
        return next_start(entry.repeat, entry.earliest, now, self._parts.zone)

    async def _skip(self, entry: Entry, mission: Mission) -> None:
        """Leave out a day that was missed: its mission waits for the next one."""
        now, parts = self._parts.clock.utc(), self._parts
        start = self._next(entry, now)
        if start is None or entry.repeat is None or entry.earliest is None:
            return
        missed = clock_text(entry.earliest, now, parts.zone)
        text = f"Missed {missed}. Next: {clock_text(start, now, parts.zone)}."
        await self._amend(entry, earliest=start, repeat=kept(entry.repeat, entry.earliest, parts.zone))
        await parts.database.run(parts.missions.note, entry.farm_id, mission.id, BY, text)
        self._note(entry, "skipped", f"{mission.name}: {text}")

    async def _back_in_line(self, entry: Entry, mission: Mission) -> None:
        """The robot lost it, or a person gave it another one: it waits again, and nothing starts by itself."""
        robot = self._parts.fleet.robot(entry.robot_id)
        order = robot.state.order if robot is not None and robot.state is not None else None
        if order is None or not self._parts.may_replace(entry.robot_id, order.sha256):
            self._parts.arming.end(entry.robot_id, f"The robot does not have {mission.name} any more.")
        why = "Back in the queue: the robot does not have it any more."
        await self._move(mission, MissionStatus.QUEUED, why, Mover.PERSON, entry.added_by, entry.robot_id)

    async def _move(
        self,
        mission: Mission,
        after: MissionStatus,
        why: str,
        mover: Mover = Mover.CONSOLE,
        by: str = BY,
        robot_id: str | None = None,
    ) -> None:
        try:
            moved, _ = await self._parts.database.run(
                lambda: self._parts.missions.move(mission.farm_id, mission.id, after, mover, by, why, robot_id=robot_id)
            )
        except (BadMove, NotFound) as error:
            log.info("mission %s was changed meanwhile: %s", mission.id, error)
            return
        told = {"kind": "mission-status", "robot": moved.robot_id, "mission_id": moved.id, "status": after.value}
        self._parts.on_event(told)

    async def _amend(self, entry: Entry, **fields: Any) -> None:
        await self._parts.database.run(lambda: self._parts.store.write(amended={entry.id: fields}))

    def _note(self, entry: Entry, outcome: str, text: str) -> None:
        data = {"mission": entry.mission_id}
        self._parts.audit.append(
            AuditEntry(entry.farm_id, BY, "", "queue", outcome, entry.robot_id, entry.id, text, data)
        )
        told = {"kind": "queue", "robot": entry.robot_id, "what": outcome, "entry": entry.id, "text": text}
        self._parts.on_event(told)

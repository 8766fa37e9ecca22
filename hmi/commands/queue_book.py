"""What people change of the queues: add, change, move up and down, take out, blackout windows. All of it audited."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.mission_book import MissionBook
from hmi.commands.ports import AuditSink
from hmi.commands.refusal import IS_DRAFT, UNKNOWN_MISSION, UNKNOWN_ROBOT, OrderRefused
from hmi.domain.ids import new_id
from hmi.domain.mission import EDITABLE, ENDED, ON_ROBOT, UNDER_WAY, BadMove, MissionStatus, Mover
from hmi.domain.mission_document import Document
from hmi.domain.queue.blackout import MAX_WINDOWS, Blackout
from hmi.domain.queue.entry import WINDOW_S, Conditions, Entry, EntryState
from hmi.domain.queue.repeat import Repeat
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.missions import Mission, Missions
from hmi.store.queue import QueueStore
from hmi.store.robots import Robots

MAX_ENTRIES = 60  # one robot; more is a plan, not a queue
STEP = 10
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class EntryOrder:
    """What a person asks for, all of it: what an entry shall be."""

    is_unattended: bool = False
    earliest: datetime | None = None
    window_s: int = WINDOW_S
    repeat: Repeat | None = None
    conditions: Conditions = field(default_factory=Conditions)


@dataclass(frozen=True, slots=True)
class QueueParts:
    """What the book is wired to.

    Args:
        on_changed: told of each robot whose queue a person changed, with who did it.
    """

    store: QueueStore
    missions: Missions
    book: MissionBook
    robots: Robots
    database: Database
    audit: AuditSink
    authorize: Authorize
    clock: Clock
    on_changed: Callable[[str, str], None]


class QueueBook:
    """Changes queues, one change at a time; each gives the queue a new revision, which disarms it.

    Raises (every method with a session): ``NotSignedIn``, ``NotAllowed``, ``StoreError``, and ``OrderRefused`` with
    the sentence why not.
    """

    def __init__(self, parts: QueueParts) -> None:
        self._parts = parts
        self._store = parts.store
        self._one_at_a_time = asyncio.Lock()

    async def add(self, session: SessionInfo, mission_id: str, robot_id: str | None, order: EntryOrder) -> Entry:
        """Put a mission at the end of a robot's queue; one that ran before goes in as a copy."""
        parts = self._parts
        parts.authorize(session, Permission.SEND_MISSION, robot_id)
        async with self._one_at_a_time:
            mission = self._mission(session, mission_id)
            robot_id = robot_id or mission.robot_id
            parts.authorize(session, Permission.SEND_MISSION, robot_id)
            if mission.status is MissionStatus.DRAFT:
                raise OrderRefused(IS_DRAFT, f"{mission.name} is a draft. Open it and plan it first.")
            robot = None if robot_id is None else parts.robots.get(robot_id)
            if robot_id is None or robot is None:
                raise OrderRefused(UNKNOWN_ROBOT, "Choose a robot for this mission.")
            mine = self._store.entries(robot_id)
            if len(mine) >= MAX_ENTRIES:
                raise OrderRefused("queue_full", f"The queue of {robot.name} is full: {MAX_ENTRIES} missions.")
            self._check(order, mission)
            if mission.status in EDITABLE:
                parts.book.refuse_other_robot(mission, robot_id)
            if mission.status in ENDED:
                mission = await parts.book.again(session.farm_id, mission.id, mission.name, session.user_name)
            document = await parts.book.document(session, mission.id)
            await self._into_queue(session, mission, robot_id)
            now = parts.clock.utc()
            entry = Entry(
                id=f"q-{new_id()[:12]}",
                farm_id=session.farm_id,
                robot_id=robot_id,
                mission_id=mission.id,
                position=max((one.position for one in mine), default=0) + STEP,
                added_by=session.user_name,
                added_at=now,
                place=_place(document),
                **_fields(order),
            )
            await self._parts.database.run(lambda: self._store.write(added=[entry], changed=[robot_id]))
            self._told(session, "added", robot_id, entry.id, f"{mission.name} is in the queue of {robot.name}.")
            return entry

    async def change(self, session: SessionInfo, entry_id: str, order: EntryOrder) -> Entry:
        """Replace when, how often and under which conditions an entry starts."""
        async with self._one_at_a_time:
            entry = self._entry(session, entry_id)
            mission = self._mission(session, entry.mission_id)
            self._refuse_if_under_way(mission)
            self._check(order, mission)
            [changed] = await self._amend({entry_id: _fields(order)}, entry.robot_id)
            self._told(session, "changed", entry.robot_id, entry_id, f"{mission.name} was changed in the queue.")
            return changed

    async def move(self, session: SessionInfo, entry_id: str, before_id: str | None) -> list[Entry]:
        """Put an entry before another one, or last; what is on the robot already stays first."""
        async with self._one_at_a_time:
            entry = self._entry(session, entry_id)
            mission = self._mission(session, entry.mission_id)
            if mission.status in ON_ROBOT:
                raise OrderRefused("on_robot", f"{mission.name} is on the robot already.")
            others = [one for one in self._store.entries(entry.robot_id) if one.id != entry_id]
            places = [one.id for one in others]
            if before_id is not None and before_id not in places:
                raise OrderRefused("not_found", "The other mission is not in this queue any more.")
            at = len(others) if before_id is None else places.index(before_id)
            at = max([at, *(k + 1 for k, one in enumerate(others) if self._is_on_robot(one))])
            ordered = [*others[:at], entry, *others[at:]]
            places_now = {one.id: {"position": STEP * (k + 1)} for k, one in enumerate(ordered)}
            placed = await self._amend(places_now, entry.robot_id)
            self._told(session, "moved", entry.robot_id, entry_id, f"{mission.name} was moved to place {at + 1}.")
            return placed

    async def remove(self, session: SessionInfo, entry_id: str) -> None:
        """Take an entry out; a mission that the robot holds stays there, one that runs cannot be taken out."""
        parts = self._parts
        async with self._one_at_a_time:
            entry = self._entry(session, entry_id)
            mission = parts.missions.known(entry.mission_id)
            name = entry.mission_id if mission is None else mission.name
            if mission is not None:
                self._refuse_if_under_way(mission)
            gone = {"state": EntryState.REMOVED, "ended_at": parts.clock.utc(), "why": "Taken out."}
            await self._amend({entry_id: gone}, entry.robot_id)
            # the entry first: the queue would put a mission that left its line back into it
            if mission is not None and mission.status in (MissionStatus.QUEUED, MissionStatus.WAITING):
                await self._move(session, mission, MissionStatus.VALIDATED, "Taken out of the queue.")
            self._told(session, "removed", entry.robot_id, entry_id, f"{name} was taken out of the queue.")

    async def put_blackout(self, session: SessionInfo, window: Blackout) -> Blackout:
        """Add a window in which nothing starts by itself, or replace one."""
        self._parts.authorize(session, Permission.SEND_MISSION)
        async with self._one_at_a_time:
            known = {one.id: one for one in self._store.blackouts()}
            if window.id not in known and len(known) >= MAX_WINDOWS:
                raise OrderRefused("too_many", f"There are {MAX_WINDOWS} windows already.")
            await self._parts.database.run(self._store.put_blackout, window)
            before = [known[window.id]] if window.id in known else []
            await self._windows_changed(session, [window, *before], "blackout", f"{window.name} was set.")
            return window

    async def remove_blackout(self, session: SessionInfo, window_id: str) -> None:
        """Delete a window; raises ``NotFound``."""
        self._parts.authorize(session, Permission.SEND_MISSION)
        async with self._one_at_a_time:
            window = await self._parts.database.run(self._store.remove_blackout, window_id)
            await self._windows_changed(session, [window], "blackout_removed", f"{window.name} was deleted.")

    async def robots_removed(self, robots: Collection[str]) -> None:
        """End what waits for robots that were taken out of the registry: nobody could take it out there any more."""
        parts, why = self._parts, "Its robot was taken out of the registry."
        async with self._one_at_a_time:
            for entry in [one for one in self._store.entries() if one.robot_id in robots]:
                gone = {"state": EntryState.REMOVED, "ended_at": parts.clock.utc(), "why": why}
                await self._amend({entry.id: gone}, entry.robot_id)
                mission = parts.missions.known(entry.mission_id)
                if mission is not None and mission.status in (MissionStatus.QUEUED, MissionStatus.WAITING):
                    await parts.database.run(self._free, mission, why)

    def _free(self, mission: Mission, why: str) -> None:
        try:
            self._parts.missions.move(
                mission.farm_id, mission.id, MissionStatus.VALIDATED, Mover.PERSON, "Headland", why
            )
        except BadMove:
            log.warning("mission %s left the queue of a robot that is gone and stays as it is", mission.id)

    def _check(self, order: EntryOrder, mission: Mission) -> None:
        if order.is_unattended and mission.is_supervised:
            text = f"{mission.name} is supervised: a person must be there. Mark it unattended first."
            raise OrderRefused("mission_supervised", text)
        if order.repeat is not None and order.earliest is None:
            raise OrderRefused("no_time", "A job that repeats needs a time.")
        if order.earliest is not None and (self._parts.clock.utc() - order.earliest).total_seconds() > order.window_s:
            raise OrderRefused("too_late", "This time is over. Choose a later one.")

    async def _into_queue(self, session: SessionInfo, mission: Mission, robot_id: str) -> None:
        if mission.status is not MissionStatus.VALIDATED:
            state = _STATE.get(mission.status, "on a robot already")
            raise OrderRefused("not_ready", f"{mission.name} is {state}. Copy it to run it again.")
        await self._move(session, mission, MissionStatus.QUEUED, "Put into the queue.", robot_id)

    async def _move(
        self, session: SessionInfo, mission: Mission, after: MissionStatus, why: str, robot_id: str | None = None
    ) -> None:
        parts, by = self._parts, session.user_name
        # it is addressed to another robot: what it was planned for stays known
        machine = None if robot_id is None else parts.book.machine_of(mission)

        def move() -> None:
            parts.missions.move(
                session.farm_id, mission.id, after, Mover.PERSON, by, why, robot_id=robot_id, machine=machine
            )

        try:
            await parts.database.run(move)
        except BadMove as error:
            raise OrderRefused("changed_meanwhile", f"{mission.name} changed meanwhile. Look again.") from error

    async def _amend(self, amended: Mapping[str, Mapping[str, Any]], robot_id: str) -> list[Entry]:
        return await self._parts.database.run(lambda: self._store.write(amended=amended, changed=[robot_id]))

    def _told(self, session: SessionInfo, outcome: str, robot_id: str, ref: str, text: str) -> None:
        self._write(session, outcome, robot_id, ref, text, {"revision": self._store.revision(robot_id)})
        self._parts.on_changed(robot_id, session.user_name)

    async def _windows_changed(
        self, session: SessionInfo, windows: Sequence[Blackout], outcome: str, text: str
    ) -> None:  # fmt: skip
        everybody = [robot.id for robot in self._parts.robots.all()]
        concerned = sorted({robot for one in windows for robot in (one.robots or everybody)})
        await self._parts.database.run(lambda: self._store.write(changed=concerned))
        self._write(session, outcome, None, windows[0].id, text, {"robots": concerned})
        for robot_id in concerned:
            self._parts.on_changed(robot_id, session.user_name)

    def _entry(self, session: SessionInfo, entry_id: str) -> Entry:
        self._parts.authorize(session, Permission.SEND_MISSION)
        entry = self._store.get(entry_id)
        self._parts.authorize(session, Permission.SEND_MISSION, entry.robot_id)
        return entry

    def _mission(self, session: SessionInfo, mission_id: str) -> Mission:
        mission = self._parts.missions.known(mission_id)
        if mission is None or mission.farm_id != session.farm_id:
            raise OrderRefused(UNKNOWN_MISSION, "There is no such mission.")
        return mission

    def _is_on_robot(self, entry: Entry) -> bool:
        mission = self._parts.missions.known(entry.mission_id)
        return mission is not None and mission.status in ON_ROBOT

    def _refuse_if_under_way(self, mission: Mission) -> None:
        if mission.status in UNDER_WAY:
            raise OrderRefused("under_way", f"{mission.name} is {mission.status.value}. Pause or abort it on Operate.")

    def _write(
        self, session: SessionInfo, outcome: str, robot_id: str | None, ref: str, text: str, data: dict[str, Any]
    ) -> None:
        self._parts.audit.append(audit_line(session, "queue", outcome, text, ref=ref, robot_id=robot_id, data=data))


_STATE = {
    MissionStatus.DRAFT: "a draft",
    MissionStatus.QUEUED: "in a queue already",
    MissionStatus.WAITING: "in a queue already",
}


def _fields(order: EntryOrder) -> dict[str, Any]:
    return {
        "is_unattended": order.is_unattended,
        "earliest": order.earliest,
        "window_s": order.window_s,
        "repeat": order.repeat,
        "conditions": order.conditions,
    }


def _place(document: Document) -> tuple[float, float] | None:
    """Return longitude and latitude of the field's first corner: daylight is the same all over a field."""
    try:
        lon, lat = document["parcel"][0][0][:2]
        return float(lon), float(lat)
    except (KeyError, IndexError, TypeError, ValueError):
        return None

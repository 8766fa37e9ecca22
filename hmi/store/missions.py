"""Stored missions: their documents, where each is in its life, and the log of how it came there."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Any

from sqlalchemy import delete, select
from sqlalchemy.orm import Session, defer

from hmi.clock import Clock
from hmi.domain.mission import EDITABLE, ENDED, BadMove, MissionChange, MissionStatus, Mover, check_move
from hmi.domain.mission_document import Document, for_robot, mission_sha256, renamed
from hmi.domain.mission_plan import MissionRefused
from hmi.domain.mission_rest import Progress
from hmi.domain.planned_machine import MACHINE
from hmi.store.database import Database
from hmi.store.errors import AlreadyExists, NotFound
from hmi.store.mission_tables import MissionRevisionRow
from hmi.store.tables import MissionLogRow, MissionRow

DELETABLE = frozenset({MissionStatus.DRAFT, MissionStatus.VALIDATED})
"""What ran, or waits to run, keeps its record."""
_NEVER_RAN = DELETABLE | {MissionStatus.QUEUED, MissionStatus.WAITING}
PROGRESS_EVERY_S = 15.0
"""A console that is killed has forgotten no more of a running mission than this."""


@dataclass(frozen=True, slots=True)
class Mission:
    """A stored mission without its document. ``statistics`` are the planner's figures, SI.

    Args:
        map_version: number of the published map the whole of it was planned on, 0 for a farm that had none, ``None``
            for one that is older than map versions; see ``planned_on``.
        progress: how far a robot came on this document, see ``hmi.domain.mission_rest.Progress``.
        pending_sha256: of a document that was sent and not read back yet; empty if there is none.
        wish: of a draft, what was chosen so far, as a planning request carries it; a draft has no document and no hash.
    """

    id: str
    farm_id: str
    name: str
    field_name: str
    status: MissionStatus
    sha256: str
    created_by: str
    created_at: datetime
    updated_at: datetime
    robot_id: str | None = None
    field_id: str | None = None
    revision: int = 1
    is_supervised: bool = True
    statistics: dict[str, Any] = field(default_factory=dict)
    map_version: int | None = None
    progress: dict[str, Any] | None = None
    pending_sha256: str = ""
    wish: dict[str, Any] | None = None

    @property
    def is_resumable(self) -> bool:
        """Whether it was interrupted and how far it came is known, which counts on the document it has alone."""
        came = Progress.from_json(self.progress)
        is_known = came is not None and came.is_begun and came.sha256 == self.sha256
        return is_known and self.status in (MissionStatus.ABORTED, MissionStatus.FAILED)

    def planned_on(self, document: Document) -> int | None:
        """Return the number of the map that a document of this mission was planned on: a rest has its own."""
        stamp = document.get("map_version")
        return stamp["number"] if stamp else self.map_version


@dataclass(frozen=True, slots=True)
class MissionLogEntry:
    """One line of a mission's log."""

    at: datetime
    status: MissionStatus
    by: str
    why: str
    data: dict[str, Any]


class Missions:
    """The missions of every farm, in memory without documents, on disk whole.

    ``known`` and ``all_known`` answer from memory and may be called on the event loop; everything else blocks and goes
    through ``Database.run``. ``on_changed`` callbacks run in the thread that made the change.
    """

    def __init__(self, database: Database, clock: Clock) -> None:
        self._database = database
        self._clock = clock
        self._known: dict[str, Mission] = {}
        self._version = 0
        self._kept_s: dict[str, float] = {}
        self._changing = threading.Lock()
        self._listeners: list[Callable[[Mission], None]] = []
        self._deletion_listeners: list[Callable[[Mission], None]] = []

    @property
    def version(self) -> int:
        """Grows with every change of what is in memory."""
        return self._version

    def known(self, mission_id: str) -> Mission | None:
        """Return a mission of any farm from memory."""
        return self._known.get(mission_id)

    def all_known(self, farm_id: str) -> list[Mission]:
        """Return a farm's missions from memory, the one that changed last first."""
        return sorted(
            (one for one in self._known.values() if one.farm_id == farm_id),
            key=lambda one: (one.updated_at, one.id),
            reverse=True,
        )

    def on_changed(self, callback: Callable[[Mission], None]) -> None:
        """Call ``callback`` with each mission that was added or changed."""
        self._listeners.append(callback)

    def on_deleted(self, callback: Callable[[Mission], None]) -> None:
        """Call ``callback`` with each mission that was deleted, as it was."""
        self._deletion_listeners.append(callback)

    def load(self) -> None:
        """Read all missions into memory; at start."""
        with self._changing, self._database.read() as session:
            rows = session.scalars(select(MissionRow).options(defer(MissionRow.document)))
            self._known = {row.id: _mission(row) for row in rows}
            self._version += 1

    def document(self, farm_id: str, mission_id: str) -> Document:
        """Return the wire document of a mission; raises ``NotFound``."""
        with self._database.read() as session:
            return dict(_row(session, farm_id, mission_id).document)

    def log(self, farm_id: str, mission_id: str) -> list[MissionLogEntry]:
        """Return a mission's log, oldest first."""
        query = select(MissionLogRow).filter_by(farm_id=farm_id, mission_id=mission_id).order_by(MissionLogRow.id)
        with self._database.read() as session:
            return [
                MissionLogEntry(row.at, MissionStatus(row.status), row.by, row.why, dict(row.data or {}))
                for row in session.scalars(query)
            ]

    def add(self, mission: Mission, document: Document, why: str = "", *, at: datetime | None = None) -> Mission:
        """Store a new mission with its document; times (``at`` or now) and hash are set here.

        Raises:
            AlreadyExists: the id is taken.
        """
        now = at or self._clock.utc()
        sha256 = mission_sha256(document) if document else ""
        stored = replace(mission, sha256=sha256, created_at=now, updated_at=now)
        with self._changing, self._database.write() as session:
            if session.get(MissionRow, stored.id) is not None:
                raise AlreadyExists(f"a mission {stored.id!r} exists already")
            row = MissionRow(id=stored.id, document=document, **_columns(stored))
            session.add(row)
            session.flush()
            session.add(self._log(stored, stored.created_by, why, {}))
        return self._remember(stored)

    def keep_progress(self, mission_id: str, progress: dict[str, Any], *, is_urgent: bool = False) -> None:
        """Store how far a robot came, if the last time was a while ago or ``is_urgent``; no log, no event."""
        now_s = self._clock.mono_s()
        known = self._known.get(mission_id)
        if known is None or known.progress == progress:
            return
        if not is_urgent and now_s - self._kept_s.get(mission_id, -PROGRESS_EVERY_S) < PROGRESS_EVERY_S:
            return
        self._kept_s[mission_id] = now_s
        with self._changing, self._database.write() as session:
            row = session.get(MissionRow, mission_id)
            if row is None or row.sha256 != progress["sha256"]:
                return
            row.progress = progress
            # seen by those who ask; not a change that anybody has to be told of
            self._known[mission_id] = replace(self._known[mission_id], progress=progress)

    def change(
        self,
        farm_id: str,
        mission_id: str,
        work: Callable[[Session, Mission, Document], tuple[Mission, Document]],
        by: str,
        why: str,
        data: dict[str, Any] | None = None,
    ) -> Mission:
        """Let ``work`` change a mission and what lies beside it in one transaction, with a line in its log.

        Raises:
            NotFound: there is no such mission; and what ``work`` raises.
        """
        return self._change(farm_id, mission_id, work, by, why, data or {})

    def rename(self, farm_id: str, mission_id: str, name: str, by: str) -> Mission:
        """Give a mission another name; its hash changes with it, unless it ran: then only people read the new one.

        Raises:
            NotFound: there is no such mission.
            MissionRefused: a robot holds it or a queue waits for it.
        """

        def change(_session: Session, mission: Mission, document: Document) -> tuple[Mission, Document]:
            if mission.status not in EDITABLE:
                raise MissionRefused("in_use", f"{mission.name} is {mission.status.value}. Copy it instead.")
            if not document:  # whoever has the draft open is told when they save it
                return replace(mission, name=name, revision=mission.revision + 1), document
            # what a robot drove stays as it was, bit by bit: to go on, it asks for that
            return replace(mission, name=name), document if mission.status in ENDED else renamed(document, name=name)

        return self._change(farm_id, mission_id, change, by, "Renamed.", {"name": name})

    def adjust(
        self,
        farm_id: str,
        mission_id: str,
        by: str,
        *,
        is_supervised: bool | None = None,
        robot_id: str | None = None,
        machine: Mapping[str, Any] | None = None,
    ) -> Mission:
        """Mark a mission attended or not, or give it to another robot; its hash changes with the robot.

        Args:
            machine: it was planned for, kept when it goes to another robot and its figures do not tell.

        Raises:
            NotFound: there is no such mission.
            MissionRefused: a robot holds it, a queue waits for it, or another robot could not resume it.
        """

        def change(_session: Session, mission: Mission, document: Document) -> tuple[Mission, Document]:
            if mission.status not in EDITABLE:
                raise MissionRefused("in_use", f"{mission.name} is {mission.status.value}. Copy it instead.")
            if not document:
                return _wished(mission, is_supervised, robot_id), document
            if robot_id is not None and robot_id != document["robot"]:
                if mission.is_resumable:
                    text = f"{mission.name} was interrupted on {document['robot']}, where it can be resumed later."
                    raise MissionRefused("has_progress", f"{text} Copy it for another robot.")
                document, mission = for_robot(document, robot_id), _planned_for(mission, machine)
            attended = mission.is_supervised if is_supervised is None else is_supervised
            return replace(mission, is_supervised=attended, robot_id=robot_id or mission.robot_id), document

        words = [] if is_supervised is None else ["A person must be there." if is_supervised else "May run unattended."]
        words += [] if robot_id is None else [f"For {robot_id} now."]
        return self._change(farm_id, mission_id, change, by, " ".join(words), {})

    def move(
        self,
        farm_id: str,
        mission_id: str,
        after: MissionStatus,
        mover: Mover,
        by: str,
        why: str = "",
        *,
        robot_id: str | None = None,
        at: datetime | None = None,
        data: dict[str, Any] | None = None,
        machine: Mapping[str, Any] | None = None,
    ) -> tuple[Mission, MissionChange]:
        """Move a mission on in its life.

        Args:
            robot_id: the robot it goes to, if it changes: the document is addressed to it.
            machine: as of ``adjust``.
            at: when it happened, if not now.

        Raises:
            NotFound: there is no such mission.
            BadMove: the table has no such move.
        """
        before = MissionStatus.DRAFT

        def change(_session: Session, mission: Mission, document: Document) -> tuple[Mission, Document]:
            nonlocal before
            before = mission.status
            check_move(before, after, mover)
            if robot_id is not None and robot_id != document["robot"]:
                document, mission = for_robot(document, robot_id), _planned_for(mission, machine)
            return replace(mission, status=after, robot_id=robot_id or mission.robot_id), document

        moved = self._change(farm_id, mission_id, change, by, why, data or {}, at)
        return moved, MissionChange(mission_id, before, after, mover, by, at or moved.updated_at, why)

    def note(self, farm_id: str, mission_id: str, by: str, why: str) -> None:
        """Write a line into a mission's log that moves nothing.

        Raises:
            NotFound: there is no such mission.
        """
        with self._changing, self._database.write() as session:
            mission = replace(_mission(_row(session, farm_id, mission_id)), updated_at=self._clock.utc())
            session.add(self._log(mission, by, why, {}))

    def delete(self, farm_id: str, mission_id: str) -> None:
        """Delete a mission that never ran.

        Raises:
            NotFound: there is no such mission.
            MissionRefused: it ran or waits to run.
        """
        with self._changing, self._database.write() as session:
            row = _row(session, farm_id, mission_id)
            ran = select(MissionLogRow.id).filter_by(mission_id=mission_id)
            ran = ran.where(MissionLogRow.status.not_in([s.value for s in _NEVER_RAN])).limit(1)
            if MissionStatus(row.status) in _NEVER_RAN - DELETABLE:
                raise MissionRefused("in_queue", f"{row.name} is in a queue. Take it out there first.")
            if MissionStatus(row.status) not in DELETABLE or session.scalar(ran) is not None:
                raise MissionRefused("has_record", f"{row.name} was sent to a robot; its record is kept.")
            session.execute(delete(MissionLogRow).filter_by(mission_id=mission_id))
            session.execute(delete(MissionRevisionRow).filter_by(mission_id=mission_id))
            deleted = _mission(row)
            session.delete(row)
            self._known = {key: one for key, one in self._known.items() if key != mission_id}
            self._version += 1
        for listener in tuple(self._deletion_listeners):
            listener(deleted)

    def _change(
        self,
        farm_id: str,
        mission_id: str,
        change: Callable[[Session, Mission, Document], tuple[Mission, Document]],
        by: str,
        why: str,
        data: dict[str, Any],
        at: datetime | None = None,
    ) -> Mission:
        with self._changing, self._database.write() as session:
            row = _row(session, farm_id, mission_id)
            mission, document = change(session, _mission(row), row.document)
            mission = replace(mission, updated_at=at or self._clock.utc())
            if document is not row.document:
                row.document = document
                mission = replace(mission, sha256=mission_sha256(document))
            for name, value in _columns(mission).items():
                setattr(row, name, value)
            session.add(self._log(mission, by, why, data))
        return self._remember(mission)

    def _remember(self, mission: Mission) -> Mission:
        self._known = {**self._known, mission.id: mission}
        self._version += 1
        for listener in tuple(self._listeners):
            listener(mission)
        return mission

    @staticmethod
    def _log(mission: Mission, by: str, why: str, data: dict[str, Any]) -> MissionLogRow:
        return MissionLogRow(
            farm_id=mission.farm_id,
            mission_id=mission.id,
            at=mission.updated_at,
            status=mission.status.value,
            by=by,
            why=why,
            data=data,
        )


def _wished(mission: Mission, is_supervised: bool | None, robot_id: str | None) -> Mission:
    """Return a draft that is wished for another robot, or with or without somebody there."""
    attended = mission.is_supervised if is_supervised is None else is_supervised
    robot = robot_id or mission.robot_id
    wish = {**(mission.wish or {}), "is_supervised": attended, **({"robot_id": robot} if robot else {})}
    # whoever has it open sees that it was changed when they save it
    revision = mission.revision + 1
    return replace(mission, is_supervised=attended, robot_id=robot, wish=wish, revision=revision)


def _planned_for(mission: Mission, machine: Mapping[str, Any] | None) -> Mission:
    if machine is None or MACHINE in mission.statistics:
        return mission
    return replace(mission, statistics={**mission.statistics, MACHINE: dict(machine)})


def _row(session: Session, farm_id: str, mission_id: str) -> MissionRow:
    row = session.get(MissionRow, mission_id)
    if row is None or row.farm_id != farm_id:
        raise NotFound(f"there is no mission {mission_id!r}")
    return row


_SAME = (
    "farm_id", "name", "field_name", "field_id", "robot_id", "revision", "is_supervised", "sha256", "statistics",
    "map_version", "progress", "pending_sha256", "wish", "created_by", "created_at", "updated_at",
)  # fmt: skip


def _columns(mission: Mission) -> dict[str, Any]:
    return {"status": mission.status.value, **{name: getattr(mission, name) for name in _SAME}}


def _mission(row: MissionRow) -> Mission:
    return Mission(id=row.id, status=MissionStatus(row.status), **{name: getattr(row, name) for name in _SAME})


__all__ = ["DELETABLE", "BadMove", "Mission", "MissionLogEntry", "Missions"]

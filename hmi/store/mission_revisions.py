"""The documents of a mission over its life: what a robot has read back, and what it was only sent.

Blocking; call through ``Database.run``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from sqlalchemy import func, select, update
from sqlalchemy.orm import Session

from hmi.clock import Clock
from hmi.domain.mission_document import Document, canonical, mission_sha256, renamed
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.mission_tables import MissionRevisionRow
from hmi.store.missions import Mission, Missions

WHOLE, PENDING, TAKEN, DROPPED = "whole", "pending", "taken", "dropped"


class _Taken(Exception):
    """Answer and report of the robot came together; the other one was first."""

    def __init__(self, mission: Mission) -> None:
        super().__init__(mission.id)
        self.mission = mission


class MissionRevisions:
    """Proposes documents, and makes them the mission's own when a robot has read them back."""

    def __init__(self, missions: Missions, database: Database, clock: Clock) -> None:
        self._missions, self._database, self._clock = missions, database, clock

    def propose(
        self, farm_id: str, mission_id: str, document: Document, statistics: dict[str, Any], by: str, why: str
    ) -> Mission:
        """Store a document that is about to be sent; the mission keeps the one it has.

        Raises:
            NotFound: there is no such mission.
        """
        sha256 = mission_sha256(document)

        def work(session: Session, mission: Mission, current: Document) -> tuple[Mission, Document]:
            _keep_whole(session, mission, current, self._clock)
            _end_pending(session, mission_id)
            row = _row(mission, document, sha256, statistics, PENDING, by, why, self._clock)
            session.merge(row)
            return replace(mission, pending_sha256=sha256), current

        return self._missions.change(farm_id, mission_id, work, by, f"Sending: {why}", {"sha256": sha256})

    def take(self, farm_id: str, mission_id: str, sha256: str, by: str, why: str) -> Mission:
        """Make the pending document the mission's own: a robot has read it back. Again changes nothing.

        Raises:
            NotFound: no such document was proposed.
        """
        known = self._missions.known(mission_id)
        if known is not None and known.sha256 == sha256:
            return known

        def work(session: Session, mission: Mission, _current: Document) -> tuple[Mission, Document]:
            if mission.sha256 == sha256:
                raise _Taken(mission)
            row = session.scalar(
                select(MissionRevisionRow)
                .filter_by(farm_id=farm_id, mission_id=mission_id, sha256=sha256)
                .order_by(MissionRevisionRow.revision.desc())
                .limit(1)
            )
            if row is None:
                raise NotFound("no such document was sent")
            row.state = TAKEN
            is_whole = "continues" not in row.document
            return (
                replace(
                    mission,
                    revision=row.revision,
                    statistics=dict(row.statistics),
                    pending_sha256="",
                    # the rows a rest leaves out come back with the next copy: nobody planned them on its map
                    map_version=mission.planned_on(row.document) if is_whole else mission.map_version,
                    robot_id=row.document["robot"],
                    progress=None if is_whole else _kept(mission, row.document, sha256),
                ),
                dict(row.document),
            )

        try:
            return self._missions.change(farm_id, mission_id, work, by, why, {"sha256": sha256})
        except _Taken as taken:
            return taken.mission

    def drop(self, farm_id: str, mission_id: str, by: str, why: str) -> Mission:
        """Forget the pending document: the robot refused it, or said that it has the old one."""

        def work(session: Session, mission: Mission, current: Document) -> tuple[Mission, Document]:
            _end_pending(session, mission_id)
            return replace(mission, pending_sha256=""), current

        return self._missions.change(farm_id, mission_id, work, by, why)

    def whole(self, farm_id: str, mission_id: str) -> tuple[Document, dict[str, Any]]:
        """Return the newest whole document, from its first point, with its figures, newly named and numbered."""
        with self._database.read() as session:
            row = session.scalar(
                select(MissionRevisionRow)
                .filter_by(farm_id=farm_id, mission_id=mission_id, state=WHOLE)
                .order_by(MissionRevisionRow.revision.desc())
                .limit(1)
            )
        known = self._missions.known(mission_id)
        if known is None:
            raise NotFound(f"there is no mission {mission_id!r}")
        if row is not None:
            document, statistics = dict(row.document), dict(row.statistics)
        else:
            document, statistics = self._missions.document(farm_id, mission_id), known.statistics
        document = renamed(document, name=known.name)
        return canonical({**document, "revision": self.next_revision(mission_id)}), statistics

    def document(self, farm_id: str, mission_id: str, sha256: str) -> Document | None:
        """Return a document that was proposed, by its hash."""
        with self._database.read() as session:
            query = select(MissionRevisionRow).filter_by(farm_id=farm_id, mission_id=mission_id, sha256=sha256)
            row = session.scalar(query.limit(1))
            return None if row is None else dict(row.document)

    def next_revision(self, mission_id: str) -> int:
        """Return a revision no document of this mission has had."""
        known = self._missions.known(mission_id)
        with self._database.read() as session:
            most = session.scalar(select(func.max(MissionRevisionRow.revision)).filter_by(mission_id=mission_id))
        return max(most or 0, known.revision if known else 0) + 1


def _kept(mission: Mission, document: Document, sha256: str) -> dict[str, Any] | None:
    """Return the progress on the new document: what was done stays, the robot's next report has the place."""
    if mission.progress is None:
        return None
    kept = document["continues"]["segments"]
    return {**mission.progress, "sha256": sha256, "segment": kept, "segment_s_m": 0.0}


def _keep_whole(session: Session, mission: Mission, current: Document, clock: Clock) -> None:
    """Keep a document that has its whole path: starting fresh begins with it."""
    if "continues" in current:
        return
    row = _row(mission, current, mission.sha256, mission.statistics, WHOLE, mission.created_by, "", clock)
    row.revision = mission.revision
    session.merge(row)


def _end_pending(session: Session, mission_id: str) -> None:
    waiting = update(MissionRevisionRow).filter_by(mission_id=mission_id, state=PENDING)
    session.execute(waiting.values(state=DROPPED))


def _row(
    mission: Mission,
    document: Document,
    sha256: str,
    statistics: dict[str, Any],
    state: str,
    by: str,
    why: str,
    clock: Clock,
) -> MissionRevisionRow:
    return MissionRevisionRow(
        mission_id=mission.id,
        revision=document["revision"],
        farm_id=mission.farm_id,
        sha256=sha256,
        state=state,
        by=by,
        why=why,
        at=clock.utc(),
        document=document,
        statistics=statistics,
    )

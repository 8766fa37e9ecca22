"""Changes of state as they were recorded, for one robot and a span of time or a mission."""

from __future__ import annotations

import itertools
from datetime import datetime, timedelta
from typing import Any, NamedTuple

from sqlalchemy import Select, func, select

from hmi.domain.event import RobotEvent
from hmi.domain.mission import ENDED, UNDER_WAY
from hmi.domain.state_times import ENTERED, LEFT, Silence
from hmi.store.database import Database
from hmi.store.tables import EventRow, MissionLogRow, SampleRow

MOST_EVENTS = 60_000  # a day of a planter
AROUND = timedelta(hours=2)  # a stay may have begun before the span, and be told when it ends after it
MOST_AROUND = 400
SILENCE_S = 180.0  # without a sample: old ones are kept once a minute


class Span(NamedTuple):
    """When a robot began with a mission, and when it ended it or last told of it."""

    start: datetime
    end: datetime


class StateRecords:
    """Recorded changes of state of one farm. Blocking; call through ``Database.run``."""

    def __init__(self, database: Database, farm_id: str) -> None:
        self._database, self._farm_id = database, farm_id

    def events(self, robot_id: str, start: datetime, end: datetime) -> list[RobotEvent]:
        """Return changes in a span, oldest first, and those around it that tell of stays at its edges."""
        inside = self._of(robot_id).where(EventRow.at >= start, EventRow.at <= end)
        # what lasted when the span began was entered before; newest first, so that no entry comes without its end
        before = self._of(robot_id).where(EventRow.at < start, EventRow.at >= start - AROUND)
        later = self._of(robot_id).where(EventRow.at > end, EventRow.at <= end + AROUND, EventRow.kind == LEFT)
        with self._database.read() as session:
            rows = list(session.scalars(inside.order_by(EventRow.at.desc()).limit(MOST_EVENTS)))
            rows += session.scalars(before.order_by(EventRow.at.desc()).limit(MOST_AROUND))
            rows += session.scalars(later.order_by(EventRow.at).limit(MOST_AROUND))
        return sorted((_event(row) for row in rows), key=lambda one: one.at_utc)

    def newest(self, robot_id: str, most: int) -> list[RobotEvent]:
        """Return the newest changes, oldest first."""
        query = self._of(robot_id).order_by(EventRow.at.desc()).limit(most)
        with self._database.read() as session:
            return sorted((_event(row) for row in session.scalars(query)), key=lambda one: one.at_utc)

    def mission_span(self, robot_id: str, mission_id: str) -> Span | None:
        """Return when a robot worked on a mission, ``None`` if it told no change of state in it.

        What it told while the mission only lay on it, before its start and after its end, is not of the mission.
        """
        query = (
            select(func.min(EventRow.at), func.max(EventRow.at))
            .filter_by(farm_id=self._farm_id, robot_id=robot_id, mission_id=mission_id)
            .where(EventRow.kind.in_((ENTERED, LEFT)))
        )
        logged = select(func.min(MissionLogRow.at), func.max(MissionLogRow.at)).filter_by(
            farm_id=self._farm_id, mission_id=mission_id
        )
        with self._database.read() as session:
            first, last = session.execute(query).one()
            begun, begun_again = session.execute(logged.where(MissionLogRow.status.in_(UNDER_WAY))).one()
            _, ended = session.execute(logged.where(MissionLogRow.status.in_(ENDED))).one()
        if first is None or last is None:
            return None
        if begun is not None:
            first = max(first, begun)
            if ended is not None and ended >= begun_again:
                last = min(last, ended)
        return Span(first, max(first, last))

    def silences(self, robot_id: str, start: datetime, end: datetime) -> list[Silence]:
        """Return when nothing was heard of a robot for minutes, in a span, oldest first."""
        heard = select(SampleRow.at).filter_by(farm_id=self._farm_id, robot_id=robot_id)
        heard = heard.where(SampleRow.at >= start - AROUND, SampleRow.at <= end).order_by(SampleRow.at)
        with self._database.read() as session:
            times = session.scalars(heard).all()
        return [Silence(a, b) for a, b in itertools.pairwise(times) if (b - a).total_seconds() > SILENCE_S]

    def _of(self, robot_id: str) -> Select[Any]:
        return (
            select(EventRow)
            .filter_by(farm_id=self._farm_id, robot_id=robot_id)
            .where(EventRow.kind.in_((ENTERED, LEFT)))
        )


def _event(row: EventRow) -> RobotEvent:
    return RobotEvent(
        row.robot_id, row.id, row.kind, row.name, row.text, dict(row.data), at_utc=row.at, mission_id=row.mission_id
    )

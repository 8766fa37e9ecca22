"""Changes of state as they were recorded, for one robot and a span of time or a mission."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any, NamedTuple

from sqlalchemy import Select, func, select

from hmi.domain.event import RobotEvent
from hmi.domain.state_times import ENTERED, LEFT
from hmi.store.database import Database
from hmi.store.tables import EventRow

MOST_EVENTS = 60_000  # a day of a planter
AROUND = timedelta(hours=2)  # a stay may have begun before the span, and be told when it ends after it
MOST_AROUND = 400


class Span(NamedTuple):
    """When a mission's first and last change of state were."""

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
        events = [
            RobotEvent(r.robot_id, r.id, r.kind, r.name, r.text, dict(r.data), at_utc=r.at, mission_id=r.mission_id)
            for r in rows
        ]
        return sorted(events, key=lambda one: one.at_utc)

    def mission_span(self, robot_id: str, mission_id: str) -> Span | None:
        """Return when a robot worked on a mission, ``None`` if it told no change of state in it."""
        query = (
            select(func.min(EventRow.at), func.max(EventRow.at))
            .filter_by(farm_id=self._farm_id, robot_id=robot_id, mission_id=mission_id)
            .where(EventRow.kind.in_((ENTERED, LEFT)))
        )
        with self._database.read() as session:
            first, last = session.execute(query).one()
        return None if first is None or last is None else Span(first, last)

    def _of(self, robot_id: str) -> Select[Any]:
        return (
            select(EventRow)
            .filter_by(farm_id=self._farm_id, robot_id=robot_id)
            .where(EventRow.kind.in_((ENTERED, LEFT)))
        )

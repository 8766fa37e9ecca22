"""Who is responsible for which robot, and the shift book. Answers from memory; writes through ``Database.run``."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from datetime import datetime

from sqlalchemy import select

from hmi.clock import Clock
from hmi.store.database import Database
from hmi.store.fleet_tables import DutyRow, HandOverRow

BOOK_LIMIT = 50


@dataclass(frozen=True, slots=True)
class Duty:
    """Who is responsible for a robot since when; ``offered_*`` while a hand-over waits to be taken.

    Nobody's with a ``since`` was somebody's until then.
    """

    robot_id: str
    user_id: str = ""
    user_name: str = ""
    since: datetime | None = None
    note: str = ""
    offered_to: str = ""
    offered_name: str = ""
    offered_by: str = ""
    offered_by_id: str = ""
    offered_at: datetime | None = None
    offered_note: str = ""


@dataclass(frozen=True, slots=True)
class HandOver:
    """One line of the shift book; ``what`` is taken, released, offered, accepted, declined or withdrawn."""

    at: datetime
    what: str
    by: str
    to_name: str
    robots: tuple[str, ...]
    note: str


class Duties:
    """The duties of one farm."""

    def __init__(self, database: Database, farm_id: str, clock: Clock) -> None:
        self._database, self._farm_id, self._clock = database, farm_id, clock
        self._duties: dict[str, Duty] = {}
        self._changing = threading.Lock()

    def load(self) -> None:
        """Read them into memory; at start."""
        with self._changing, self._database.read() as session:
            rows = session.scalars(select(DutyRow).filter_by(farm_id=self._farm_id))
            self._duties = {row.robot_id: _duty(row) for row in rows}

    def of(self, robot_id: str) -> Duty:
        """Return a robot's duty; nobody's if none was set."""
        return self._duties.get(robot_id) or Duty(robot_id)

    def all(self) -> list[Duty]:
        """Return every duty that somebody has or is offered."""
        return [one for one in self._duties.values() if one.user_id or one.offered_to]

    def freed(self) -> list[Duty]:
        """Return robots that somebody was responsible for, and now nobody is."""
        return [one for one in self._duties.values() if not one.user_id and one.since]

    def write(self, duties: Iterable[Duty], line: HandOver) -> None:
        """Replace duties and write the line of the shift book in one transaction."""
        kept = list(duties)
        with self._changing:
            with self._database.write() as session:
                for one in kept:
                    session.merge(DutyRow(farm_id=self._farm_id, **asdict(one)))
                session.add(HandOverRow(farm_id=self._farm_id, **{**asdict(line), "robots": list(line.robots)}))
            self._duties = {**self._duties, **{one.robot_id: one for one in kept}}

    def book(self, limit: int = BOOK_LIMIT) -> list[HandOver]:
        """Return the newest lines of the shift book, newest first; blocks."""
        query = select(HandOverRow).filter_by(farm_id=self._farm_id).order_by(HandOverRow.id.desc()).limit(limit)
        with self._database.read() as session:
            return [
                HandOver(row.at, row.what, row.by, row.to_name, tuple(row.robots), row.note)
                for row in session.scalars(query)
            ]


def _duty(row: DutyRow) -> Duty:
    return Duty(**{name: getattr(row, name) for name in Duty.__slots__})

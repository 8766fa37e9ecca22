"""Old history gets coarser: 10 s a row after a day, 60 s after a month. Done by the database, an hour at a time.

Of every stretch the newest row stays (where it was, its state); speed is averaged; cross-track error, GNSS accuracy
and delay keep their worst value, because that is what old records are asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

from sqlalchemy import ColumnElement, Connection, Select, case, delete, func, insert, literal, select
from sqlalchemy.orm import InstrumentedAttribute

from hmi.store.database import Database
from hmi.store.history import stretch_of
from hmi.store.tables import SampleRow

# Held under the write lock: 1,000 robots make 600,000 rows in ten minutes, which SQLite thins in about a second.
STEP = timedelta(minutes=10)


@dataclass(frozen=True, slots=True)
class Grade:
    """Rows of ``from_s`` seconds become rows of ``to_s`` once older than ``after``.

    ``digits`` of the time's text are equal within one coarse row: ``2026-05-04T12:34:5`` names ten seconds.
    """

    from_s: int
    to_s: int
    after: timedelta
    digits: int


GRADES = (Grade(1, 10, timedelta(days=1), 18), Grade(10, 60, timedelta(days=30), 16))
_KEPT = ("farm_id", "robot_id", "mission_id", "at", "lat_deg", "lon_deg", "theta_rad", "soc", "tool", "mode", "row",
         "area_done_m2", "joints")  # fmt: skip
_WORST = ("cross_track_m", "gnss_accuracy_m", "rtt_s")


class Thinning:
    """Thins the samples of all farms. Blocking; call ``step`` through ``Database.run`` until it returns False."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def step(self, now: datetime) -> bool:
        """Thin at most ten minutes of history in one transaction; return whether more is waiting."""
        for grade in GRADES:
            start = self._oldest(grade, now)
            if start is not None:
                with self._database.connect_writing() as connection:
                    _thin(connection, grade, start, start + STEP)
                return True
        return False

    def run(self, now: datetime) -> int:
        """Thin all that is due, or until the database is closed; return the number of steps."""
        return sum(1 for _ in self._steps(now))

    def _steps(self, now: datetime) -> Iterator[bool]:
        while not self._database.is_closed and self.step(now):
            yield True

    def _oldest(self, grade: Grade, now: datetime) -> datetime | None:
        """Return the ten-minute mark before the oldest row that is due, ``None`` if there is none."""
        limit = _floor(now - grade.after)
        query = select(func.min(SampleRow.at)).where(SampleRow.period_s == grade.from_s, SampleRow.at < limit)
        with self._database.read() as session:
            oldest = session.scalar(query)
        return None if oldest is None else _floor(oldest)


def _thin(connection: Connection, grade: Grade, start: datetime, end: datetime) -> None:
    due = (SampleRow.period_s == grade.from_s, SampleRow.at >= start, SampleRow.at < end)
    newest = connection.scalar(select(func.max(SampleRow.id)).where(*due))
    columns = [*_KEPT, "speed_mps", *_WORST, "period_s"]
    connection.execute(insert(SampleRow).from_select(columns, _coarse(grade, *due)))
    connection.execute(delete(SampleRow).where(*due, SampleRow.id <= newest))


def _coarse(grade: Grade, *due: ColumnElement[bool]) -> Select[Any]:
    groups = (
        select(
            func.max(SampleRow.id).label("newest_id"),
            func.avg(SampleRow.speed_mps).label("speed_mps"),
            *(_worst(getattr(SampleRow, name)).label(name) for name in _WORST),
        )
        .where(*due)
        .group_by(SampleRow.robot_id, SampleRow.mission_id, stretch_of(grade.digits))
        .subquery()
    )
    return (
        select(*(getattr(SampleRow, name) for name in _KEPT), groups.c.speed_mps)
        .add_columns(*(groups.c[name] for name in _WORST), literal(grade.to_s))
        .join(groups, groups.c.newest_id == SampleRow.id)
    )


def _worst(column: InstrumentedAttribute[float | None]) -> ColumnElement[Any]:
    """Return the value farthest from zero, with its sign; ``abs`` alone would hide on which side the error was."""
    return case((func.max(column) >= -func.min(column), func.max(column)), else_=func.min(column))


def _floor(at: datetime) -> datetime:
    return datetime.fromtimestamp(at.timestamp() // STEP.total_seconds() * STEP.total_seconds(), UTC)

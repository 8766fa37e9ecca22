"""What stations measured, over time: written in batches by a thread, read for charts, thinned with age."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from sqlalchemy import Connection, and_, delete, func, insert, select
from sqlalchemy.dialects import postgresql, sqlite

from hmi.domain.sensors.quantity import Channel
from hmi.domain.sensors.series import Point, floor_to, folded
from hmi.store.batch_writer import BatchWriter, WriterHealth
from hmi.store.database import Database
from hmi.store.sensor_stations import channel_of
from hmi.store.sensor_tables import NO_DEPTH, SensorReadingRow

CAPACITY = 20_000  # values: an hour of 50 stations that measure seven things a minute
LINGER_S = 10.0  # stations speak once a minute: one flush of the disk for many of them
TEN_MINUTES_S, DAY_S = 600, 86_400
KEPT = timedelta(days=3 * 366)
_KEY = ("farm_id", "station_id", "quantity", "depth_cm", "step_s", "at")
_Row = SensorReadingRow


@dataclass(frozen=True, slots=True)
class Grade:
    """Rows finer than ``step_s`` become rows of ``step_s`` once older than ``after``, ``stretch_s`` in one go."""

    step_s: int
    after: timedelta
    stretch_s: int


GRADES = (
    Grade(TEN_MINUTES_S, timedelta(hours=48), 3600),
    Grade(DAY_S, timedelta(days=14), DAY_S),
)


class SensorHistory:
    """The measured values of one farm; ``see`` never waits, all else blocks.

    Args:
        farm_id: whose they are.
    """

    def __init__(
        self, database: Database, farm_id: str, *, capacity: int = CAPACITY, linger_s: float = LINGER_S
    ) -> None:
        self._database, self._farm_id = database, farm_id
        self._writer: BatchWriter[dict[str, Any]] = BatchWriter(
            "sensors", self._write, capacity=capacity, batch_size=2000, linger_s=linger_s
        )

    def start(self) -> None:
        """Start the writer."""
        self._writer.start()

    def close(self, timeout_s: float = 2.0) -> bool:
        """Write what waits and stop; False if something was left over."""
        return self._writer.close(timeout_s)

    def flush(self, timeout_s: float = 5.0) -> bool:
        """Wait until what was seen so far is written."""
        return self._writer.flush(timeout_s)

    def health(self) -> WriterHealth:
        """Return queue, losses and the newest error."""
        return self._writer.health()

    def see(self, station_id: str, channel: Channel, at: datetime, value: float) -> None:
        """Keep one value; the same again is harmless."""
        self._writer.put(self._columns(station_id, channel, 0, Point(at, value, value, value)))

    def put(self, station_id: str, channel: Channel, step_s: int, points: Iterable[Point]) -> None:
        """Write points of one channel at once, e.g. a past that was not watched."""
        rows = [self._columns(station_id, channel, step_s, one) for one in points]
        if rows:
            self._write(rows)

    def points(self, station_id: str, channel: Channel, since: datetime) -> list[Point]:
        """Return what is known of a channel since then, oldest first, whatever its step."""
        query = (
            select(_Row.at, _Row.mean, _Row.low, _Row.high, _Row.count)
            .where(*self._of(station_id, channel), _Row.at >= since)
            .order_by(_Row.at)
        )
        with self._database.read() as session:
            return [Point(*row) for row in session.execute(query)]

    def newest(self) -> list[tuple[str, Channel, datetime, float]]:
        """Return the newest value of each channel, of ten minutes at most: station, channel, time, value."""
        own = and_(_Row.farm_id == self._farm_id, _Row.step_s <= TEN_MINUTES_S)
        last = (
            select(_Row.station_id, _Row.quantity, _Row.depth_cm, func.max(_Row.at).label("last"))
            .where(own)
            .group_by(_Row.station_id, _Row.quantity, _Row.depth_cm)
            .subquery()
        )
        query = select(_Row.station_id, _Row.quantity, _Row.depth_cm, _Row.at, _Row.mean).join(
            last,
            and_(
                own, _Row.station_id == last.c.station_id, _Row.quantity == last.c.quantity,
                _Row.depth_cm == last.c.depth_cm, _Row.at == last.c.last,
            ),
        )  # fmt: skip
        with self._database.read() as session:
            return [(row[0], channel_of(row[1], row[2]), row[3], row[4]) for row in session.execute(query)]

    def has_any(self, station_id: str) -> bool:
        """Say whether anything is known of a station."""
        query = select(_Row.at).where(_Row.farm_id == self._farm_id, _Row.station_id == station_id).limit(1)
        with self._database.read() as session:
            return session.execute(query).first() is not None

    def thin(self, now: datetime) -> int:
        """Thin all that is due, or until the database is closed; return the number of steps."""
        steps = 0
        while not self._database.is_closed and self._thin_step(now):
            steps += 1
        with self._database.connect_writing() as connection:
            connection.execute(delete(_Row).where(_Row.farm_id == self._farm_id, _Row.at < now - KEPT))
        return steps

    def _thin_step(self, now: datetime) -> bool:
        for grade in GRADES:
            limit = floor_to(now - grade.after, grade.stretch_s)
            query = select(func.min(_Row.at)).where(
                _Row.farm_id == self._farm_id, _Row.step_s < grade.step_s, _Row.at < limit
            )
            with self._database.read() as session:
                oldest = session.scalar(query)
            if oldest is not None:
                self._fold(grade, floor_to(oldest, grade.stretch_s))
                return True
        return False

    def _fold(self, grade: Grade, start: datetime) -> None:
        """Fold a stretch; what is already as coarse takes in what came late."""
        due = (
            _Row.farm_id == self._farm_id, _Row.step_s <= grade.step_s,
            _Row.at >= start, _Row.at < start + timedelta(seconds=grade.stretch_s),
        )  # fmt: skip
        columns = (_Row.station_id, _Row.quantity, _Row.depth_cm, _Row.at, _Row.mean, _Row.low, _Row.high, _Row.count)
        groups: dict[tuple[str, Channel, datetime], list[Point]] = {}
        with self._database.connect_writing() as connection:
            for row in connection.execute(select(*columns).where(*due)):
                key = row[0], channel_of(row[1], row[2]), floor_to(row[3], grade.step_s)
                groups.setdefault(key, []).append(Point(*row[3:]))
            connection.execute(delete(_Row).where(*due))
            rows = [
                self._columns(station, channel, grade.step_s, folded(channel.quantity, points, at))
                for (station, channel, at), points in groups.items()
            ]
            connection.execute(insert(_Row), rows)

    def _of(self, station_id: str, channel: Channel) -> tuple[Any, ...]:
        depth_cm = NO_DEPTH if channel.depth_cm is None else channel.depth_cm
        return (
            _Row.farm_id == self._farm_id, _Row.station_id == station_id, _Row.quantity == channel.quantity,
            _Row.depth_cm == depth_cm,
        )  # fmt: skip

    def _columns(self, station_id: str, channel: Channel, step_s: int, point: Point) -> dict[str, Any]:
        return {
            "farm_id": self._farm_id,
            "station_id": station_id,
            "quantity": channel.quantity,
            "depth_cm": NO_DEPTH if channel.depth_cm is None else channel.depth_cm,
            "step_s": step_s,
            "at": point.at,
            "mean": point.mean,
            "low": point.low,
            "high": point.high,
            "count": point.count,
        }

    def _write(self, rows: Sequence[dict[str, Any]]) -> None:
        with self._database.connect_writing() as connection:
            _insert_new(connection, rows)


def _insert_new(connection: Connection, rows: Sequence[dict[str, Any]]) -> None:
    """Insert what is not there yet; both dialects spell it alike, but there is no common word for it."""
    make: Callable[..., Any] = postgresql.insert if connection.dialect.name == "postgresql" else sqlite.insert
    connection.execute(make(_Row).on_conflict_do_nothing(index_elements=list(_KEY)), rows)

"""What was recorded: values over time, tracks and events, never more points than asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import ColumnElement, Select, String, func, literal_column, select, tuple_

from hmi.domain.event import RobotEvent
from hmi.store.database import Database
from hmi.store.sampling import HEIGHT
from hmi.store.tables import EventRow, SampleRow

FIELDS = frozenset({"speed_mps", "soc", "cross_track_m", "gnss_accuracy_m", "rtt_s", "row", "area_done_m2"})
MAX_POINTS = 5000
# Seconds, and how many characters of the time's text name that stretch: the database groups by them.
# The first is every row by itself: a robot that is a little early has two rows within one second.
_STRETCHES = ((0.9, 29), (1, 19), (10, 18), (60, 16), (600, 15), (3600, 13), (86_400, 10))
_FINER = 10  # the database may return this many times too many; neighbours are then merged here


@dataclass(frozen=True, slots=True)
class HistoryPoint:
    """One stretch of time: when it began, and mean, lowest and highest of each field asked for (``None``: no value)."""

    at: datetime
    mean: tuple[float | None, ...]
    low: tuple[float | None, ...]
    high: tuple[float | None, ...]
    count: int


@dataclass(frozen=True, slots=True)
class PosturePoint:
    """Where a robot was and how its joints stood; radians and metres by joint, metres above the ground."""

    at: datetime
    lat_deg: float
    lon_deg: float
    theta_rad: float | None
    joints: dict[str, float] | None
    height_m: float | None = None


@dataclass(frozen=True, slots=True)
class TrackPoint:
    """Where a robot was; WGS84 degrees, ENU yaw in radians."""

    at: datetime
    lat_deg: float
    lon_deg: float
    theta_rad: float | None
    speed_mps: float | None
    mode: str | None
    mission_id: str | None


class History:
    """The history of one farm. Blocking; call through ``Database.run``."""

    def __init__(self, database: Database, farm_id: str) -> None:
        self._database = database
        self._farm_id = farm_id

    def history(
        self, robot_id: str, fields: Sequence[str], start: datetime, end: datetime, max_points: int = 500
    ) -> list[HistoryPoint]:
        """Return ``fields`` (of ``FIELDS``) from ``start`` until before ``end``, oldest first.

        Raises:
            ValueError: unknown field, or no positive number of points.
        """
        if unknown := set(fields) - FIELDS:
            raise ValueError(f"there is no history of {', '.join(sorted(unknown))}")
        max_points = _checked(max_points)
        columns = [function(getattr(SampleRow, name)) for function in (func.avg, func.min, func.max) for name in fields]
        query = self._grouped(robot_id, start, end, max_points * _FINER, func.count(), *columns)
        with self._database.read() as session:
            points = [_point(row, len(fields)) for row in session.execute(query)]
        return _merged(points, max_points)

    def track(self, robot_id: str, start: datetime, end: datetime, max_points: int = 1000) -> list[TrackPoint]:
        """Return where a robot was, oldest first; of each stretch its first position."""
        max_points = _checked(max_points)
        first = self._grouped(robot_id, start, end, max_points * _FINER, func.min(SampleRow.id).label("first_id"))
        chosen = first.subquery()
        query = select(SampleRow).join(chosen, chosen.c.first_id == SampleRow.id).order_by(SampleRow.at)
        with self._database.read() as session:
            rows = [row for row in session.scalars(query) if row.lat_deg is not None and row.lon_deg is not None]
        stride = -(-len(rows) // max_points) or 1
        return [
            TrackPoint(r.at, r.lat_deg, r.lon_deg, r.theta_rad, r.speed_mps, r.mode, r.mission_id)
            for r in rows[::stride]
            if r.lat_deg is not None and r.lon_deg is not None
        ]

    def postures(self, robot_id: str, start: datetime, end: datetime, max_points: int = 3600) -> list[PosturePoint]:
        """Return every sample from ``start`` until before ``end``, oldest first, evenly thinned to ``max_points``."""
        max_points = _checked(max_points)
        query = (
            select(SampleRow.at, SampleRow.lat_deg, SampleRow.lon_deg, SampleRow.theta_rad, SampleRow.joints)
            .where(SampleRow.farm_id == self._farm_id, SampleRow.robot_id == robot_id)
            .where(SampleRow.at >= start, SampleRow.at < end)
            .where(SampleRow.lat_deg.is_not(None), SampleRow.lon_deg.is_not(None))
            .order_by(SampleRow.at)
            .limit(MAX_POINTS * _FINER)
        )
        with self._database.read() as session:
            rows = session.execute(query).all()
        stride = -(-len(rows) // max_points) or 1
        return [
            _posture(at, lat_deg, lon_deg, theta_rad, joints)
            for at, lat_deg, lon_deg, theta_rad, joints in rows[::stride]
            if lat_deg is not None and lon_deg is not None
        ]

    def last_posture(self, robot_id: str) -> PosturePoint | None:
        """Return the newest sample that says where a robot was, ``None`` where there is none."""
        query = (
            select(SampleRow.at, SampleRow.lat_deg, SampleRow.lon_deg, SampleRow.theta_rad, SampleRow.joints)
            .where(SampleRow.farm_id == self._farm_id, SampleRow.robot_id == robot_id)
            .where(SampleRow.lat_deg.is_not(None), SampleRow.lon_deg.is_not(None))
            .order_by(SampleRow.at.desc())
            .limit(1)
        )
        with self._database.read() as session:
            row = session.execute(query).first()
        if row is None or row.lat_deg is None or row.lon_deg is None:
            return None
        return _posture(row.at, row.lat_deg, row.lon_deg, row.theta_rad, row.joints)

    def events(
        self,
        robot_id: str | None = None,
        *,
        start: datetime | None = None,
        end: datetime | None = None,
        kinds: Sequence[str] = (),
        limit: int = 200,
        before: RobotEvent | None = None,
    ) -> list[RobotEvent]:
        """Return events, newest first; page on with the last one as ``before``."""
        query = select(EventRow).filter_by(farm_id=self._farm_id)
        query = query if robot_id is None else query.filter_by(robot_id=robot_id)
        query = query if start is None else query.where(EventRow.at >= start)
        query = query if end is None else query.where(EventRow.at < end)
        query = query if not kinds else query.where(EventRow.kind.in_(kinds))
        order = (EventRow.at, EventRow.robot_id, EventRow.id)
        if before is not None:
            query = query.where(tuple_(*order) < (before.at_utc, before.robot_id, before.event_id))
        query = query.order_by(*(column.desc() for column in order)).limit(_checked(limit))
        with self._database.read() as session:
            return [_event(row) for row in session.scalars(query)]

    def _grouped(self, robot_id: str, start: datetime, end: datetime, most: int, *columns: Any) -> Select[Any]:
        span_s = max((end - start).total_seconds(), 1.0)
        digits = next((digits for seconds, digits in _STRETCHES if span_s / seconds <= most), _STRETCHES[-1][1])
        stretch = stretch_of(digits)
        return (
            select(func.min(SampleRow.at).label("at"), *columns)
            .where(SampleRow.farm_id == self._farm_id, SampleRow.robot_id == robot_id)
            .where(SampleRow.at >= start, SampleRow.at < end)
            .group_by(stretch)
            .order_by(stretch)
        )


def stretch_of(digits: int) -> ColumnElement[str]:
    """Return the start of a sample's time, written out: PostgreSQL takes two parameters for two different things."""
    return func.substr(SampleRow.at, literal_column("1"), literal_column(str(int(digits))), type_=String)


def _checked(most: int) -> int:
    if most < 1:
        raise ValueError(f"cannot return {most} points")
    return min(most, MAX_POINTS)


def _point(row: Any, width: int) -> HistoryPoint:
    at, count, *values = row
    mean, low, high = (
        tuple(None if value is None else float(value) for value in values[index * width : (index + 1) * width])
        for index in range(3)
    )
    return HistoryPoint(at, mean, low, high, count)


def _merged(points: list[HistoryPoint], most: int) -> list[HistoryPoint]:
    size = -(-len(points) // most) or 1
    return [_one(points[index : index + size]) for index in range(0, len(points), size)]


def _one(points: list[HistoryPoint]) -> HistoryPoint:
    if len(points) == 1:
        return points[0]
    return HistoryPoint(
        points[0].at,
        tuple(
            _mean(values, [point.count for point in points]) for values in zip(*(p.mean for p in points), strict=True)
        ),
        tuple(min(_known(values), default=None) for values in zip(*(p.low for p in points), strict=True)),
        tuple(max(_known(values), default=None) for values in zip(*(p.high for p in points), strict=True)),
        sum(point.count for point in points),
    )


def _mean(values: Sequence[float | None], weights: Sequence[int]) -> float | None:
    pairs = [(value, weight) for value, weight in zip(values, weights, strict=True) if value is not None]
    return sum(value * weight for value, weight in pairs) / sum(weight for _, weight in pairs) if pairs else None


def _known(values: Sequence[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _event(row: EventRow) -> RobotEvent:
    return RobotEvent(
        row.robot_id, row.id, row.kind, row.name, row.text, dict(row.data), at_utc=row.at, mission_id=row.mission_id
    )


def _posture(
    at: datetime, lat_deg: float, lon_deg: float, theta_rad: float | None, joints: dict[str, float] | None
) -> PosturePoint:
    """The height is kept beside the joints, by a name that none of them has."""
    if not joints or HEIGHT not in joints:
        return PosturePoint(at, lat_deg, lon_deg, theta_rad, joints)
    known = {name: value for name, value in joints.items() if name != HEIGHT}
    return PosturePoint(at, lat_deg, lon_deg, theta_rad, known or None, joints[HEIGHT])

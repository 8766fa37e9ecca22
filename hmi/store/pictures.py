"""Which pictures a farm keeps. Blocking; call through ``Database.run`` or from the shelf's own thread."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import Select, delete, func, select

from hmi.domain.picture import Moment, Picture, PictureKind
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.picture_tables import PictureRow

_PLAIN = tuple(
    name for name in Picture.__slots__ if name not in ("kind", "moment")
)  # columns that are called as the value's parts
_SOME = 400  # rows in one statement; SQLite takes 999 parameters


@dataclass(frozen=True, slots=True)
class PictureFilter:
    """Which pictures to list; what is ``None`` or empty does not matter.

    Args:
        since, until: aware UTC; ``since`` counts in, ``until`` does not.
        before: time and id of the last one of the page before.
    """

    robot_id: str = ""
    camera: str = ""
    kinds: tuple[PictureKind, ...] = ()
    mission_id: str = ""
    cause: str = ""
    since: datetime | None = None
    until: datetime | None = None
    is_kept: bool | None = None
    before: tuple[datetime, str] | None = None


@dataclass(frozen=True, slots=True)
class Held:
    """What a sweep needs to know of a picture."""

    id: str
    kind: PictureKind
    captured_at: datetime
    size_bytes: int
    is_kept: bool
    media_type: str


class PictureRecords:
    """Pictures of every farm."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(self, one: Picture) -> None:
        """Keep a picture; raises ``AlreadyExists`` for an id that is taken."""
        row = PictureRow(**{name: getattr(one, name) for name in _PLAIN}, kind=one.kind.value, **_moment(one.moment))
        with self._database.write() as session:
            session.add(row)

    def get(self, farm_id: str, picture_id: str) -> Picture:
        """Return one; raises ``NotFound``."""
        with self._database.read() as session:
            row = session.get(PictureRow, picture_id)
            if row is None or row.farm_id != farm_id:
                raise NotFound(f"there is no picture {picture_id}")
            return _picture(row)

    def some(self, farm_id: str, wanted: PictureFilter, limit: int) -> list[Picture]:
        """Return the newest that fit, newest first."""
        query = _fitting(select(PictureRow).filter_by(farm_id=farm_id), wanted)
        query = query.order_by(PictureRow.captured_at.desc(), PictureRow.id.desc()).limit(limit)
        with self._database.read() as session:
            return [_picture(row) for row in session.scalars(query)]

    def mark(self, farm_id: str, picture_id: str, *, note: str | None, is_kept: bool | None) -> Picture:
        """Change note and mark, ``None`` leaves them; raises ``NotFound``."""
        with self._database.write() as session:
            row = session.get(PictureRow, picture_id)
            if row is None or row.farm_id != farm_id:
                raise NotFound(f"there is no picture {picture_id}")
            row.note = row.note if note is None else note
            row.is_kept = row.is_kept if is_kept is None else is_kept
            session.flush()
            return _picture(row)

    def remove(self, farm_id: str, ids: Sequence[str]) -> None:
        """Forget pictures; ids that are not there are no error."""
        with self._database.write() as session:
            for start in range(0, len(ids), _SOME):
                chosen = ids[start : start + _SOME]
                session.execute(delete(PictureRow).where(PictureRow.farm_id == farm_id, PictureRow.id.in_(chosen)))

    def held(self, farm_id: str) -> list[Held]:
        """Return all there are, oldest first."""
        columns = (PictureRow.id, PictureRow.kind, PictureRow.captured_at, PictureRow.size_bytes, PictureRow.is_kept,
                   PictureRow.media_type)  # fmt: skip
        query = select(*columns).filter_by(farm_id=farm_id).order_by(PictureRow.captured_at, PictureRow.id)
        with self._database.read() as session:
            return [
                Held(row.id, PictureKind(row.kind), row.captured_at, row.size_bytes, row.is_kept, row.media_type)
                for row in session.execute(query)
            ]

    def used(self, farm_id: str) -> tuple[int, int]:
        """Return bytes of all pictures, and of those that are marked."""
        size = func.coalesce(func.sum(PictureRow.size_bytes), 0)
        with self._database.read() as session:
            every = session.scalar(select(size).where(PictureRow.farm_id == farm_id))
            marked = session.scalar(select(size).where(PictureRow.farm_id == farm_id, PictureRow.is_kept.is_(True)))
        return int(every or 0), int(marked or 0)

    def newest_frames(self, farm_id: str, robot_id: str) -> dict[str, datetime]:
        """Return when the newest kept frame of each field camera was taken."""
        newest = func.max(PictureRow.captured_at).label("newest")
        query = (
            select(PictureRow.camera, newest)
            .where(PictureRow.farm_id == farm_id, PictureRow.robot_id == robot_id, PictureRow.kind == "frame")
            .group_by(PictureRow.camera)
        )
        with self._database.read() as session:
            return {row.camera: row.newest for row in session.execute(query)}


def _fitting(query: Select[Any], wanted: PictureFilter) -> Select[Any]:
    table = PictureRow
    for column, value in ((table.robot_id, wanted.robot_id), (table.camera, wanted.camera),
                          (table.mission_id, wanted.mission_id)):  # fmt: skip
        if value:
            query = query.where(column == value)
    if wanted.kinds:
        query = query.where(table.kind.in_([one.value for one in wanted.kinds]))
    if wanted.cause:
        query = query.where((" " + table.cause + " ").contains(f" {wanted.cause} ", autoescape=True))
    if wanted.since is not None:
        query = query.where(table.captured_at >= wanted.since)
    if wanted.until is not None:
        query = query.where(table.captured_at < wanted.until)
    if wanted.is_kept is not None:
        query = query.where(table.is_kept.is_(wanted.is_kept))
    if wanted.before is not None:
        at, picture_id = wanted.before
        query = query.where((table.captured_at < at) | ((table.captured_at == at) & (table.id < picture_id)))
    return query


def _moment(moment: Moment) -> dict[str, object]:
    parts = asdict(moment)
    parts["row_number"] = parts.pop("row")
    return parts


def _picture(row: PictureRow) -> Picture:
    moment = Moment(row.lat_deg, row.lon_deg, row.theta_rad, row.position_age_s, row.mission_id, row.mission_name,
                    row.row_number)  # fmt: skip
    return Picture(kind=PictureKind(row.kind), moment=moment, **{name: getattr(row, name) for name in _PLAIN})

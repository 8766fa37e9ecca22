"""Which base maps a farm has. Blocking; call through ``Database.run``."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from datetime import datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from hmi.store.base_map_tables import BaseMapRow
from hmi.store.database import Database
from hmi.store.errors import NotFound


@dataclass(frozen=True, slots=True)
class StoredBaseMap:
    """One base map. Bounds are WGS84 degrees; ``kind`` and ``schema`` as in ``hmi.base_maps.facts``."""

    id: str
    farm_id: str
    name: str
    kind: str
    west_deg: float
    south_deg: float
    east_deg: float
    north_deg: float
    min_zoom: int
    max_zoom: int
    tile_px: int
    schema: str
    media_type: str
    credit: str
    size_bytes: int
    sha256: str
    by: str
    added_at: datetime


class BaseMapRecords:
    """Base maps of every farm."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def all(self, farm_id: str) -> list[StoredBaseMap]:
        """Return all base maps of a farm, by name."""
        with self._database.read() as session:
            rows = session.scalars(select(BaseMapRow).filter_by(farm_id=farm_id))
            return sorted((_stored(row) for row in rows), key=lambda one: (one.name.casefold(), one.id))

    def add(self, one: StoredBaseMap) -> None:
        """Keep a new base map; raises ``AlreadyExists`` when the farm has these very tiles already."""
        with self._database.write() as session:
            session.add(BaseMapRow(**asdict(one)))

    def describe(self, farm_id: str, base_map_id: str, name: str, credit: str) -> StoredBaseMap:
        """Give a base map another name and credit; raises ``NotFound``."""
        with self._database.write() as session:
            row = _row(session, farm_id, base_map_id)
            row.name, row.credit = name, credit
            session.flush()
            return _stored(row)

    def remove(self, farm_id: str, base_map_id: str) -> StoredBaseMap:
        """Forget a base map and return what it was; raises ``NotFound``."""
        with self._database.write() as session:
            row = _row(session, farm_id, base_map_id)
            stored = _stored(row)
            session.delete(row)
            return stored


def _row(session: Session, farm_id: str, base_map_id: str) -> BaseMapRow:
    row = session.get(BaseMapRow, base_map_id)
    if row is None or row.farm_id != farm_id:
        raise NotFound(f"there is no base map {base_map_id}")
    return row


def _stored(row: BaseMapRow) -> StoredBaseMap:
    return StoredBaseMap(**{name: getattr(row, name) for name in StoredBaseMap.__slots__})

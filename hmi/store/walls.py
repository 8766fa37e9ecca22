"""Wall screens: keys that open a session which only watches and does not end by itself."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import select

from hmi.clock import Clock
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.fleet_tables import WallRow


@dataclass(frozen=True, slots=True)
class Wall:
    """One wall screen; ``id`` is the SHA-256 of its key."""

    id: str
    farm_id: str
    name: str
    csrf: str
    made_by: str
    made_at: datetime
    revoked_at: datetime | None = None


def device_of(wall_id: str) -> str:
    """Return the device that a wall screen's session and its STOP token name."""
    return f"wall-{wall_id[:12]}"


class Walls:
    """Blocking; call through ``Database.run``."""

    def __init__(self, database: Database, clock: Clock) -> None:
        self._database, self._clock = database, clock

    def all(self, farm_id: str) -> list[Wall]:
        """Return a farm's wall screens, newest first, revoked ones too."""
        query = select(WallRow).filter_by(farm_id=farm_id).order_by(WallRow.made_at.desc())
        with self._database.read() as session:
            return [_wall(row) for row in session.scalars(query)]

    def add(self, wall_id: str, farm_id: str, name: str, csrf: str, by: str) -> Wall:
        """Keep a new wall screen."""
        row = WallRow(id=wall_id, farm_id=farm_id, name=name, csrf=csrf, made_by=by, made_at=self._clock.utc())
        with self._database.write() as session:
            session.add(row)
            return _wall(row)

    def revoke(self, farm_id: str, wall_id: str) -> Wall:
        """Let the key open nothing any more; raises ``NotFound``."""
        with self._database.write() as session:
            row = session.get(WallRow, wall_id)
            if row is None or row.farm_id != farm_id:
                raise NotFound(f"there is no wall screen {wall_id!r}")
            row.revoked_at = row.revoked_at or self._clock.utc()
            return _wall(row)


def _wall(row: WallRow) -> Wall:
    return Wall(**{name: getattr(row, name) for name in Wall.__slots__})

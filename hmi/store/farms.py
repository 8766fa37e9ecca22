"""Farms, the tenants that every other row belongs to."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import select

from hmi.clock import Clock
from hmi.store.database import Database
from hmi.store.tables import FarmRow


@dataclass(frozen=True, slots=True)
class Farm:
    """One farm."""

    id: str
    name: str
    created_at: datetime


class Farms:
    """Blocking; call through ``Database.run``."""

    def __init__(self, database: Database, clock: Clock) -> None:
        self._database = database
        self._clock = clock

    def ensure(self, farm_id: str, name: str) -> Farm:
        """Return the farm, made if missing; a new name from the settings is taken over."""
        with self._database.write() as session:
            row = session.get(FarmRow, farm_id)
            if row is None:
                row = FarmRow(id=farm_id, name=name, created_at=self._clock.utc())
                session.add(row)
            row.name = name
            return Farm(row.id, row.name, row.created_at)

    def all(self) -> list[Farm]:
        """Return every farm by name."""
        with self._database.read() as session:
            rows = session.scalars(select(FarmRow).order_by(FarmRow.name))
            return [Farm(row.id, row.name, row.created_at) for row in rows]

"""Numbers that only grow, also across restarts and power cuts."""

from __future__ import annotations

from sqlalchemy import select

from hmi.store.database import Database
from hmi.store.errors import AlreadyExists
from hmi.store.tables import CounterRow


class Counters:
    """The counters of one farm. Blocking; call through ``Database.run``."""

    def __init__(self, database: Database, farm_id: str) -> None:
        self._database = database
        self._farm_id = farm_id

    def next_epoch(self, name: str) -> int:
        """Return a number greater than any returned before for ``name``; it is on disk when this returns.

        Raises:
            DatabaseUnavailable: it could not be written, so no number was given out.
        """
        try:
            return self._next(name)
        except AlreadyExists:  # another console made the counter just now
            return self._next(name)

    def _next(self, name: str) -> int:
        query = select(CounterRow).filter_by(farm_id=self._farm_id, name=name).with_for_update()
        with self._database.write() as session:
            row = session.scalars(query).one_or_none()
            if row is None:
                row = CounterRow(farm_id=self._farm_id, name=name, value=0)
                session.add(row)
            row.value += 1
            return row.value

"""Settings of alarms by name, each a JSON object. Blocking; call through ``Database.run``."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any

from hmi.store.alarm_tables import AlarmSettingRow
from hmi.store.database import Database


class AlarmSettings:
    """The settings of one farm."""

    def __init__(self, database: Database, farm_id: str) -> None:
        self._database, self._farm_id = database, farm_id

    def get(self, name: str) -> dict[str, Any] | None:
        """Return a setting, ``None`` if it was never set."""
        with self._database.read() as session:
            row = session.get(AlarmSettingRow, (self._farm_id, name))
            return None if row is None else dict(row.value)

    def put(self, name: str, value: Mapping[str, Any], by: str, at: datetime) -> None:
        """Replace a setting; it is on disk when this returns."""
        self.put_all({name: value}, by, at)

    def put_all(self, values: Mapping[str, Mapping[str, Any]], by: str, at: datetime) -> None:
        """Replace several settings, all or none; they are on disk when this returns."""
        with self._database.write() as session:
            for name, value in values.items():
                session.merge(
                    AlarmSettingRow(farm_id=self._farm_id, name=name, value=dict(value), changed_by=by, changed_at=at)
                )

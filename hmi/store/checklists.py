"""Ticked pre-start checklists: kept for the record, the valid ones in memory."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import select

from hmi.clock import Clock
from hmi.store.database import Database
from hmi.store.mission_tables import ChecklistRow


@dataclass(frozen=True, slots=True)
class Checklist:
    """Who ticked what for which robot, and until when it counts."""

    id: str
    farm_id: str
    robot_id: str
    family: str
    user_id: str
    user_name: str
    device: str
    ticked: tuple[str, ...]
    at: datetime
    valid_until: datetime


class Checklists:
    """``is_valid`` and ``newest`` answer from memory; the rest blocks and goes through ``Database.run``."""

    def __init__(self, database: Database, clock: Clock) -> None:
        self._database, self._clock = database, clock
        self._valid: dict[str, Checklist] = {}

    def load(self) -> None:
        """Read those still valid; at start."""
        query = select(ChecklistRow).where(ChecklistRow.valid_until > self._clock.utc())
        with self._database.read() as session:
            self._valid = {row.id: _checklist(row) for row in session.scalars(query)}

    def add(self, one: Checklist) -> None:
        """Keep a record."""
        with self._database.write() as session:
            fields = {name: getattr(one, name) for name in one.__slots__}
            session.add(ChecklistRow(**{**fields, "ticked": list(one.ticked)}))
        now = self._clock.utc()
        self._valid = {key: kept for key, kept in self._valid.items() if kept.valid_until > now} | {one.id: one}

    def newest(self, farm_id: str, robot_id: str, user_id: str) -> Checklist | None:
        """Return a person's record for a robot that still counts, the newest."""
        now = self._clock.utc()
        found = [
            one
            for one in self._valid.values()
            if (one.farm_id, one.robot_id, one.user_id) == (farm_id, robot_id, user_id) and one.valid_until > now
        ]
        return max(found, key=lambda one: one.at, default=None)

    def is_valid(self, farm_id: str, robot_id: str, user_id: str, checklist_id: str | None) -> bool:
        """Say whether this record is this person's, of this robot, and still counts."""
        one = self._valid.get(checklist_id or "")
        if one is None or one.valid_until <= self._clock.utc():
            return False
        return (one.farm_id, one.robot_id, one.user_id) == (farm_id, robot_id, user_id)


def _checklist(row: ChecklistRow) -> Checklist:
    return Checklist(
        row.id,
        row.farm_id,
        row.robot_id,
        row.family,
        row.user_id,
        row.user_name,
        row.device,
        tuple(row.ticked),
        row.at,
        row.valid_until,
    )

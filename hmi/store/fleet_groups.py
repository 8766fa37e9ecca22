"""Groups of robots of a farm, and the saved views of its people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from hmi.clock import Clock
from hmi.domain.ids import new_id
from hmi.store.database import Database
from hmi.store.errors import AlreadyExists, NotFound
from hmi.store.fleet_tables import FleetGroupRow, FleetViewRow

MOST_VIEWS = 50  # of one person; a script must not fill the disk


@dataclass(frozen=True, slots=True)
class FleetGroup:
    """Robots under a name."""

    id: str
    farm_id: str
    name: str
    robots: tuple[str, ...]
    changed_by: str


@dataclass(frozen=True, slots=True)
class FleetView:
    """How a person looks at the fleet; ``filter`` is the screen's own business."""

    id: str
    name: str
    filter: dict[str, Any]


class FleetGroups:
    """Groups and views. Blocking; call through ``Database.run``."""

    def __init__(self, database: Database, clock: Clock) -> None:
        self._database, self._clock = database, clock

    def groups(self, farm_id: str) -> list[FleetGroup]:
        """Return a farm's groups by name."""
        query = select(FleetGroupRow).filter_by(farm_id=farm_id).order_by(FleetGroupRow.name)
        with self._database.read() as session:
            return [_group(row) for row in session.scalars(query)]

    def add_group(self, farm_id: str, name: str, robots: Sequence[str], by: str) -> FleetGroup:
        """Store a group; raises ``AlreadyExists`` if the farm has one of this name."""
        with self._database.write() as session:
            _refuse_taken(session, farm_id, name)
            row = FleetGroupRow(id=f"g-{new_id()[:12]}", farm_id=farm_id)
            self._fill(row, name, robots, by)
            session.add(row)
            return _group(row)

    def change_group(self, farm_id: str, group_id: str, name: str, robots: Sequence[str], by: str) -> FleetGroup:
        """Replace name and robots; raises ``NotFound``, ``AlreadyExists``."""
        with self._database.write() as session:
            row = _group_row(session, farm_id, group_id)
            if row.name != name:
                _refuse_taken(session, farm_id, name)
            self._fill(row, name, robots, by)
            return _group(row)

    def remove_group(self, farm_id: str, group_id: str) -> FleetGroup:
        """Delete a group and return what it was; raises ``NotFound``."""
        with self._database.write() as session:
            row = _group_row(session, farm_id, group_id)
            found = _group(row)
            session.delete(row)
            return found

    def views(self, farm_id: str, user_id: str) -> list[FleetView]:
        """Return a person's views by name."""
        query = select(FleetViewRow).filter_by(farm_id=farm_id, user_id=user_id).order_by(FleetViewRow.name)
        with self._database.read() as session:
            return [FleetView(row.id, row.name, dict(row.filter)) for row in session.scalars(query)]

    def save_view(self, farm_id: str, user_id: str, name: str, filter_: Mapping[str, Any]) -> FleetView:
        """Keep a view; one of the same name is replaced. Raises ``AlreadyExists`` beyond ``MOST_VIEWS``."""
        with self._database.write() as session:
            row = session.scalar(select(FleetViewRow).filter_by(farm_id=farm_id, user_id=user_id, name=name))
            if row is None:
                mine = select(func.count()).select_from(FleetViewRow).filter_by(farm_id=farm_id, user_id=user_id)
                if (session.scalar(mine) or 0) >= MOST_VIEWS:
                    raise AlreadyExists(f"there are {MOST_VIEWS} views already")
                row = FleetViewRow(
                    id=f"v-{new_id()[:12]}", farm_id=farm_id, user_id=user_id, name=name, created_at=self._clock.utc()
                )
                session.add(row)
            row.filter = dict(filter_)
            return FleetView(row.id, row.name, dict(row.filter))

    def remove_view(self, farm_id: str, user_id: str, view_id: str) -> None:
        """Delete a person's own view; raises ``NotFound``."""
        with self._database.write() as session:
            row = session.get(FleetViewRow, view_id)
            if row is None or (row.farm_id, row.user_id) != (farm_id, user_id):
                raise NotFound(f"there is no view {view_id!r}")
            session.delete(row)

    def _fill(self, row: FleetGroupRow, name: str, robots: Sequence[str], by: str) -> None:
        row.name, row.robots = name, list(dict.fromkeys(robots))
        row.changed_by, row.changed_at = by, self._clock.utc()


def _group_row(session: Session, farm_id: str, group_id: str) -> FleetGroupRow:
    row = session.get(FleetGroupRow, group_id)
    if row is None or row.farm_id != farm_id:
        raise NotFound(f"there is no group {group_id!r}")
    return row


def _refuse_taken(session: Session, farm_id: str, name: str) -> None:
    if session.scalar(select(FleetGroupRow.id).filter_by(farm_id=farm_id, name=name)) is not None:
        raise AlreadyExists(f"there is a group {name!r} already")


def _group(row: FleetGroupRow) -> FleetGroup:
    return FleetGroup(row.id, row.farm_id, row.name, tuple(row.robots), row.changed_by)

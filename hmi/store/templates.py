"""Planning templates of every farm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from hmi.clock import Clock
from hmi.domain.ids import new_id
from hmi.store.database import Database
from hmi.store.errors import AlreadyExists, NotFound
from hmi.store.template_tables import PlanTemplateRow


@dataclass(frozen=True, slots=True)
class PlanTemplate:
    """Choices for planning under a name; ``wish`` is what a planning request carries."""

    id: str
    farm_id: str
    name: str
    wish: dict[str, Any]
    created_by: str
    created_at: datetime


class Templates:
    """The planning templates. Blocking; call through ``Database.run``."""

    def __init__(self, database: Database, clock: Clock) -> None:
        self._database = database
        self._clock = clock

    def all(self, farm_id: str) -> list[PlanTemplate]:
        """Return a farm's templates by name."""
        query = select(PlanTemplateRow).filter_by(farm_id=farm_id).order_by(PlanTemplateRow.name)
        with self._database.read() as session:
            return [_template(row) for row in session.scalars(query)]

    def add(self, farm_id: str, name: str, wish: Mapping[str, Any], by: str) -> PlanTemplate:
        """Store a template.

        Raises:
            AlreadyExists: the farm has one of this name.
        """
        with self._database.write() as session:
            _refuse_taken(session, farm_id, name)
            row = PlanTemplateRow(
                id=f"t-{new_id()[:12]}",
                farm_id=farm_id,
                name=name,
                wish=dict(wish),
                created_by=by,
                created_at=self._clock.utc(),
            )
            session.add(row)
            return _template(row)

    def rename(self, farm_id: str, template_id: str, name: str) -> PlanTemplate:
        """Give a template another name.

        Raises:
            NotFound: there is no such template in this farm.
            AlreadyExists: the farm has another one of this name.
        """
        with self._database.write() as session:
            row = _row(session, farm_id, template_id)
            if row.name != name:
                _refuse_taken(session, farm_id, name)
            row.name = name
            return _template(row)

    def delete(self, farm_id: str, template_id: str) -> PlanTemplate:
        """Delete a template and return what it was; raises ``NotFound``."""
        with self._database.write() as session:
            row = _row(session, farm_id, template_id)
            found = _template(row)
            session.delete(row)
            return found


def _row(session: Session, farm_id: str, template_id: str) -> PlanTemplateRow:
    row = session.get(PlanTemplateRow, template_id)
    if row is None or row.farm_id != farm_id:
        raise NotFound(f"there is no template {template_id!r}")
    return row


def _refuse_taken(session: Session, farm_id: str, name: str) -> None:
    if session.scalar(select(PlanTemplateRow.id).filter_by(farm_id=farm_id, name=name)) is not None:
        raise AlreadyExists(f"there is a template {name!r} already")


def _template(row: PlanTemplateRow) -> PlanTemplate:
    return PlanTemplate(row.id, row.farm_id, row.name, dict(row.wish), row.created_by, row.created_at)

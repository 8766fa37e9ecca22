"""The record of armings: who armed which queue, until when, and what ended it."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

from sqlalchemy import func, select, update

from hmi.domain.queue.arming import Arming
from hmi.store.database import Database
from hmi.store.queue_tables import QueueArmingRow


class QueueArmings:
    """Blocking; call through ``Database.run``."""

    def __init__(self, database: Database, farm_id: str) -> None:
        self._database, self._farm_id = database, farm_id

    def begin(self, armings: Sequence[Arming]) -> None:
        """Note that queues were armed; it is on disk when this returns."""
        with self._database.write() as session:
            session.add_all(
                QueueArmingRow(
                    farm_id=self._farm_id,
                    arming_id=one.id,
                    robot_id=one.robot_id,
                    revision=one.revision,
                    by=one.by,
                    armed_at=one.armed_at,
                    until=one.until,
                    ended_why="",
                )
                for one in armings
            )

    def end(self, arming: Arming, why: str, at: datetime) -> None:
        """Note what ended one."""
        rows = update(QueueArmingRow).filter_by(
            farm_id=self._farm_id, arming_id=arming.id, robot_id=arming.robot_id, ended_at=None
        )
        with self._database.write() as session:
            session.execute(rows.values(ended_at=at, ended_why=why[:400]))

    def end_all(self, why: str, at: datetime) -> list[str]:
        """End what a console before this one left armed; return the robots."""
        left = select(QueueArmingRow).filter_by(farm_id=self._farm_id, ended_at=None)
        with self._database.write() as session:
            rows = list(session.scalars(left))
            for row in rows:
                row.ended_at, row.ended_why = at, why
            return sorted({row.robot_id for row in rows})

    def last(self) -> dict[str, tuple[str, datetime]]:
        """Return why and when the newest arming of each robot ended."""
        newest = select(func.max(QueueArmingRow.id)).filter_by(farm_id=self._farm_id).group_by(QueueArmingRow.robot_id)
        with self._database.read() as session:
            rows = session.scalars(select(QueueArmingRow).where(QueueArmingRow.id.in_(newest)))
            return {row.robot_id: (row.ended_why, row.ended_at) for row in rows if row.ended_at is not None}

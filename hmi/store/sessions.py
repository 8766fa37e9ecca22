"""Signed-in browsers on disk, so that a restart of the console signs nobody out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import delete, select, update

from hmi.domain.role import Role
from hmi.store.database import Database
from hmi.store.tables import DeviceRow, SessionRow, UserRow


@dataclass(frozen=True, slots=True)
class StoredSession:
    """One session with the names it shows; ``id`` is the SHA-256 of the cookie."""

    id: str
    farm_id: str
    user_id: str
    user_name: str
    role: Role
    device_id: str
    device_name: str
    csrf: str
    expires_at: datetime


class SessionRecords:
    """Blocking; call through ``Database.run``."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(self, session: StoredSession, created_at: datetime) -> None:
        """Keep a new session."""
        row = SessionRow(
            id=session.id,
            farm_id=session.farm_id,
            user_id=session.user_id,
            device_id=session.device_id,
            csrf=session.csrf,
            created_at=created_at,
            expires_at=session.expires_at,
        )
        with self._database.write() as transaction:
            transaction.add(row)

    def open(self, farm_id: str, now: datetime) -> list[StoredSession]:
        """Return the sessions that may go on: not ended, not expired, person still active."""
        query = (
            select(SessionRow, UserRow, DeviceRow.name)
            .join(UserRow, UserRow.id == SessionRow.user_id)
            .outerjoin(DeviceRow, DeviceRow.id == SessionRow.device_id)
            .where(SessionRow.farm_id == farm_id, SessionRow.ended_at.is_(None), SessionRow.expires_at > now)
            .where(UserRow.is_active.is_(True))
        )
        with self._database.read() as session:
            return [_stored(row, user, device_name) for row, user, device_name in session.execute(query)]

    def end(self, ids: Iterable[str], now: datetime) -> None:
        """Mark sessions as ended."""
        query = update(SessionRow).where(SessionRow.id.in_(list(ids)), SessionRow.ended_at.is_(None))
        with self._database.write() as session:
            session.execute(query.values(ended_at=now))

    def end_all_of(self, user_id: str, now: datetime) -> None:
        """Mark every session of a person as ended, also those that another console opened."""
        query = update(SessionRow).where(SessionRow.user_id == user_id, SessionRow.ended_at.is_(None))
        with self._database.write() as session:
            session.execute(query.values(ended_at=now))

    def move(self, session_id: str, device_id: str) -> None:
        """Note that a session now runs on an enrolled device."""
        with self._database.write() as session:
            session.execute(update(SessionRow).where(SessionRow.id == session_id).values(device_id=device_id))

    def forget_before(self, farm_id: str, limit: datetime) -> int:
        """Delete sessions that expired before ``limit``; return how many. Sign-ins stay in the audit."""
        query = delete(SessionRow).where(SessionRow.farm_id == farm_id, SessionRow.expires_at < limit)
        with self._database.connect_writing() as connection:
            return connection.execute(query).rowcount


def _stored(row: SessionRow, user: UserRow, device_name: str | None) -> StoredSession:
    return StoredSession(
        row.id, row.farm_id, user.id, user.name, Role(user.role), row.device_id or "", device_name or "", row.csrf,
        row.expires_at,
    )  # fmt: skip

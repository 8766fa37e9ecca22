"""People: who they are, what they may do, and the hashes of their passwords and PINs."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from hmi.clock import Clock
from hmi.domain.role import Role
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.tables import UserRow


@dataclass(frozen=True, slots=True)
class User:
    """A person; ``id`` is what is typed to sign in, ``name`` what others read."""

    id: str
    farm_id: str
    name: str
    role: Role
    is_active: bool
    has_pin: bool
    preferences: dict[str, Any]
    created_at: datetime


@dataclass(frozen=True, slots=True)
class Credentials:
    """The argon2id hashes of a person; never leaves the server."""

    user: User
    password_hash: str = field(repr=False)
    pin_hash: str | None = field(repr=False)


class Users:
    """Blocking; call through ``Database.run``. Ids are unique in the whole database, not only in a farm."""

    def __init__(self, database: Database, clock: Clock) -> None:
        self._database = database
        self._clock = clock

    def get(self, user_id: str) -> User | None:
        """Return one person, active or not."""
        with self._database.read() as session:
            row = session.get(UserRow, user_id)
            return None if row is None else _user(row)

    def all(self, farm_id: str) -> list[User]:
        """Return the people of a farm by name, those who may no longer sign in too."""
        with self._database.read() as session:
            return [_user(row) for row in session.scalars(_of_farm(farm_id))]

    def count(self, farm_id: str) -> int:
        """Return how many people the farm has; 0 means that the first one is still to be made."""
        with self._database.read() as session:
            return session.scalar(select(func.count()).select_from(UserRow).filter_by(farm_id=farm_id)) or 0

    def credentials(self, user_id: str) -> Credentials | None:
        """Return a person with the hashes, or ``None`` if nobody has this id."""
        with self._database.read() as session:
            row = session.get(UserRow, user_id)
            return None if row is None else Credentials(_user(row), row.password_hash, row.pin_hash)

    def add(
        self, user_id: str, farm_id: str, name: str, role: Role, password_hash: str, pin_hash: str | None = None
    ) -> User:
        """Add a person.

        Raises:
            AlreadyExists: the id is taken.
        """
        row = UserRow(
            id=user_id,
            farm_id=farm_id,
            name=name,
            role=role.value,
            password_hash=password_hash,
            pin_hash=pin_hash,
            is_active=True,
            preferences={},
            created_at=self._clock.utc(),
        )
        with self._database.write() as session:
            session.add(row)
            session.flush()
            return _user(row)

    def change(
        self, farm_id: str, user_id: str, *, name: str | None = None, role: Role | None = None,
        is_active: bool | None = None,
    ) -> User:  # fmt: skip
        """Change what is given and return the person. Sessions are the caller's business.

        Raises:
            NotFound: nobody of this farm has the id.
        """
        with self._database.write() as session:
            row = _one(session, farm_id, user_id)
            row.name = row.name if name is None else name
            row.role = row.role if role is None else role.value
            row.is_active = row.is_active if is_active is None else is_active
            return _user(row)

    def set_password_hash(self, farm_id: str, user_id: str, password_hash: str) -> None:
        """Replace the password. Raises ``NotFound``."""
        with self._database.write() as session:
            _one(session, farm_id, user_id).password_hash = password_hash

    def set_pin_hash(self, farm_id: str, user_id: str, pin_hash: str | None) -> None:
        """Replace or remove the PIN. Raises ``NotFound``."""
        with self._database.write() as session:
            _one(session, farm_id, user_id).pin_hash = pin_hash

    def set_preferences(self, farm_id: str, user_id: str, preferences: dict[str, Any]) -> None:
        """Replace the preferences (theme, units, way to confirm). Raises ``NotFound``."""
        with self._database.write() as session:
            _one(session, farm_id, user_id).preferences = preferences


def _of_farm(farm_id: str) -> Any:
    return select(UserRow).filter_by(farm_id=farm_id).order_by(UserRow.name, UserRow.id)


def _one(session: Session, farm_id: str, user_id: str) -> UserRow:
    row = session.get(UserRow, user_id)
    if row is None or row.farm_id != farm_id:
        raise NotFound(f"nobody here signs in as {user_id!r}")
    return row


def _user(row: UserRow) -> User:
    return User(
        row.id, row.farm_id, row.name, Role(row.role), row.is_active, row.pin_hash is not None,
        dict(row.preferences), row.created_at,
    )  # fmt: skip

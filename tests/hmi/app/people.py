"""Sessions of people for the tests of this room."""

from __future__ import annotations

from datetime import UTC, datetime

from hmi.domain.role import Role
from hmi.security.session_info import SessionInfo


def session_of(role: Role) -> SessionInfo:
    """Return a session of somebody with this role."""
    return SessionInfo(
        session_id=f"session-{role.value}",
        user_id=role.value,
        user_name=role.value.capitalize(),
        role=role,
        farm_id="farm",
        device_id="tablet-3",
        device_name="Tablet 3",
        csrf="csrf",
        expires_utc=datetime(2030, 1, 1, tzinfo=UTC),
    )

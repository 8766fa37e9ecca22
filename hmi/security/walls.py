"""Wall screens: a key that opens a session which watches, may stop, and does not end by itself.

The key is the session cookie of the screen, so the database keeps only its hash. Whoever calls has asked for
``Permission.MANAGE_WALLS`` first.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

from hmi.domain.role import Role
from hmi.security.cookie import new_cookie, session_id_of
from hmi.security.errors import NotSignedIn
from hmi.security.session_info import SessionInfo
from hmi.security.sessions import Sessions
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.stop_list import StopList
from hmi.store.walls import Wall, Walls, device_of

REVOKED = "This wall screen was taken out."
NEVER = datetime(9999, 12, 31, tzinfo=UTC)
COOKIE_S = 400 * 86_400.0  # the longest a browser keeps a cookie; each opening of the page sets it anew


@dataclass(frozen=True, slots=True)
class NewWall:
    """A wall screen just made; ``key`` is shown once and kept nowhere."""

    wall: Wall
    key: str


class WallScreens:
    """The wall screens of one farm."""

    def __init__(
        self,
        database: Database,
        walls: Walls,
        sessions: Sessions,
        farm_id: str,
        audit: Callable[[AuditEntry], None],
        stop_list: StopList,
    ) -> None:
        self._database, self._walls, self._sessions = database, walls, sessions
        self._farm_id, self._audit, self._stop_list = farm_id, audit, stop_list

    async def load(self) -> None:
        """Let the keys that are valid open their sessions; at start."""
        for wall in await self._database.run(self._walls.all, self._farm_id):
            if wall.revoked_at is None:
                self._sessions.admit_wall(_session(wall))

    async def all(self) -> list[Wall]:
        """Return every wall screen, newest first."""
        return await self._database.run(self._walls.all, self._farm_id)

    async def make(self, by: SessionInfo, name: str) -> NewWall:
        """Make a wall screen and its key."""
        key = new_cookie()
        csrf = secrets.token_urlsafe(32)
        wall = await self._database.run(
            self._walls.add, session_id_of(key), self._farm_id, name, csrf, by.user_name
        )  # fmt: skip
        self._sessions.admit_wall(_session(wall))
        self._note(by, wall, "made")
        return NewWall(wall, key)

    async def revoke(self, by: SessionInfo, wall_id: str) -> Wall:
        """End a wall screen and its STOP at once.

        Raises:
            NotFound: there is none.
            StopListNotWritten: it is ended, but the STOP gateway could not be told yet.
        """
        self._sessions.dismiss_wall(wall_id, REVOKED)
        wall = await self._database.run(self._walls.revoke, self._farm_id, wall_id)
        self._note(by, wall, "revoked")
        await self._database.run(self._stop_list.export)
        return wall

    def open(self, key: str) -> SessionInfo:
        """Return the session of a key; raises ``NotSignedIn``."""
        session = self._sessions.get(session_id_of(key))
        if session is None or not session.is_wall:
            raise NotSignedIn
        self._audit(
            AuditEntry(
                session.farm_id, session.user_name, "", "wall", "opened", ref=session.session_id[:16],
                text=f"{session.user_name} opened.",
            )
        )  # fmt: skip
        return session

    def _note(self, by: SessionInfo, wall: Wall, outcome: str) -> None:
        self._audit(
            AuditEntry(
                by.farm_id, by.user_name, by.device_name, "wall", outcome, ref=wall.id[:16],
                text=f"Wall screen {wall.name} {outcome}.",
            )
        )  # fmt: skip


def _session(wall: Wall) -> SessionInfo:
    return SessionInfo(
        wall.id, device_of(wall.id), f"Wall {wall.name}", Role.VIEWER, device_of(wall.id), wall.name,
        wall.farm_id, wall.csrf, NEVER, is_wall=True,
    )  # fmt: skip

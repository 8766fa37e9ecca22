"""Signed-in browsers: made by signing in, looked up on every request, ended by sign-out, expiry or an administrator.

The truth while the console runs is in memory; the database brings it back after a restart. A session ends by the
monotonic clock, so that setting the wall clock back lengthens none.
"""

from __future__ import annotations

import logging
import secrets
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from datetime import timedelta

from hmi.clock import Clock
from hmi.security.cookie import cookies_in, new_cookie, session_id_of
from hmi.security.errors import NotSignedIn
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.errors import DatabaseUnavailable
from hmi.store.sessions import SessionRecords, StoredSession
from hmi.store.users import User

logger = logging.getLogger(__name__)

Ended = Callable[[SessionInfo, str], None]
MAX_PER_PERSON = 20  # the oldest ends; a script that signs in again and again must not fill the memory
_REMEMBERED = 1000  # ended ones that an answer of the database under way may still call open
SIGNED_OUT = "You signed out."
EXPIRED = "Your sign-in has expired. Sign in again."
RIGHTS_CHANGED = "Your account was changed. Sign in again."
TOO_MANY = "You signed in on too many browsers. This one was signed out."


@dataclass(slots=True)
class _Live:
    info: SessionInfo
    ends_s: float


class Sessions:
    """The open sessions of one farm.

    ``lookup``, ``get`` and ``sweep`` are synchronous, fast and meant for the event loop, where all methods belong;
    the ``async`` ones also write to the database, in its threads.
    """

    def __init__(self, database: Database, clock: Clock, farm_id: str, lifetime_s: float) -> None:
        self._database = database
        self._records = SessionRecords(database)
        self._clock = clock
        self._farm_id = farm_id
        self._lifetime_s = lifetime_s
        self._open: dict[str, _Live] = {}
        self._walls: dict[str, SessionInfo] = {}
        self._unwritten_ends: set[str] = set()
        self._gone: deque[str] = deque(maxlen=_REMEMBERED)
        self._listeners: list[Ended] = []

    @property
    def lifetime_s(self) -> float:
        """How long a fresh session lasts."""
        return self._lifetime_s

    async def load(self) -> None:
        """Take up the sessions that were open before a restart."""
        await self.reconcile()

    async def reconcile(self) -> None:
        """Agree with the database: take up what another console opened, end what it or the command line ended.

        To be called every few seconds; cheap.

        Raises:
            DatabaseUnavailable: nothing changed.
        """
        await self._write_ends()
        here = set(self._open)
        now = self._clock.utc()
        stored = {one.id: one for one in await self._database.run(self._records.open, self._farm_id, now)}
        self._close([key for key in here if key not in stored or self._differs(stored[key])], RIGHTS_CHANGED)
        for one in stored.values():
            if one.id not in self._open and one.id not in self._gone:
                left_s = min((one.expires_at - now).total_seconds(), self._lifetime_s)
                self._open[one.id] = _Live(_info(one), self._clock.mono_s() + left_s)

    def lookup(self, cookie: str | None) -> SessionInfo | None:
        """Return who sent this cookie, or ``None`` if it opens nothing (any more)."""
        return None if not cookie else self.get(session_id_of(cookie))

    def of_headers(self, headers: Iterable[tuple[bytes, bytes]]) -> SessionInfo | None:
        """Return who sent these raw ASGI headers (``scope["headers"]``), or ``None``."""
        return next((info for cookie in cookies_in(headers) if (info := self.lookup(cookie))), None)

    def get(self, session_id: str) -> SessionInfo | None:
        """Return an open session by its id: how a page or lane asks whether it may go on."""
        live = self._open.get(session_id)
        if live is None:
            return self._walls.get(session_id)
        if self._clock.mono_s() >= live.ends_s:
            self._close([session_id], EXPIRED)
            return None
        return live.info

    def all(self) -> list[SessionInfo]:
        """Return every open session."""
        return [*(live.info for live in self._open.values()), *self._walls.values()]

    def admit_wall(self, info: SessionInfo) -> None:
        """Keep a wall screen's session open until ``dismiss_wall``; it has no user and no time limit."""
        self._walls[info.session_id] = info

    def dismiss_wall(self, session_id: str, text: str) -> None:
        """End a wall screen's session at once; one that is not open is not missed."""
        info = self._walls.pop(session_id, None)
        if info is not None:
            self._tell_end(info, text)

    def on_ended(self, callback: Ended) -> Callable[[], None]:
        """Call ``callback(session, text)`` when a session ends; return a function that takes it back.

        It runs on the event loop, at once, and must neither block nor wait.
        """
        self._listeners.append(callback)
        return lambda: self._listeners.remove(callback) if callback in self._listeners else None

    async def open(self, user: User, device_id: str, device_name: str) -> tuple[str, SessionInfo]:
        """Open a session under a fresh random cookie, whatever cookie the browser sent; return both.

        Raises:
            DatabaseUnavailable: nothing was opened.
        """
        cookie = new_cookie()
        now = self._clock.utc()
        stored = StoredSession(
            id=session_id_of(cookie),
            farm_id=user.farm_id,
            user_id=user.id,
            user_name=user.name,
            role=user.role,
            device_id=device_id,
            device_name=device_name,
            csrf=secrets.token_urlsafe(32),
            expires_at=now + timedelta(seconds=self._lifetime_s),
        )
        await self._database.run(self._records.add, stored, now)
        info = _info(stored)
        self._open[stored.id] = _Live(info, self._clock.mono_s() + self._lifetime_s)
        await self._end([live.info.session_id for live in self._oldest_of(user.id)], TOO_MANY)
        return cookie, info

    async def end(self, session_id: str, text: str = SIGNED_OUT) -> None:
        """End one session: its pages close, its cookie opens nothing."""
        await self._end([session_id], text)

    async def end_all_of(self, user_id: str, text: str = RIGHTS_CHANGED) -> None:
        """End every session of a person, other consoles' too: after a new password or role.

        Raises:
            DatabaseUnavailable: ended here, but they may come back after a restart.
        """
        self._close([key for key, live in self._open.items() if live.info.user_id == user_id], text)
        await self._database.run(self._records.end_all_of, user_id, self._clock.utc())

    async def end_all_on(self, device_id: str, text: str = "This tablet was taken out.") -> None:
        """End every session on a device that was revoked."""
        await self._end([key for key, live in self._open.items() if live.info.device_id == device_id], text)

    def sweep(self) -> int:
        """End what expired and return how many; to be called once a second, so that idle pages close too."""
        now_s = self._clock.mono_s()
        expired = [key for key, live in self._open.items() if now_s >= live.ends_s]
        self._close(expired, EXPIRED)
        return len(expired)

    async def move(self, session_id: str, device_id: str, device_name: str) -> SessionInfo:
        """Let a session go on as one on an enrolled device; return it.

        Raises:
            NotSignedIn: it ended meanwhile.
        """
        await self._database.run(self._records.move, session_id, device_id)
        live = self._open.get(session_id)
        if live is None:
            raise NotSignedIn
        live.info = replace(live.info, device_id=device_id, device_name=device_name)
        return live.info

    async def forget_old(self, keep_s: float = 30 * 86_400) -> None:
        """Delete rows of sessions that expired long ago; once a day. Sign-ins stay in the audit."""
        limit = self._clock.utc() - timedelta(seconds=keep_s)
        await self._database.run(self._records.forget_before, self._farm_id, limit)

    def _differs(self, stored: StoredSession) -> bool:
        live = self._open.get(stored.id)
        return live is not None and (live.info.role, live.info.user_name) != (stored.role, stored.user_name)

    def _oldest_of(self, user_id: str) -> list[_Live]:
        mine = sorted(
            (live for live in self._open.values() if live.info.user_id == user_id), key=lambda one: one.ends_s
        )
        return mine[:-MAX_PER_PERSON]

    async def _end(self, session_ids: list[str], text: str) -> None:
        if not session_ids:
            return
        self._close(session_ids, text)
        self._unwritten_ends.update(session_ids)
        try:
            await self._write_ends()
        except DatabaseUnavailable:
            logger.exception("a sign-out is not in the database yet; the session is closed all the same")

    async def _write_ends(self) -> None:
        ids = sorted(self._unwritten_ends)
        if ids:
            await self._database.run(self._records.end, ids, self._clock.utc())
            self._unwritten_ends.difference_update(ids)

    def _close(self, session_ids: list[str], text: str) -> None:
        self._gone.extend(session_ids)
        ended = [live.info for key in session_ids if (live := self._open.pop(key, None)) is not None]
        for info in ended:
            self._tell_end(info, text)

    def _tell_end(self, info: SessionInfo, text: str) -> None:
        for listener in tuple(self._listeners):
            try:
                listener(info, text)
            except Exception:
                logger.exception("a page could not be told that its session ended")


def _info(stored: StoredSession) -> SessionInfo:
    return SessionInfo(
        stored.id, stored.user_id, stored.user_name, stored.role, stored.device_id, stored.device_name,
        stored.farm_id, stored.csrf, stored.expires_at,
    )  # fmt: skip

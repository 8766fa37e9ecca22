"""Tablets that belong to the farm: STOP works on their sign-in page, and people sign in on them by PIN."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hmi.security.errors import BadAccount
from hmi.security.session_info import SessionInfo
from hmi.security.sessions import Sessions
from hmi.security.stop_tokens import StopTokens
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.devices import Device, Devices

_MAX_NAME = 80


@dataclass(frozen=True, slots=True)
class Enrolled:
    """A fresh device, the token its browser keeps, and the session that now runs on it."""

    device: Device
    stop_token: str
    session: SessionInfo


class Enrolment:
    """Takes tablets in and out. Whoever calls has asked for ``Permission.ENROL_DEVICE`` first."""

    def __init__(
        self,
        database: Database,
        devices: Devices,
        sessions: Sessions,
        tokens: StopTokens,
        audit: Callable[[AuditEntry], None],
    ) -> None:
        self._database = database
        self._devices = devices
        self._sessions = sessions
        self._tokens = tokens
        self._audit = audit

    async def enrol(self, session: SessionInfo, name: str) -> Enrolled:
        """Make the browser of ``session`` an enrolled tablet.

        Raises:
            BadAccount: the name is empty or too long.
        """
        shown = " ".join(name.split())
        if not shown or len(shown) > _MAX_NAME or not shown.isprintable():
            raise BadAccount(f"A tablet's name has 1 to {_MAX_NAME} letters.", "name")
        device = await self._database.run(self._devices.enrol, session.farm_id, shown, session.user_id)
        moved = await self._sessions.move(session.session_id, device.id, device.name)
        self._note(session, device, "enrolled")
        return Enrolled(device, self._tokens.issue_stop_token(moved), moved)

    async def revoke(self, session: SessionInfo, device_id: str) -> Device:
        """Take a lost tablet out: sessions on it end, its STOP token and PINs stop working.

        Raises:
            NotFound: this farm has no such tablet.
            StopListNotWritten: taken out here, but its STOP token still works at the gateway.
        """
        try:
            device = await self._database.run(self._devices.revoke, session.farm_id, device_id)
        finally:
            if self._devices.is_revoked(device_id):
                await self._sessions.end_all_on(device_id)
        self._note(session, device, "revoked")
        return device

    def _note(self, session: SessionInfo, device: Device, outcome: str) -> None:
        self._audit(
            AuditEntry(
                session.farm_id, session.user_name, session.device_name, "device", outcome, ref=device.id,
                text=device.name,
            )
        )  # fmt: skip

"""What the screens need from the console; filled once by the composition root."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nicegui import ui

from components.live_map import Engine
from hmi.clock import Clock
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize, is_allowed
from hmi.security.session_info import SessionInfo
from hmi.security.sessions import Sessions
from hmi.settings import Settings
from hmi.store.fleet import FleetStore


@dataclass(frozen=True, slots=True)
class StopAddress:
    """Where browsers find the STOP gateway: the public address, else the console's host with ``port``."""

    port: int
    public_url: str | None = None


@dataclass(frozen=True, slots=True)
class PageServices:
    """Everything a page may use. Pages read state here; whatever changes something goes through REST.

    ``features`` and ``missions`` are the services of the missions screen.
    """

    settings: Settings
    clock: Clock
    fleet: FleetStore
    sessions: Sessions
    authorize: Authorize
    stop: StopAddress
    features: Any = None
    missions: Any = None

    def session(self) -> SessionInfo | None:
        """Return who the page being built is for, ``None`` if nobody signed in."""
        return self.sessions.of_headers(ui.context.client.request.scope["headers"])

    def map_engine(self, *, is_near: bool) -> Engine:
        """Return which engine draws a map: of one robot (``is_near``) or of the whole fleet."""
        if self.settings.map_engine == "simple":
            return "canvas"
        return "quick" if is_near and self.settings.map_engine == "auto" else "auto"

    def refusal(self, session: SessionInfo, permission: Permission, robot_id: str | None = None) -> str:
        """Return why this is not allowed now, empty if it is; an ended session may do nothing."""
        return is_allowed(self.authorize, self.sessions.get(session.session_id), permission, robot_id)

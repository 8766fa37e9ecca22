"""Who is asking: session cookie or stop token, and the question about rights."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any, Protocol

from fastapi import Depends, Request

from hmi.domain.role import Permission
from hmi.domain.stop_token import StopToken
from hmi.security.authorization import Authorize
from hmi.security.errors import BadToken, NotSignedIn
from hmi.security.session_info import SessionInfo

BEARER = "bearer "


class SessionLookup(Protocol):
    """Who is signed in; ``hmi.security.sessions.Sessions`` is one."""

    def of_headers(self, headers: Iterable[tuple[bytes, bytes]]) -> SessionInfo | None:
        """Return whose session cookie these raw headers carry."""
        ...


class StopTokenReader(Protocol):
    """Reads stop tokens; ``hmi.security.stop_tokens.StopTokens`` is one."""

    def read_stop_token(self, text: str) -> StopToken:
        """Return what a token says; raises ``BadToken``."""
        ...


@dataclass(frozen=True, slots=True)
class Access:
    """Answers who asks and whether they may; kept in ``app.state.access``."""

    sessions: SessionLookup
    tokens: StopTokenReader
    authorize: Authorize

    def visitor(self, request: Request) -> SessionInfo | None:
        """Return the session of a request, if there is one."""
        return self.sessions.of_headers(request.scope["headers"])

    def presser(self, request: Request) -> StopToken:
        """Return who presses STOP: by stop token, else by session.

        Raises:
            BadToken, NotSignedIn: neither is good.
        """
        text = bearer(request)
        session = self.visitor(request)
        if text:
            try:
                return self.tokens.read_stop_token(text)
            except BadToken:
                if session is None:  # a stale token beside a good session must not stand in the way of STOP
                    raise
        if session is None:
            raise NotSignedIn
        self.authorize(session, Permission.STOP)
        return StopToken(session.device_id, session.device_name, session.user_id, session.user_name, session.farm_id)


def bearer(request: Request) -> str:
    """Return the bearer token of a request, empty without one."""
    header = request.headers.get("authorization", "")
    return header[len(BEARER) :].strip() if header.lower().startswith(BEARER) else ""


def access_of(request: Request) -> Access:
    """Return the access rules of the application that serves this request."""
    access = request.app.state.access
    assert isinstance(access, Access)
    return access


async def signed_in(request: Request) -> SessionInfo:
    """Return the session of a request; raises ``NotSignedIn``."""
    session = access_of(request).visitor(request)
    if session is None:
        raise NotSignedIn
    return session


def may(permission: Permission) -> Any:
    """Return a dependency: the session, if it has this right; raises ``NotSignedIn`` or ``NotAllowed``."""

    async def check(request: Request) -> SessionInfo:
        session = await signed_in(request)
        access_of(request).authorize(session, permission)
        return session

    return Depends(check)


SignedIn = Annotated[SessionInfo, Depends(signed_in)]
Watcher = Annotated[SessionInfo, may(Permission.WATCH)]
Enroller = Annotated[SessionInfo, may(Permission.ENROL_DEVICE)]
RobotManager = Annotated[SessionInfo, may(Permission.MANAGE_ROBOTS)]
UserManager = Annotated[SessionInfo, may(Permission.MANAGE_USERS)]
Auditor = Annotated[SessionInfo, may(Permission.READ_AUDIT)]
Diagnostician = Annotated[SessionInfo, may(Permission.READ_DIAGNOSTICS)]

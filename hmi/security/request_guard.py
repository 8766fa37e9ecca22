"""The outermost gate: which requests and websockets reach the console at all.

Pure ASGI, a few string comparisons a request; only writing requests look up the session.
"""

from __future__ import annotations

import hmac
import json
from collections.abc import Callable, Iterable

from starlette.types import ASGIApp, Receive, Scope, Send

from hmi.security.cookie import COOKIE_NAME, CSRF_HEADER
from hmi.security.origins import Origins
from hmi.security.session_info import SessionInfo

Headers = list[tuple[bytes, bytes]]
SessionOf = Callable[[Iterable[tuple[bytes, bytes]]], SessionInfo | None]

_READING = frozenset({"GET", "HEAD", "OPTIONS"})
_API = "/api/"
_SOCKET_IO = "/_nicegui_ws/"
# Signing in has no session yet, and a STOP must not fail for a token that went stale; both keep the Origin check.
_WITHOUT_CSRF = frozenset({("POST", "/api/v1/session"), ("POST", "/api/v1/stop")})

UNKNOWN_HOST = "This console does not answer to that name. Add it to allowed_origins if it should."
FOREIGN_ORIGIN = "This page is not part of the console."
NO_CSRF = "This page is out of date. Reload it and try again."


class RequestGuard:
    """Refuses unknown hosts, foreign pages, websockets without Origin, and writing without the CSRF token.

    Args:
        app: what is protected.
        origins: who may talk to us.
        session_of: looks up the session of raw headers, e.g. ``Sessions.of_headers``.
    """

    def __init__(self, app: ASGIApp, origins: Origins, session_of: SessionOf) -> None:
        self._app = app
        self._origins = origins
        self._session_of = session_of

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the request through or answer it here."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if refusal is None:
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": refusal[2]})
        else:
            await _answer(send, *refusal)

    def _refusal(self, scope: Scope) -> tuple[int, str, str] | None:
        headers: Headers = scope["headers"]
        hosts = _values(headers, b"host")
        if len(hosts) != 1:
            return 400, "bad_host", "The request names no host, or several."
        if not self._origins.is_known_host(hosts[0]):
            return 421, "unknown_host", UNKNOWN_HOST
        origins = _values(headers, b"origin")
        if len(origins) > 1:
            return 400, "bad_origin", FOREIGN_ORIGIN
        origin = origins[0] if origins else None
        is_ours = self._origins.is_allowed(origin, scope["scheme"], hosts[0])
        # The socket of the pages also comes as plain HTTP (polling), where reading needs the Origin just the same.
        if scope["type"] == "websocket" or scope["path"].startswith(_SOCKET_IO):
            return None if is_ours else (403, "foreign_origin", FOREIGN_ORIGIN)
        if scope["method"] in _READING:
            return None
        if origin is not None and not is_ours:
            return 403, "foreign_origin", FOREIGN_ORIGIN
        return self._writing_refusal(scope, headers, has_origin=origin is not None)

    def _writing_refusal(self, scope: Scope, headers: Headers, *, has_origin: bool) -> tuple[int, str, str] | None:
        """Judge a request that changes something and comes from our own page, or from no page."""
        if not any(COOKIE_NAME.encode() in value for name, value in headers if name == b"cookie"):
            return None  # no cookie, so nothing that another page could misuse
        if not scope["path"].startswith(_API):
            return None if has_origin else (403, "foreign_origin", FOREIGN_ORIGIN)
        if (scope["method"], scope["path"]) in _WITHOUT_CSRF and has_origin:
            return None
        if any(value.startswith("Bearer ") for value in _values(headers, b"authorization")):
            return None  # another page cannot add this header
        session = self._session_of(headers)
        if session is None:
            return None  # the handler says that nobody is signed in
        given = _values(headers, CSRF_HEADER.encode())
        if len(given) == 1 and hmac.compare_digest(given[0].encode(), session.csrf.encode()):
            return None
        return 403, "csrf", NO_CSRF


def _values(headers: Headers, name: bytes) -> list[str]:
    return [value.decode("latin-1") for key, value in headers if key == name]


async def _answer(send: Send, status: int, code: str, text: str) -> None:
    body = json.dumps({"code": code, "text": text, "field": None}).encode()
    headers = [
        (b"content-type", b"application/json"),
        (b"content-length", str(len(body)).encode()),
        (b"cache-control", b"no-store"),
        (b"x-content-type-options", b"nosniff"),
    ]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})

"""Where a context broker posts what changed; the outermost door of the console for these alone.

A broker may post a thousand a second. Behind sign-in, page and REST machinery each would cost milliseconds of the
event loop that STOP's second path, commands and live values need; here it costs about what parsing costs.
"""

from __future__ import annotations

from typing import Protocol

from starlette.requests import ClientDisconnect, Request
from starlette.types import ASGIApp, Receive, Scope, Send

PATH = "/api/v1/cloud/notify/"
MOST_BYTES = 1_048_576


class Notified(Protocol):
    """Takes what a broker says."""

    def lets_in(self, secret: str, source: str) -> bool:
        """Say whether a notification with this secret, from this address, is the broker's."""
        ...

    def hint(self, body: bytes, headers: dict[str, str]) -> bool:
        """Take a notification that was let in; ``False`` if it cannot be read or is of another tenant."""
        ...


class CloudNotify:
    """Answers ``POST /api/v1/cloud/notify/SECRET`` and hands everything else on.

    No cookie is read and nothing is shown, so that neither another page nor another name of this machine matters: the
    secret in the path and the broker's address are what lets it in.
    """

    def __init__(self, app: ASGIApp, desk: Notified) -> None:
        self._app, self._desk = app, desk

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http" or scope["method"] != "POST" or not scope["path"].startswith(PATH):
            await self._app(scope, receive, send)
            return
        await send({"type": "http.response.start", "status": await self._taken(scope, receive), "headers": [
            (b"content-length", b"0")]})  # fmt: skip
        await send({"type": "http.response.body", "body": b""})

    async def _taken(self, scope: Scope, receive: Receive) -> int:
        client = scope.get("client")
        if not self._desk.lets_in(scope["path"][len(PATH) :], client[0] if client else ""):
            return 404  # before anything is read
        body = bytearray()
        try:
            async for part in Request(scope, receive).stream():
                body += part
                if len(body) > MOST_BYTES:
                    return 413
        except ClientDisconnect:
            return 400
        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in scope["headers"]}
        return 204 if self._desk.hint(bytes(body), headers) else 400

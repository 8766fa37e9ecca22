"""The server of a process beside the console: loopback, and closed to whoever does not know the secret."""

from __future__ import annotations

import socket

import uvicorn
from starlette.responses import Response
from starlette.types import ASGIApp, Receive, Scope, Send

from hmi.side_door import is_secret

GRACE_S = 1


class SecretDoor:
    """ASGI: lets nobody in without the secret in ``header``; they are answered nothing but 403."""

    def __init__(self, app: ASGIApp, header: str, secret: str) -> None:
        self._app, self._header, self._secret = app, header.encode(), secret

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the request through or answer it here."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        given = dict(scope["headers"]).get(self._header, b"").decode("latin-1")
        if is_secret(given, self._secret):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            await Response(status_code=403)(scope, receive, send)


def loopback_server(app: ASGIApp) -> tuple[socket.socket, uvicorn.Server]:
    """Return a listening socket on a free loopback port, and the server to ``serve(sockets=[...])`` it."""
    config = uvicorn.Config(
        app,
        log_config=None,
        access_log=False,
        server_header=False,
        lifespan="off",
        ws_per_message_deflate=False,
        ws_ping_interval=5.0,
        ws_ping_timeout=5.0,
        timeout_graceful_shutdown=GRACE_S,
    )
    return socket.create_server(("127.0.0.1", 0)), uvicorn.Server(config)

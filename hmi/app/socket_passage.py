"""From a process beside the console to a browser, frame by frame."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator

from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed


async def pass_out(inner: ClientConnection, socket: WebSocket) -> None:
    """Hand on what the process says until one of both leaves."""
    with contextlib.suppress(ConnectionClosed, WebSocketDisconnect, RuntimeError):
        async for said in _frames(inner):
            if isinstance(said, str):
                await socket.send_text(said)
            else:
                await socket.send_bytes(said)


async def _frames(inner: ClientConnection) -> AsyncIterator[str | bytes]:
    async for said in inner:
        yield said

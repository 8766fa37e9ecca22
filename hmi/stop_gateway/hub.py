"""The browsers that are connected, each with a short list of what it still has to be told."""

from __future__ import annotations

import asyncio
import contextlib
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from hmi.stop_gateway.frames import encode

GOING_AWAY = 1012  # "service restart": the browser reconnects at once


class Client:
    """One browser. A newer frame of the same kind replaces the older, so a slow browser costs nothing."""

    def __init__(self, websocket: WebSocket) -> None:
        self._websocket = websocket
        self._waiting: dict[object, str] = {}
        self._more = asyncio.Event()
        self._is_closed = False

    def tell(self, key: object, text: str) -> None:
        """Say ``text``, in place of what is still waiting under the same ``key``."""
        self._waiting.pop(key, None)
        self._waiting[key] = text
        self._more.set()

    def close(self) -> None:
        """Say what is waiting, then close."""
        self._is_closed = True
        self._more.set()

    async def write(self) -> None:
        """Send what is waiting until closed or gone."""
        with contextlib.suppress(WebSocketDisconnect, RuntimeError, OSError):
            while not self._is_closed or self._waiting:
                await self._more.wait()
                self._more.clear()
                while self._waiting:
                    await self._websocket.send_text(self._waiting.pop(next(iter(self._waiting))))
            await self._websocket.close(GOING_AWAY)


class Hub:
    """All browsers; every frame is encoded once."""

    def __init__(self) -> None:
        self._clients: set[Client] = set()

    def __len__(self) -> int:
        return len(self._clients)

    def join(self, client: Client) -> None:
        """Take a browser in."""
        self._clients.add(client)

    def leave(self, client: Client) -> None:
        """Forget a browser."""
        self._clients.discard(client)

    def tell(self, key: object, frame: dict[str, Any]) -> None:
        """Say a frame to everybody."""
        if not self._clients:
            return
        text = encode(frame)
        for client in self._clients:
            client.tell(key, text)

    def steps(self, steps: list[dict[str, Any]]) -> None:
        """Say steps to everybody; of one press at one robot only the newest."""
        for step in steps:
            self.tell((step["stop_id"], step["robot"]), step)

    def close(self) -> None:
        """Send everybody away; they come back when the gateway does."""
        for client in list(self._clients):
            client.close()

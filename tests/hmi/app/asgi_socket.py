"""A websocket spoken to an application without a network."""

from __future__ import annotations

import asyncio
from types import TracebackType
from typing import Any

from starlette.types import ASGIApp, Message


class AsgiSocket:
    """The browser's end; ``code`` is what it was closed with."""

    def __init__(self, app: ASGIApp, path: str, headers: dict[str, str], protocols: list[str] | None = None) -> None:
        self._app, (bare, _, query) = app, path.partition("?")
        self._in: asyncio.Queue[Message] = asyncio.Queue()
        self._out: asyncio.Queue[Message] = asyncio.Queue()
        self._scope: dict[str, Any] = {
            "type": "websocket",
            "scheme": "ws",
            "path": bare,
            "raw_path": bare.encode(),
            "query_string": query.encode(),
            "root_path": "",
            "headers": [(k.encode(), v.encode()) for k, v in {"host": "console.local", **headers}.items()],
            "subprotocols": protocols or [],
        }
        self.code: int | None = None
        self.subprotocol: str | None = None

    async def __aenter__(self) -> AsgiSocket:
        self._in.put_nowait({"type": "websocket.connect"})
        self._task = asyncio.create_task(self._app(self._scope, self._in.get, self._out.put))  # type: ignore[arg-type]
        first = await self.next()
        self.subprotocol = first.get("subprotocol")
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> None:
        self._in.put_nowait({"type": "websocket.disconnect", "code": 1000})
        await asyncio.wait_for(self._task, 5)

    async def next(self) -> Message:
        """Return what the application said next; a close sets ``code``."""
        message = await asyncio.wait_for(self._out.get(), 5)
        if message["type"] == "websocket.close":
            self.code = message.get("code")
        return message

    def say(self, said: str | bytes) -> None:
        """Send a frame."""
        key = "text" if isinstance(said, str) else "bytes"
        self._in.put_nowait({"type": "websocket.receive", key: said})

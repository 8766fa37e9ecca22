"""The console's way to the camera process."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import httpx
import msgspec
from websockets.asyncio.client import ClientConnection

from hmi.app.side_link import SideDown, SideLink
from hmi.cameras.door import NAME, SECRET_HEADER, VIEWER_HEADER, Note, read_note

CamerasDown = SideDown
MOST_QUEUED = 2  # pictures between the two processes: more would only be older


class CameraLink:
    """Speaks to the camera process wherever it listens now; it may restart at any time."""

    def __init__(self, data: Path) -> None:
        self._data = data
        self._link = SideLink(data, NAME, SECRET_HEADER)

    async def close(self) -> None:
        """Close what is open."""
        await self._link.close()

    def pid(self) -> int | None:
        """Return which process is spoken to, ``None`` before its first start."""
        note = read_note(self._data)
        return None if note is None else note.pid

    async def ask(
        self,
        method: str,
        path: str,
        body: Any = None,
        headers: Mapping[str, str] | None = None,
        limit_s: float = 6.0,
    ) -> httpx.Response:
        """Send bytes as they are, anything else as JSON; raises ``CamerasDown``."""
        is_raw = body is None or isinstance(body, bytes)
        content = body if is_raw else msgspec.json.encode(body)
        return await self._link.send(self._note().control_port, method, path, content, limit_s, headers)

    async def live(self, viewer: str) -> ClientConnection:
        """Open the socket of a page; raises ``CamerasDown``."""
        return await self._link.open(self._note().control_port, "/live", {VIEWER_HEADER: viewer}, [], MOST_QUEUED)

    def _note(self) -> Note:
        note = read_note(self._data)
        if note is None:
            raise CamerasDown("it was not started")
        return note

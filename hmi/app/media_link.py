"""The console's way to the media process."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import httpx
import msgspec
from websockets.asyncio.client import ClientConnection

from hmi.app.side_link import SideDown, SideLink
from hmi.media.door import CAPTURED_HEADER, NAME, RIGHTS_HEADER, SECRET_HEADER, VIEWER_HEADER, Note, read_note

MediaDown = SideDown


class MediaLink:
    """Speaks to the media process wherever it listens now; it may restart at any time."""

    def __init__(self, data: Path) -> None:
        self._data = data
        self._link = SideLink(data, NAME, SECRET_HEADER)

    async def close(self) -> None:
        """Close what is open."""
        await self._link.close()

    async def ask(self, method: str, path: str, body: Any = None) -> httpx.Response:
        """Send a request with a value as JSON; raises ``MediaDown``."""
        content = None if body is None else msgspec.json.encode(body)
        return await self._link.send(self._note().control_port, method, path, content)

    async def picture(self, robot_id: str, camera: str, data: bytes, captured_s: float) -> None:
        """Hand a picture over, captured at a time of this machine's monotonic clock; raises ``MediaDown``."""
        headers = {CAPTURED_HEADER: f"{captured_s:.3f}"}
        path = f"/pictures/{robot_id}/{camera}"
        await self._link.send(self._note().control_port, "PUT", path, data, headers=headers)

    async def upload(self, path: str, chunks: AsyncIterator[bytes], limit_s: float) -> httpx.Response:
        """Pass a file on as it comes; raises ``MediaDown``."""
        return await self._link.send(self._note().control_port, "PUT", path, chunks, limit_s)

    async def viser(self, viewer: str, protocols: list[str]) -> ClientConnection:
        """Open the socket of a picture; raises ``MediaDown``."""
        return await self._link.open(self._note().viser_port, "/", {VIEWER_HEADER: viewer}, protocols)

    async def control(self, viewer: str, robot_id: str, rights: str) -> ClientConnection:
        """Open the socket of a page's wishes; raises ``MediaDown``."""
        headers = {VIEWER_HEADER: viewer, RIGHTS_HEADER: rights}
        return await self._link.open(self._note().control_port, f"/viewer?robot={robot_id}", headers, [])

    def _note(self) -> Note:
        note = read_note(self._data)
        if note is None:
            raise MediaDown("it was not started")
        return note

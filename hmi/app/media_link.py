"""The console's way to the media process: loopback, with the secret both know."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from pathlib import Path
from typing import Any

import httpx
import msgspec
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException
from websockets.typing import Subprotocol

from hmi.media.door import RIGHTS_HEADER, SECRET_HEADER, VIEWER_HEADER, Note, read_note, shared_secret

TIMEOUT_S = 3.0
OPEN_S = 3.0
MAX_FRAME_BYTES = 64 * 1024 * 1024  # a first picture with an uploaded model


class MediaDown(Exception):
    """The media process does not answer."""


class MediaLink:
    """Speaks to the media process wherever it listens now; it may restart at any time."""

    def __init__(self, data: Path) -> None:
        self._data = data
        self._secret = ""
        self._http = httpx.AsyncClient(timeout=TIMEOUT_S, trust_env=False)

    async def close(self) -> None:
        """Close what is open."""
        await self._http.aclose()

    async def ask(self, method: str, path: str, body: Any = None) -> httpx.Response:
        """Send a request with a value as JSON; raises ``MediaDown``."""
        content = None if body is None else msgspec.json.encode(body)
        return await self._send(method, path, content, TIMEOUT_S)

    async def upload(self, path: str, chunks: AsyncIterator[bytes], limit_s: float) -> httpx.Response:
        """Pass a file on as it comes; raises ``MediaDown``."""
        return await self._send("PUT", path, chunks, limit_s)

    async def viser(self, viewer: str, protocols: list[str]) -> ClientConnection:
        """Open the socket of a picture; raises ``MediaDown``."""
        url = f"ws://127.0.0.1:{self._note().viser_port}/"
        return await self._open(url, {VIEWER_HEADER: viewer}, protocols)

    async def control(self, viewer: str, robot_id: str, rights: str) -> ClientConnection:
        """Open the socket of a page's wishes; raises ``MediaDown``."""
        url = f"ws://127.0.0.1:{self._note().control_port}/viewer?robot={robot_id}"
        return await self._open(url, {VIEWER_HEADER: viewer, RIGHTS_HEADER: rights}, [])

    async def _send(self, method: str, path: str, content: Any, limit_s: float) -> httpx.Response:
        url = f"http://127.0.0.1:{self._note().control_port}{path}"
        try:
            return await self._http.request(method, url, content=content, headers=self._door(), timeout=limit_s)
        except httpx.HTTPError as error:
            raise MediaDown(str(error) or type(error).__name__) from error

    async def _open(self, url: str, headers: Mapping[str, str], protocols: list[str]) -> ClientConnection:
        try:
            return await connect(
                url,
                additional_headers={**self._door(), **headers},
                subprotocols=[Subprotocol(one) for one in protocols] or None,
                compression=None,
                open_timeout=OPEN_S,
                max_size=MAX_FRAME_BYTES,
                max_queue=8,
                proxy=None,
            )
        except (OSError, TimeoutError, WebSocketException) as error:
            raise MediaDown(str(error) or type(error).__name__) from error

    def _note(self) -> Note:
        note = read_note(self._data)
        if note is None:
            raise MediaDown("it was not started")
        return note

    def _door(self) -> dict[str, str]:
        if not self._secret:
            self._secret = shared_secret(self._data)
        return {SECRET_HEADER: self._secret}

"""The console's way to a process beside it: loopback, with the secret both know."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import httpx
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException
from websockets.typing import Subprotocol

from backend_clients.trust import authorities
from hmi.side_door import shared_secret

TIMEOUT_S = 3.0
OPEN_S = 3.0
IDLE_S = 2.0  # the other side closes after 5 s: a request sent in that moment would be lost
MAX_FRAME_BYTES = 64 * 1024 * 1024  # a first picture of the twin with an uploaded model


class SideDown(Exception):
    """The process does not answer."""


class SideLink:
    """Speaks to a process wherever it listens now; it may restart at any time.

    Args:
        name: of the process, as in ``hmi.side_door``.
        header: the one that carries the secret.
    """

    def __init__(self, data: Path, name: str, header: str) -> None:
        self._data, self._name, self._header = data, name, header
        self._secret = ""
        limits = httpx.Limits(keepalive_expiry=IDLE_S)
        self._http = httpx.AsyncClient(timeout=TIMEOUT_S, trust_env=False, verify=authorities(), limits=limits)

    async def close(self) -> None:
        """Close what is open."""
        await self._http.aclose()

    async def send(
        self,
        port: int,
        method: str,
        path: str,
        content: Any = None,
        limit_s: float = TIMEOUT_S,
        headers: Mapping[str, str] | None = None,
    ) -> httpx.Response:
        """Send a request; raises ``SideDown``."""
        url = f"http://127.0.0.1:{port}{path}"
        door = {**self._door(), **(headers or {})}
        try:
            return await self._http.request(method, url, content=content, headers=door, timeout=limit_s)
        except httpx.HTTPError as error:
            raise SideDown(str(error) or type(error).__name__) from error

    async def open(
        self, port: int, path: str, headers: Mapping[str, str], protocols: list[str], max_queue: int = 8
    ) -> ClientConnection:
        """Open a websocket; raises ``SideDown``."""
        try:
            return await connect(
                f"ws://127.0.0.1:{port}{path}",
                additional_headers={**self._door(), **headers},
                subprotocols=[Subprotocol(one) for one in protocols] or None,
                compression=None,
                open_timeout=OPEN_S,
                max_size=MAX_FRAME_BYTES,
                max_queue=max_queue,
                proxy=None,
            )
        except (OSError, TimeoutError, WebSocketException) as error:
            raise SideDown(str(error) or type(error).__name__) from error

    def _door(self) -> dict[str, str]:
        if not self._secret:
            self._secret = shared_secret(self._data, self._name)
        return {self._header: self._secret}

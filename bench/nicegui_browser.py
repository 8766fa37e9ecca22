"""A browser on a NiceGUI page as its server sees it, for the naive side of benches."""

from __future__ import annotations

import json
import re
import secrets
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import httpx
from websockets.asyncio.client import ClientConnection, connect


class NiceGuiBrowser:
    """One open page: what its socket brings, and clicks on it."""

    def __init__(self, socket: ClientConnection, html: str, client_id: str) -> None:
        self._socket = socket
        self._html = html
        self._client_id = client_id

    async def frames(self) -> AsyncIterator[str]:
        """Yield what the page is told; answers the transport's own questions."""
        async for frame in self._socket:
            text = frame if isinstance(frame, str) else frame.decode()
            if text.startswith("0"):
                await self._socket.send("40")
            elif text == "2":
                await self._socket.send("3")
            else:
                yield text

    async def click(self, element_id: int) -> None:
        """Click an element that has exactly one listener for it."""
        found = re.search(rf'"{element_id}":\{{.*?"listener_id":"([0-9a-f-]{{36}})"', self._html.replace("\\", ""))
        if found is None:
            raise ValueError(f"the page has no listener on element {element_id}")
        event: dict[str, object] = {"id": element_id, "client_id": self._client_id, "listener_id": found[1], "args": []}
        await self._socket.send("42" + json.dumps(["event", event]))


@asynccontextmanager
async def nicegui_browser(port: int) -> AsyncIterator[NiceGuiBrowser]:
    """Open ``/`` of the NiceGUI server on a port of loopback."""
    own = f"http://127.0.0.1:{port}"
    async with httpx.AsyncClient(trust_env=False) as http:
        html = (await http.get(f"{own}/")).text
    client = re.search(r'client_id["\']?\s*[:=]\s*["\']([0-9a-f-]{36})', html)
    if client is None:
        raise ValueError("no client id in the page")
    query = f"client_id={client[1]}&tab_id={secrets.token_hex(8)}&document_id={secrets.token_hex(8)}"
    path = f"_nicegui_ws/socket.io/?EIO=4&transport=websocket&{query}&next_message_id=0&implicit_handshake=true"
    async with connect(f"ws://127.0.0.1:{port}/{path}", origin=own, compression=None) as socket:  # type: ignore[arg-type]
        yield NiceGuiBrowser(socket, html, client[1])

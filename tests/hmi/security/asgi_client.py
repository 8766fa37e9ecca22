"""A client that calls an ASGI application directly, for requests and for the opening of websockets."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from urllib.parse import urlsplit

import httpx
from starlette.types import ASGIApp, Message

Headers = dict[str, str] | Sequence[tuple[str, str]]


class AsgiClient:
    """Talks to ``app`` as if it were served at ``base_url``."""

    def __init__(self, app: ASGIApp, base_url: str) -> None:
        self._app = app
        self._base_url = base_url

    def request(self, method: str, path: str, headers: Headers | None = None) -> httpx.Response:
        """Send one request and return the answer."""

        async def send() -> httpx.Response:
            transport = httpx.ASGITransport(app=self._app)
            async with httpx.AsyncClient(transport=transport, base_url=self._base_url) as client:
                return await client.request(method, path, headers=headers)

        return asyncio.run(send())

    def get(self, path: str, headers: Headers | None = None) -> httpx.Response:
        """Send a GET."""
        return self.request("GET", path, headers)

    def post(self, path: str, headers: Headers | None = None) -> httpx.Response:
        """Send a POST."""
        return self.request("POST", path, headers)

    def opens_websocket(self, path: str, headers: dict[str, str]) -> bool:
        """Say whether a websocket to ``path`` is accepted."""
        url = urlsplit(self._base_url)
        sent: list[Message] = []

        async def receive() -> Message:
            return {"type": "websocket.connect"} if not sent else {"type": "websocket.disconnect", "code": 1000}

        async def send(message: Message) -> None:
            sent.append(message)

        scope = {
            "type": "websocket",
            "asgi": {"version": "3.0"},
            "scheme": "wss" if url.scheme == "https" else "ws",
            "path": path.partition("?")[0],
            "raw_path": path.partition("?")[0].encode(),
            "query_string": path.partition("?")[2].encode(),
            "headers": [(key.encode(), value.encode()) for key, value in ({"host": url.netloc} | headers).items()],
            "subprotocols": [],
        }
        asyncio.run(self._app(scope, receive, send))  # type: ignore[arg-type]
        return sent[0]["type"] == "websocket.accept"

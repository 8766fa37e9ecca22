"""Takes notifications on a port, as a console would."""

from __future__ import annotations

import asyncio

from backend_clients.ngsi.notification import Notification, read_notification


class Receiver:
    """A small HTTP server of its own: what it reads is what the broker wrote.

    Args:
        host: the address at which the broker reaches it.
    """

    def __init__(self, host: str) -> None:
        self._host = host
        self._came: asyncio.Queue[Notification] = asyncio.Queue()
        self.headers: dict[str, str] = {}

    async def __aenter__(self) -> Receiver:
        bind = "127.0.0.1" if self._host == "127.0.0.1" else "0.0.0.0"
        self._server = await asyncio.start_server(self._serve, bind, 0)
        port = self._server.sockets[0].getsockname()[1]
        self.url = f"http://{self._host}:{port}/notify/a-secret-path"
        return self

    async def __aexit__(self, *_error: object) -> None:
        self._server.close()
        await self._server.wait_closed()

    async def next(self) -> Notification:
        """Wait for the next notification."""
        async with asyncio.timeout(5):
            return await self._came.get()

    def waiting(self) -> int:
        """Return how many came and were not read."""
        return self._came.qsize()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")
        self.headers = {n.lower(): v.strip() for n, _, v in (line.partition(":") for line in head[1:]) if n}
        body = await reader.readexactly(int(self.headers["content-length"]))
        self._came.put_nowait(read_notification(body, self.headers))
        writer.write(b"HTTP/1.1 204 No Content\r\nConnection: close\r\n\r\n")
        await writer.drain()
        writer.close()

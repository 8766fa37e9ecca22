"""A console reduced to its lane, on a real socket."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from typing import Any

import uvicorn
from starlette.applications import Starlette
from websockets.asyncio.client import ClientConnection, connect

from hmi.clock import SystemClock
from hmi.domain.freshness import TickRing
from hmi.live.frames import Drive, Here
from hmi.live.hub import LiveHub
from hmi.live.lane import lane_route, same_origin_or
from hmi.security.session_info import SessionInfo
from hmi.store.fleet import FleetStore
from tests.hmi.ingest.wire import Entry
from tests.hmi.live.rig import session

ID = "weeder-01"


class Gate:
    """Sessions that tests open and close."""

    def __init__(self) -> None:
        self.open = {"secret": session()}

    def of_headers(self, headers: Iterable[tuple[bytes, bytes]]) -> SessionInfo | None:
        """Look for the one cookie."""
        cookies = [value.decode() for name, value in headers if name == b"cookie"]
        return next((s for c, s in self.open.items() if f"headland_session={c}" in cookies), None)

    def get(self, session_id: str) -> SessionInfo | None:
        """Look by id."""
        return next((s for s in self.open.values() if s.session_id == session_id), None)


class Site:
    """A console reduced to its lane."""

    def __init__(self, robots: Iterable[str]) -> None:
        clock = SystemClock()
        self.store = FleetStore(clock.mono_s)
        self.store.set_registry([Entry(robot) for robot in robots])
        self.ticks = TickRing("boot1", clock.mono_s, clock.utc)
        self.hub = LiveHub(self.store, self.ticks, clock)
        self.gate = Gate()
        self.heard: list[tuple[str, Here | Drive]] = []
        self.fails = False
        self.port = 0
        route = lane_route(self.hub, self.gate, same_origin_or(["https://farm.example"]), self._hear, clock)
        self.app = Starlette(routes=[route])

    def _hear(self, who: SessionInfo, _lane: str, frame: Here | Drive) -> None:
        if self.fails:
            raise RuntimeError("a fault of the handler")
        self.heard.append((who.user_id, frame))

    def open(
        self, *, cookie: str | None = "secret", origin: str | None = "", patience_s: float = 10, queue: int = 16
    ) -> connect:
        """Return a connection to be opened.

        Args:
            origin: empty means the console's own.
            patience_s: how long the handshake may take.
            queue: frames the client takes from its socket before somebody reads them.
        """
        headers = {"Cookie": f"headland_session={cookie}"} if cookie else {}
        own = f"http://127.0.0.1:{self.port}"
        return connect(
            f"ws://127.0.0.1:{self.port}/live",
            additional_headers=headers,
            origin=own if origin == "" else origin,  # type: ignore[arg-type]
            compression=None,
            open_timeout=patience_s,
            max_queue=queue,
        )


@asynccontextmanager
async def running(robots: Iterable[str] = (ID,)) -> AsyncIterator[Site]:
    """Serve the lane while the block runs."""
    site = Site(robots)
    config = uvicorn.Config(site.app, log_level="error", ws="websockets-sansio", ws_per_message_deflate=False)
    server = uvicorn.Server(config)
    sock = socket.socket()
    sock.bind(("127.0.0.1", 0))
    site.port = sock.getsockname()[1]
    started = asyncio.Event()
    startup = server.startup

    async def tell_startup(sockets: list[socket.socket] | None = None) -> None:
        await startup(sockets)
        started.set()

    server.startup = tell_startup  # type: ignore[method-assign]
    task = asyncio.create_task(server.serve(sockets=[sock]))
    await started.wait()
    await site.hub.start()
    try:
        yield site
    finally:
        await site.hub.stop()
        server.should_exit = True
        await task
        sock.close()


async def frame(ws: ClientConnection, kind: str) -> dict[str, Any]:
    """Return the next frame of a kind."""
    async with asyncio.timeout(5):
        while True:
            found: dict[str, Any] = json.loads(await ws.recv())
            if found["k"] == kind:
                return found

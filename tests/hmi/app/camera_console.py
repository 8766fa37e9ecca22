"""A real camera process, and the console's side of cameras in front of it."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import httpx
from fastapi import FastAPI
from starlette.applications import Starlette

from hmi.api import errors
from hmi.api.access import Access
from hmi.api.cameras import CameraRoutes, camera_routes
from hmi.app.camera_link import CameraLink
from hmi.app.cameras import CameraDesk
from hmi.cameras.door import read_note
from hmi.domain.camera import CameraInfo, Source, SourceKind
from hmi.domain.role import Role
from hmi.ingest.sender import EdgeSender
from hmi.security.authorization import Authorizer
from hmi.security.session_info import SessionInfo
from tests.hmi.app.asgi_socket import AsgiSocket
from tests.hmi.app.people import session_of
from tests.hmi.cameras.fake_camera import TOKEN, FakeCamera

ROOT = Path(__file__).parents[3]
ORIGIN = {"origin": "http://console.local"}
UPLOAD_TOKEN = "token-of-the-field-camera"


@contextmanager
def camera_process(data: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Run ``headland cameras`` as the keeper does."""
    env = {**os.environ, "HEADLAND_DATA": str(data), "HEADLAND_DEMO": "true", "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen([sys.executable, "-m", "hmi.cameras"], env=env, cwd=data, stderr=subprocess.DEVNULL)
    try:
        deadline_s = time.monotonic() + 30
        while (note := read_note(data)) is None or note.pid != process.pid:
            assert process.poll() is None
            assert time.monotonic() < deadline_s
            time.sleep(0.02)
        yield process
    finally:
        process.terminate()
        process.wait(10)


class Gate:
    """One session or none; also what REST asks."""

    def __init__(self, session: SessionInfo | None) -> None:
        self.session = session

    def of_headers(self, _headers: object) -> SessionInfo | None:
        """Return it."""
        return self.session

    def get(self, _session_id: str) -> SessionInfo | None:
        """Return it."""
        return self.session


class CameraConsole:
    """The console's side: sockets and REST for one person."""

    def __init__(self, data: Path, robot: FakeCamera, role: Role | None) -> None:
        self.gate = Gate(None if role is None else session_of(role))
        self.lines: list[Any] = []
        self.holds = False
        self.off = ""
        registered = SimpleNamespace(name="Weeder 01", farm_id="farm")
        elsewhere = SimpleNamespace(name="Other", farm_id="another")
        known = {"weeder-01": registered, "weeder-99": elsewhere}
        self.authorize = Authorizer(known.get)
        front = CameraInfo("front", "Front", 640, 480)
        self.sources = [
            Source("weeder-01", front, SourceKind.ROBOT, robot.url, TOKEN),
            Source("weeder-99", front, SourceKind.ROBOT, robot.url, TOKEN),
            Source("field", CameraInfo("pole", "Pole", 640, 480), SourceKind.UPLOAD),
        ]
        sender = EdgeSender(None, lambda _robot: SimpleNamespace(http_url=robot.url, token=TOKEN))  # type: ignore[arg-type]
        self.desk = CameraDesk(CameraLink(data), lambda: self.sources, self.gate, self.authorize, sender)
        self._sockets = Starlette(routes=self.desk.routes(lambda origin, _host: origin == ORIGIN["origin"]))
        parts = CameraRoutes(self.desk, self.authorize, lambda *_: self.holds, lambda _robot: self.off, self)
        api = FastAPI()
        api.state.access = Access(self.gate, None, self.authorize)  # type: ignore[arg-type]
        api.include_router(camera_routes(parts))
        errors.install(api)
        self.client = httpx.AsyncClient(
            base_url="http://console.local", transport=httpx.ASGITransport(api, raise_app_exceptions=False)
        )

    def append(self, entry: Any) -> None:
        """Take a line of the audit."""
        self.lines.append(entry)

    def socket(self, headers: dict[str, str] = ORIGIN) -> AsgiSocket:
        """Return a page's socket, not yet open."""
        return AsgiSocket(self._sockets, "/cameras/live", headers, [])

    async def status(self) -> dict[str, Any]:
        """Return how the camera process does."""
        found: dict[str, Any] = (await self.desk.link.ask("GET", "/status")).json()
        return found


@asynccontextmanager
async def camera_console(
    data: Path, robot: FakeCamera, role: Role | None = Role.VIEWER
) -> AsyncIterator[CameraConsole]:
    """Make one and end it."""
    console = CameraConsole(data, robot, role)
    try:
        yield console
    finally:
        await console.client.aclose()
        await console.desk.stop()


class LivePage:
    """A page that pings while it is open."""

    def __init__(self, socket: AsgiSocket) -> None:
        self.socket = socket
        self.said: list[dict[str, Any]] = []
        self.pictures: list[bytes] = []
        self.watcher = ""

    def say(self, **frame: Any) -> None:
        """Send a frame."""
        self.socket.say(json.dumps(frame))

    async def read(self) -> dict[str, Any] | bytes:
        """Return the next frame."""
        message = await self.socket.next()
        if message.get("bytes"):
            self.pictures.append(message["bytes"])
            return bytes(message["bytes"])
        frame: dict[str, Any] = json.loads(message.get("text") or "{}")
        self.said.append(frame)
        return frame

    async def until(self, kind: str) -> dict[str, Any]:
        """Return the next frame of a kind."""
        while True:
            frame = await self.read()
            if isinstance(frame, dict) and frame.get("k") == kind:
                return frame

    async def until_pictures(self, count: int) -> None:
        """Wait for so many pictures in all."""
        while len(self.pictures) < count:
            await self.read()


@asynccontextmanager
async def live_page(console: CameraConsole) -> AsyncIterator[LivePage]:
    """Open a page that pings each 0.4 s."""

    async def ping() -> None:
        while True:
            page.say(k="ping", m=1.0)
            await asyncio.sleep(0.4)

    async with console.socket() as socket:
        page = LivePage(socket)
        page.watcher = (await page.until("hello"))["watcher"]
        pinging = asyncio.create_task(ping())
        try:
            yield page
        finally:
            pinging.cancel()

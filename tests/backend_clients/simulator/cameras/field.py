"""A field, cameras over it, and a robot's HTTP without sockets."""

from __future__ import annotations

import asyncio
import io
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from backend_clients.simulator.cameras.observer import Observer
from backend_clients.simulator.cameras.painter import Painter
from backend_clients.simulator.cameras.scene import Box, Ground, Look, Picture, Rows, Scene, Thing
from backend_clients.simulator.cameras.scenery import Scenery
from backend_clients.simulator.cameras.studio import NoPicture
from backend_clients.simulator.cameras.web import CameraWeb
from backend_clients.simulator.http_server import RobotEndpoint, application
from backend_clients.simulator.world import World
from hmi.clock import FakeClock
from tests.backend_clients.simulator.rig import LAT, LON, Rig

NOON = int(datetime(2026, 5, 20, 12, 0, tzinfo=UTC).timestamp() * 1000)
MIDNIGHT = int(datetime(2026, 5, 20, 23, 30, tzinfo=UTC).timestamp() * 1000)
BEARING = math.radians(70)
ROWS = Rows("Sugar beet", 0.5, BEARING, (0.0, 0.0))
FIELD = Scene("field", LAT, LON, [Ground("field", [(-90, -90), (90, -90), (90, 90), (-90, 90)], ROWS)])


def look(camera: str = "front", *, family: str = "weeder", width: int = 640, **more: Any) -> Look:
    """Return a look along the rows from the anchor."""
    shape = {"gimbal": 9 / 16, "head": 9 / 16}.get(camera, 3 / 4)
    usual: dict[str, Any] = {
        "scene": "field",
        "robot": "weeder-01",
        "camera": camera,
        "family": family,
        "width_px": width,
        "height_px": round(width * shape),
        "wall_ms": NOON,
        "x_m": 0.0,
        "y_m": 0.0,
        "theta_rad": BEARING,
        "tilt_rad": -0.32,
    }
    return Look(**{**usual, **more})


def ahead(metres: float, left: float = 0.0) -> tuple[float, float]:
    """Return a place before the machine."""
    cos, sin = math.cos(BEARING), math.sin(BEARING)
    return metres * cos - left * sin, metres * sin + left * cos


def person(metres: float, left: float = 0.0) -> Thing:
    """Return somebody before the machine."""
    return Thing("person", *ahead(metres, left))


def drawn(wanted: Look, scene: Scene = FIELD) -> tuple[NDArray[np.uint8], list[Box]]:
    """Return the picture as it comes out of its JPEG, shape (height, width, 3), and what was found in it."""
    painter = Painter()
    painter.keep(scene)
    picture = painter.draw(1, wanted)
    assert not picture.problem
    return opened(picture.jpeg), picture.boxes


def opened(jpeg: bytes) -> NDArray[np.uint8]:
    """Return the pixels of a JPEG."""
    return np.asarray(Image.open(io.BytesIO(jpeg)).convert("RGB"))


@dataclass
class Desk:
    """Draws in this process and counts."""

    painter: Painter = field(default_factory=Painter)
    many: int = 0
    looks: list[Look] = field(default_factory=list)

    async def picture(self, take: Callable[[], tuple[Look, Callable[[], Scene]]]) -> Picture:
        """See ``Studio.picture``."""
        wanted, make_scene = take()
        self.many += 1
        self.looks.append(wanted)
        self.painter.keep(make_scene())
        found = self.painter.draw(self.many, wanted)
        if found.problem:
            raise NoPicture(found.problem)
        return found

    async def close(self) -> None:
        """See ``Studio.close``."""


class Site:
    """One robot behind its HTTP, its cameras drawn by a ``Desk``."""

    def __init__(self, **config: Any) -> None:
        self.rig = Rig(**config)
        self.desk = Desk()
        world = World([], self.rig.clock)
        world.robots["weeder-01"] = self.rig.robot
        observer = Observer(world.robots, self.rig.clock, Scenery())
        self.web = CameraWeb(observer, self.desk)  # type: ignore[arg-type]
        self.app = application(RobotEndpoint(world, lambda _robot, _ack: None, self.web), [])

    async def ask(self, path: str, *, method: str = "GET", body: bytes = b"", token: str = "secret") -> Answer:
        """Return a whole answer."""
        answer = Answer()
        await self.app(_scope(path, method, token), _receiver(body), answer.take)
        return answer

    async def pull(self, path: str, parts: int) -> list[Part]:
        """Return so many parts of a stream, then hang up."""
        pull = Pull(self, path)
        try:
            return [await pull.next() for _ in range(parts)]
        finally:
            await pull.hang_up()


@dataclass(frozen=True)
class Part:
    """One part of a stream."""

    head: Mapping[str, str]
    jpeg: bytes


class Answer:
    """What a server sent."""

    def __init__(self) -> None:
        self.status, self.headers, self.body = 0, dict[str, str](), b""

    async def take(self, message: Any) -> None:
        """Take one ASGI message."""
        if message["type"] == "http.response.start":
            self.status = message["status"]
            self.headers = {k.decode(): v.decode() for k, v in message["headers"]}
        elif message["type"] == "http.response.body":
            self.body += message.get("body", b"")


class Pull:
    """Somebody who fetches a stream part by part."""

    def __init__(self, site: Site, path: str) -> None:
        self._answer, self._gone = Answer(), asyncio.Event()
        self._task = asyncio.create_task(self._run(site, path))

    async def _run(self, site: Site, path: str) -> None:
        async def receive() -> Any:
            await self._gone.wait()
            return {"type": "http.disconnect"}

        await site.app(_scope(path, "GET", "secret"), receive, self._answer.take)

    @property
    def is_over(self) -> bool:
        """Whether the server ended it."""
        return self._task.done()

    @property
    def status(self) -> int:
        """Of the answer."""
        return self._answer.status

    async def next(self, patience: int = 400) -> Part:
        """Return the next part; gives up where nothing comes."""
        for _ in range(patience):
            found = self._part()
            if found is not None:
                return found
            await asyncio.sleep(0.005)
        raise TimeoutError("no part came")

    async def is_silent(self) -> bool:
        """Say whether nothing comes though the connection stands."""
        self._answer.body = b""
        for _ in range(60):
            await asyncio.sleep(0.005)
        return not self._answer.body and not self._task.done()

    async def hang_up(self) -> None:
        """Leave."""
        self._gone.set()
        self._task.cancel()
        await asyncio.gather(self._task, return_exceptions=True)

    def _part(self) -> Part | None:
        body = self._answer.body
        begin, end = body.find(b"--frame\r\n"), body.find(b"\r\n\r\n")
        if begin < 0 or end < 0:
            return None
        lines = body[begin:end].decode("ascii").split("\r\n")[1:]
        head = dict(line.split(": ", 1) for line in lines)
        size = int(head["Content-Length"])
        if len(body) < end + 4 + size:
            return None
        self._answer.body = body[end + 4 + size + 2 :]
        return Part(head, body[end + 4 : end + 4 + size])


def _scope(path: str, method: str, token: str) -> dict[str, Any]:
    address, _, query = path.partition("?")
    return {
        "type": "http", "asgi": {"version": "3.0", "spec_version": "2.4"}, "http_version": "1.1", "method": method,
        "path": f"/weeder-01/{address}", "raw_path": b"", "query_string": query.encode(), "scheme": "http",
        "headers": [(b"authorization", f"Bearer {token}".encode())], "server": ("robot", 80), "client": ("test", 1),
    }  # fmt: skip


def _receiver(body: bytes) -> Callable[[], Any]:
    async def receive() -> Any:
        return {"type": "http.request", "body": body, "more_body": False}

    return receive


__all__ = ["FIELD", "MIDNIGHT", "NOON", "ROWS", "FakeClock", "Part", "Pull", "Site", "ahead", "drawn", "look", "person"]

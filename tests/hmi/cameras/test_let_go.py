"""Whoever looks while a camera is being let go of: it runs on, and ends with the last viewer as ever."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest

from hmi.cameras import camera as camera_module
from hmi.cameras.camera import Camera
from hmi.cameras.demand import Way, Wish
from hmi.cameras.picture_wire import Kind, Order, Piece, Plan
from hmi.clock import SystemClock, mono_s
from hmi.domain.camera import CameraInfo, Source
from tests.hmi.cameras.waiting import until

SOURCE = Source("weeder-01", CameraInfo("front", "Front", 640, 480))


class Worker:
    """Sends pictures until it is let go of; it has ended when the test says so."""

    pid = 1
    may_end = asyncio.Event()
    made: list[Worker]

    def __init__(self) -> None:
        self.is_let_go = asyncio.Event()
        self.made.append(self)

    @classmethod
    async def start(cls, _source: Source, _plan: Plan, _mark: str) -> Worker:
        """See ``WorkerProcess``."""
        return cls()

    async def messages(self) -> AsyncIterator[Piece]:
        """See ``WorkerProcess``."""
        while not self.is_let_go.is_set():
            yield Piece(Kind.JPEG, b"x", mono_s() * 1000, 1, 640, 480)
            await asyncio.sleep(0.01)

    def order(self, order: Order) -> None:
        """See ``WorkerProcess``."""

    def let_go(self) -> None:
        """See ``WorkerProcess``."""
        self.is_let_go.set()

    def kill(self) -> None:
        """See ``WorkerProcess``."""

    async def end(self) -> str:
        """See ``WorkerProcess``."""
        await self.may_end.wait()
        return ""


class Viewer:
    """Looks."""

    wish, is_person = Wish(Way.JPEG), True

    def take(self, piece: Piece) -> None:
        """See ``Watch``."""


async def test_who_looks_while_the_worker_ends_gets_another_and_it_ends_with_the_last_viewer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(camera_module, "WorkerProcess", Worker)
    monkeypatch.setattr(camera_module, "LINGER_S", 0.0)
    monkeypatch.setattr(camera_module, "TICK_S", 0.01)
    monkeypatch.setattr(Worker, "made", [], raising=False)
    monkeypatch.setattr(Worker, "may_end", asyncio.Event())
    camera, first, second = Camera(SOURCE, SystemClock(), 1280), Viewer(), Viewer()
    camera.join(first)
    await until(lambda: camera.state == "live")
    camera.leave(first)
    await until(Worker.made[0].is_let_go.is_set)
    camera.join(second)
    Worker.may_end.set()
    await until(lambda: len(Worker.made) == 2 and camera.state == "live")
    assert (camera.reason, camera.restarts) == ("", 0)
    camera.leave(second)
    await until(lambda: camera.pulled_width is None, 5.0)
    assert (camera.state, camera.restarts) == ("idle", 0)
    await camera.end()

"""Starts a camera's worker from the zygote and reads what it hands over."""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import signal
import socket
from collections.abc import AsyncIterator
from multiprocessing.context import ForkServerProcess

import msgspec

from hmi.cameras.picture_wire import (
    HEAD,
    MAX_PAYLOAD_BYTES,
    Kind,
    News,
    Order,
    Piece,
    Plan,
    news_decoder,
    pack_order,
    unpack_piece,
)
from hmi.domain.camera import Source

PRELOADED = [
    "hmi.cameras.worker_process", "hmi.cameras.worker", "hmi.cameras.pull_rtsp", "hmi.cameras.clip",
    "httpcore", "certifi",  # httpx loads them with its first request, which somebody would wait for
]  # fmt: skip
END_S = 1.0
BUFFER_BYTES = 1024 * 1024
context = multiprocessing.get_context("forkserver")


def start_zygote() -> None:
    """Start the small process that workers are forked from; it has everything imported. Blocks for a moment."""
    context.set_forkserver_preload(PRELOADED)
    from multiprocessing import forkserver

    forkserver.ensure_running()


def zygote_is_ready() -> None:
    """Return when it forks without delay; blocks until then."""
    first = context.Process(target=_nothing, name="first", daemon=True)
    first.start()
    first.join()
    first.close()


class WorkerProcess:
    """One worker while it lives."""

    def __init__(self, process: ForkServerProcess, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._process, self._reader, self._writer = process, reader, writer

    @classmethod
    async def start(cls, source: Source, plan: Plan, mark: str = "") -> WorkerProcess:
        """Fork a worker for ``source``; raises ``OSError``. ``mark`` is what the last one told in its news."""
        ours, theirs = socket.socketpair()
        try:
            process = await asyncio.to_thread(_fork, source, plan, theirs, mark)
        except BaseException:
            ours.close()  # a worker that was forked all the same ends with it
            raise
        reader, writer = await asyncio.open_unix_connection(sock=ours, limit=BUFFER_BYTES)
        return cls(process, reader, writer)

    @property
    def pid(self) -> int | None:
        """Its process id."""
        return self._process.pid

    def order(self, order: Order) -> None:
        """Tell it something; lost if it ended."""
        with contextlib.suppress(OSError, RuntimeError):
            self._writer.write(pack_order(order))

    async def messages(self) -> AsyncIterator[Piece | News]:
        """Yield what it hands over until it ends; garbage ends it."""
        while True:
            try:
                head = await self._reader.readexactly(HEAD.size)
                length = HEAD.unpack(head)[-1]
                if length > MAX_PAYLOAD_BYTES:
                    return
                data = await self._reader.readexactly(length)
                yield news_decoder.decode(data) if head[0] == Kind.NEWS else unpack_piece(head, data)
            except (asyncio.IncompleteReadError, ConnectionError, ValueError, msgspec.MsgspecError):
                return

    def let_go(self) -> None:
        """It ends when its socket does, and ``messages`` with it."""
        self._writer.close()

    async def end(self) -> str:
        """Let go of it; return how it ended in words, empty if in order."""
        self.let_go()
        return await asyncio.to_thread(_join, self._process)

    def kill(self) -> None:
        """End it at once."""
        with contextlib.suppress(ValueError):  # ended and closed already
            self._process.kill()


def _nothing() -> None:
    """Run in the first fork."""


def _work(source_json: bytes, plan_json: bytes, link: socket.socket, mark: str) -> None:
    """Run in the fork. The camera process has no decoder, and loads none: half a second that a first viewer waits."""
    from hmi.cameras.worker import run_worker

    run_worker(source_json, plan_json, link, mark)


def _fork(source: Source, plan: Plan, theirs: socket.socket, mark: str) -> ForkServerProcess:
    arguments = (msgspec.json.encode(source), msgspec.json.encode(plan), theirs, mark)
    process = context.Process(target=_work, args=arguments, name=source.name, daemon=True)
    with theirs:  # closed here and not by who waits: the zygote would be handed a file that is no more
        process.start()
    return process


def _join(process: ForkServerProcess) -> str:
    process.join(END_S)
    if process.exitcode is None:
        process.kill()
        process.join(END_S)
    code = process.exitcode
    with contextlib.suppress(ValueError):
        process.close()
    if code is None or code == 0:
        return ""
    return f"its decoder crashed ({signal.Signals(-code).name})" if code < 0 else "its decoder failed"

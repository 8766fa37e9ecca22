"""The way to the drawing process: started with the first picture, ended when nobody asked for one for a while."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import Callable
from pathlib import Path

import msgspec

from backend_clients.simulator.cameras.scene import Look, Order, Picture, Scene

IDLE_S = 300.0  # starting again takes seconds, waiting no processor
WAIT_S = 20.0  # a cold start on a busy machine makes its textures first
AT_ONCE = 2  # one is drawn, the next waits; a longer queue would only make pictures old
MOST_BYTES = 16_000_000
ROOT = Path(__file__).parents[3]


class NoPicture(RuntimeError):
    """The drawing process gave no picture."""


class Studio:
    """Owns the drawing process. Everything runs on the simulator's loop.

    Args:
        idle_s: it ends so long after the last picture.
    """

    def __init__(self, *, idle_s: float = IDLE_S) -> None:
        self._idle_s = idle_s
        self._process: asyncio.subprocess.Process | None = None
        self._reading: asyncio.Task[None] | None = None
        self._resting: asyncio.TimerHandle | None = None
        self._waiting: dict[int, asyncio.Future[Picture]] = {}
        self._known: set[str] = set()
        self._starting = asyncio.Lock()
        self._turn = asyncio.Semaphore(AT_ONCE)
        self._number = 0
        self.starts = 0

    @property
    def is_running(self) -> bool:
        """Whether the drawing process lives."""
        return self._process is not None and self._process.returncode is None

    @property
    def pid(self) -> int | None:
        """Its process, while it lives."""
        return self._process.pid if self._process is not None else None

    async def picture(self, take: Callable[[], tuple[Look, Callable[[], Scene]]]) -> Picture:
        """Return the picture of a look; ``take`` is called when its turn has come, so that the look is fresh.

        Raises:
            NoPicture: it could not be drawn.
        """
        async with self._turn:
            process = await self._running()
            look, make_scene = take()
            self._number += 1
            number = self._number
            scene = None if look.scene in self._known else make_scene()
            self._known.add(look.scene)
            waiting = self._waiting[number] = asyncio.get_running_loop().create_future()
            try:
                self._send(process, Order(number, scene, look))
                async with asyncio.timeout(WAIT_S):
                    picture: Picture = await waiting
            except (TimeoutError, OSError) as problem:
                self._end()
                raise NoPicture("The camera does not answer.") from problem
            finally:
                self._waiting.pop(number, None)
                self._rest()
        if picture.problem:
            self._known.discard(look.scene)
            raise NoPicture(picture.problem)
        return picture

    async def close(self) -> None:
        """End the drawing process."""
        if self._resting is not None:
            self._resting.cancel()
        process, reading = self._process, self._reading
        self._end()
        if reading is not None:
            await asyncio.gather(reading, return_exceptions=True)
        if process is not None:
            with contextlib.suppress(TimeoutError, ProcessLookupError):
                async with asyncio.timeout(1.0):
                    await process.wait()

    def _send(self, process: asyncio.subprocess.Process, order: Order) -> None:
        assert process.stdin is not None
        body = msgspec.msgpack.encode(order)
        process.stdin.write(len(body).to_bytes(4, "little") + body)

    async def _running(self) -> asyncio.subprocess.Process:
        async with self._starting:
            if self._process is not None and self._process.returncode is None:
                return self._process
            self._known.clear()
            self._process = await asyncio.create_subprocess_exec(
                sys.executable, "-m", "backend_clients.simulator.cameras",
                stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, cwd=ROOT, env=environment(),
                start_new_session=True,
            )  # fmt: skip
            self.starts += 1
            self._reading = asyncio.create_task(self._read(self._process), name="camera-pictures")
            return self._process

    async def _read(self, process: asyncio.subprocess.Process) -> None:
        decoder = msgspec.msgpack.Decoder(Picture)
        assert process.stdout is not None
        try:
            while True:
                size = int.from_bytes(await process.stdout.readexactly(4), "little")
                if size > MOST_BYTES:
                    break
                picture = decoder.decode(await process.stdout.readexactly(size))
                waiting = self._waiting.get(picture.number)
                if waiting is not None and not waiting.done():
                    waiting.set_result(picture)
        except (asyncio.IncompleteReadError, msgspec.DecodeError, OSError):
            pass
        finally:
            if process is self._process:
                self._end()

    def _rest(self) -> None:
        if self._resting is not None:
            self._resting.cancel()
        self._resting = asyncio.get_running_loop().call_later(self._idle_s, self._end_if_idle)

    def _end_if_idle(self) -> None:
        if not self._waiting:
            self._end()

    def _end(self) -> None:
        process, self._process = self._process, None
        self._known.clear()
        for waiting in self._waiting.values():
            if not waiting.done():
                waiting.set_exception(NoPicture("The camera's process ended."))
        if process is not None and process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                process.kill()


def environment() -> dict[str, str]:
    """Return its environment: one thread, for pictures must not take the robots' core, and memory that is kept.

    Without the latter glibc gives each large array back to the kernel, which cost a third of a picture.
    """
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    kept = {"MALLOC_MMAP_THRESHOLD_": str(1 << 28), "MALLOC_TRIM_THRESHOLD_": str(1 << 28)}
    return {**os.environ, **one, **kept}

"""One process beside this one for computing that takes seconds."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


class SideProcessDied(Exception):
    """The process ended before its work was done."""


class SideProcess:
    """Runs picklable functions one after another; starts with the first, ends with ``close``."""

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None

    async def run(self, work: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Return what ``work`` returned or raise what it raised; cancelling kills the process.

        Raises:
            SideProcessDied: it was killed or ran out of memory.
        """
        if kwargs:
            raise TypeError("work takes positional arguments only")
        if self._pool is None:
            # spawned, not forked: the parent has threads and sockets that must not be copied
            self._pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_leave_signals_alone)
        try:
            return await asyncio.get_running_loop().run_in_executor(self._pool, work, *args)
        except BrokenProcessPool as error:
            self._pool = None
            raise SideProcessDied(str(error)) from error
        except asyncio.CancelledError:
            await asyncio.shield(asyncio.to_thread(self.close))
            raise

    def close(self) -> None:
        """End the process now; work at hand is given up. Blocks for a moment."""
        pool, self._pool = self._pool, None
        if pool is None:
            return
        # there is no public way to end the processes of a pool without waiting for their work
        processes = list((pool._processes or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.kill()
        for process in processes:
            process.join(1.0)


def _leave_signals_alone() -> None:
    """Ctrl+C reaches the whole process group; the parent ends this process itself."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

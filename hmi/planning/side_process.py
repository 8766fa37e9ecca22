"""One process beside this one for computing that takes seconds."""

from __future__ import annotations

import asyncio
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
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
            self._pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_live_with_the_parent)
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


def limit_memory(memory_bytes: int) -> None:
    """Bound the address space of this process where the system can (setrlimit, POSIX.1-2017)."""
    try:
        import resource
    except ImportError:
        return  # Windows; time and size are bounded there
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    most = memory_bytes if hard == resource.RLIM_INFINITY else min(memory_bytes, hard)
    resource.setrlimit(resource.RLIMIT_AS, (most, hard))


def _live_with_the_parent() -> None:
    """End when the parent does, and only then."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C reaches the whole process group
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent,), daemon=True, name="parent-watch").start()


def _end_after(parent: BaseProcess) -> None:
    parent.join()  # a parent that was killed cannot end us
    os._exit(1)

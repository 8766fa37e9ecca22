"""Planning in a process of its own: seconds of geometry must not hold up the event loop.

The process starts with the first plan and is replaced when a plan takes too long or kills it.
"""

from __future__ import annotations

import asyncio
import signal
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

from hmi.domain.mission_plan import PlannedMission, PlanRefused, PlanWish
from hmi.planning.mission import plan_mission

PLAN_LIMIT_S = 60.0  # a hundred hectares with ten holes at half a metre take less
WAITING_LIMIT = 8  # plans that may wait for the one at work


class PlanningProcess:
    """Plans one mission at a time. Close it: the process does not end by itself.

    Args:
        limit_s: a plan that takes longer is given up.
    """

    def __init__(self, limit_s: float = PLAN_LIMIT_S) -> None:
        self._limit_s = limit_s
        self._pool: ProcessPoolExecutor | None = None
        self._waiting = 0
        self._turn = asyncio.Lock()

    async def plan(self, wish: PlanWish) -> PlannedMission:
        """Return the plan.

        Raises:
            PlanRefused: it cannot be planned, took too long, or too many are waiting.
        """
        if self._waiting >= WAITING_LIMIT:
            raise PlanRefused("busy", "The planner is busy. Try again in a minute.")
        self._waiting += 1
        try:
            async with self._turn:
                return await self._plan(wish)
        finally:
            self._waiting -= 1

    def close(self) -> None:
        """End the process; a plan at work is given up."""
        pool, self._pool = self._pool, None
        if pool is None:
            return
        processes = list((pool._processes or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.kill()
        for process in processes:
            process.join(1.0)

    async def _plan(self, wish: PlanWish) -> PlannedMission:
        if self._pool is None:
            # spawned, not forked: the console has threads and sockets that must not be copied
            self._pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_leave_signals_alone)
        loop = asyncio.get_running_loop()
        try:
            work = loop.run_in_executor(self._pool, plan_mission, wish)
            return await asyncio.wait_for(work, self._limit_s)
        except TimeoutError as error:
            await asyncio.to_thread(self.close)
            text = f"Planning took more than {self._limit_s:.0f} s. Choose a larger row distance or a smaller field."
            raise PlanRefused("too_long", text, "width_m") from error
        except BrokenProcessPool as error:
            self._pool = None
            raise PlanRefused("planner_failed", "The planner ended unexpectedly. Try again.") from error
        except asyncio.CancelledError:
            await asyncio.to_thread(self.close)
            raise


def _leave_signals_alone() -> None:
    """Ctrl+C reaches the whole process group; the console ends this process itself."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

"""Planning in a process of its own: seconds of geometry must not hold up the event loop."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

from hmi.domain.mission_plan import Candidate, PlannedMission, PlanRefused, PlanWish, Tell, nobody
from hmi.domain.mission_rest import PlannedRest, RestWish
from hmi.planning import jobs
from hmi.planning.progress_note import read_progress
from hmi.planning.side_process import SideProcess, SideProcessDied

PLAN_LIMIT_S = 60.0  # a hundred hectares with ten holes at half a metre take less
PROGRESS_S = 0.2
WAITING_LIMIT = 8  # plans that may wait for the one at work


W = ParamSpec("W")
P = TypeVar("P")


class PlanningProcess:
    """Plans one mission at a time; a ``Planner`` and a ``RestPlanner``. Close it: the process does not end by itself.

    Args:
        limit_s: a plan that takes longer is given up.
    """

    def __init__(self, limit_s: float = PLAN_LIMIT_S) -> None:
        self._limit_s = limit_s
        self._process = SideProcess()
        self._waiting = 0
        self._turn = asyncio.Lock()

    async def plan(self, wish: PlanWish, tell: Tell = nobody) -> PlannedMission:
        """Return the plan; ``tell`` hears on this loop how far it is.

        Raises:
            PlanRefused: it cannot be planned, took too long, or too many are waiting.
        """
        return await self._told(jobs.mission, wish, tell)

    async def rest(self, wish: RestWish) -> PlannedRest:
        """Return the new rest of a mission; raises as ``plan``."""
        return await self.run(jobs.rest, wish)

    async def candidate(self, wish: PlanWish, tell: Tell = nobody) -> Candidate:
        """Return the plan to look at; as ``plan``, and cancelling it frees the process."""
        return await self._told(jobs.candidate, wish, tell)

    async def run(self, work: Callable[W, P], *given: W.args, **named: W.kwargs) -> P:
        """Return what other work of planning returns; raises as ``plan``, and what the work raises."""
        if self._waiting >= WAITING_LIMIT:
            raise PlanRefused("busy", "The planner is busy. Try again in a minute.")
        self._waiting += 1
        try:
            async with self._turn, asyncio.timeout(self._limit_s):
                return await self._process.run(work, *given, **named)
        except TimeoutError as error:
            text = f"Planning took more than {self._limit_s:.0f} s. Choose a larger row distance or a smaller field."
            raise PlanRefused("too_long", text, "width_m") from error
        except SideProcessDied as error:
            raise PlanRefused("planner_failed", "The planner ended unexpectedly. Try again.") from error
        finally:
            self._waiting -= 1

    async def _told(self, work: Callable[[PlanWish, str], P], wish: PlanWish, tell: Tell) -> P:
        if self._turn.locked():
            tell(0.0, "Waiting for the plan before")
        with tempfile.TemporaryDirectory(prefix="headland-plan-") as folder:
            note = Path(folder) / "progress"
            note.touch()
            watch = asyncio.create_task(_watch(note, tell), name="plan-progress")
            try:
                return await self.run(work, wish, str(note))
            finally:
                watch.cancel()
                await asyncio.wait({watch})

    def close(self) -> None:
        """End the process; a plan at work is given up. Blocks for a moment."""
        self._process.close()


async def _watch(note: Path, tell: Tell) -> None:
    """Tell how far a plan is, whenever that changed."""
    told = (0.0, "")
    while True:
        await asyncio.sleep(PROGRESS_S)
        now = read_progress(note)
        if now[0] > told[0]:
            told = now
            tell(*told)

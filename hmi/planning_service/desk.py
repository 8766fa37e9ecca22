"""The service's plans: taken in, planned one after another in a worker process, kept for a while, given up."""

from __future__ import annotations

import asyncio
import logging
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from backend_clients.planner.messages import PlannerName, PlanPath, PlanReport, PlanRequest, PlanState, Problem
from hmi import __version__
from hmi.domain.ids import new_id
from hmi.domain.mission_plan import PlanRefused
from hmi.planning.progress_note import read_progress
from hmi.planning.side_process import SideProcess, SideProcessDied
from hmi.planning_service.work import planned

PLAN_LIMIT_S = 60.0  # as the console's own planner
WAITING_LIMIT = 8
KEPT, KEPT_S = 32, 600.0  # plans that are done, until they are fetched or given up
BUSY_AGAIN_S = 10
ENDS = (PlanState.DONE, PlanState.FAILED, PlanState.CANCELLED)
NAME = PlannerName(name="Headland", version=__version__)
log = logging.getLogger(__name__)


class DeskRefused(Exception):
    """A request that is not taken.

    Args:
        status: HTTP status.
        code, text: for programs and for people.
    """

    def __init__(self, status: int, code: str, text: str) -> None:
        super().__init__(text)
        self.status, self.code, self.text = status, code, text


@dataclass(slots=True)
class _Plan:
    id: str
    sha256: str
    request: PlanRequest
    note: Path
    state: PlanState = PlanState.QUEUED
    result: PlanPath | None = None
    problem: Problem | None = None
    ended_s: float | None = None
    task: asyncio.Task[None] | None = field(default=None, repr=False)


class PlanDesk:
    """Plans of one service. Close it.

    Args:
        limit_s: a plan that takes longer is given up.
        delay_s: each plan waits so long first, for tests of slow services.
        mono_s: monotonic clock, seconds.
        process: where plans are made, instead of one of its own.
    """

    def __init__(
        self,
        limit_s: float = PLAN_LIMIT_S,
        *,
        delay_s: float = 0.0,
        mono_s: Callable[[], float] = time.monotonic,
        process: SideProcess | None = None,
    ) -> None:
        self._limit_s, self._delay_s, self._mono_s = limit_s, delay_s, mono_s
        self._process = process or SideProcess()
        self._turn = asyncio.Lock()
        self._plans: dict[str, _Plan] = {}
        self._folder = tempfile.TemporaryDirectory(prefix="headland-planner-")

    @property
    def waiting(self) -> int:
        """How many plans are not done yet."""
        return sum(one.state not in ENDS for one in self._plans.values())

    def submit(self, request: PlanRequest, key: str | None) -> PlanReport:
        """Take a wish in; with a key that is known already, return its plan.

        Raises:
            DeskRefused: the key belongs to another wish, or too many plans wait.
        """
        self._forget()
        known = self._plans.get(key) if key else None
        if known is not None:
            if known.sha256 != request.wish_sha256:
                raise DeskRefused(409, "other_wish", "This key belongs to another wish.")
            return self._report(known)
        if self.waiting >= WAITING_LIMIT:
            raise DeskRefused(429, "busy", "Too many plans wait. Try again later.")
        plan_id = key or new_id()
        note = Path(self._folder.name) / new_id()
        note.touch()
        plan = self._plans[plan_id] = _Plan(plan_id, request.wish_sha256, request, note)
        plan.task = asyncio.create_task(self._work(plan), name=f"plan {plan_id}")
        return self._report(plan)

    def report(self, plan_id: str) -> PlanReport:
        """Return how far a plan is; raises ``DeskRefused``."""
        self._forget()
        return self._report(self._known(plan_id))

    def give_up(self, plan_id: str) -> None:
        """End a plan and forget it; raises ``DeskRefused``."""
        plan = self._known(plan_id)
        del self._plans[plan_id]
        if plan.task is not None:
            plan.task.cancel()

    async def close(self) -> None:
        """Give everything up and end the worker."""
        tasks = [one.task for one in self._plans.values() if one.task is not None]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await asyncio.to_thread(self._process.close)
        self._folder.cleanup()

    def _known(self, plan_id: str) -> _Plan:
        plan = self._plans.get(plan_id)
        if plan is None:
            raise DeskRefused(404, "no_plan", "There is no such plan, or not any more.")
        return plan

    def _report(self, plan: _Plan) -> PlanReport:
        share, words = {
            PlanState.QUEUED: (0.0, "Waiting"),
            PlanState.DONE: (1.0, "Done"),
            PlanState.FAILED: (1.0, "Failed"),
        }.get(plan.state) or read_progress(plan.note)
        return PlanReport(
            id=plan.id,
            wish_sha256=plan.sha256,
            state=plan.state,
            progress=share,
            words=words,
            result=plan.result,
            problem=plan.problem,
        )

    def _forget(self) -> None:
        """Let old plans go, the oldest first."""
        now_s = self._mono_s()
        ended = [one for one in self._plans.values() if one.ended_s is not None]
        old = [one for one in ended if one.ended_s is not None and now_s - one.ended_s > KEPT_S]
        for plan in {one.id: one for one in [*old, *ended[: max(0, len(ended) - KEPT)]]}.values():
            del self._plans[plan.id]

    async def _work(self, plan: _Plan) -> None:
        try:
            async with self._turn:
                plan.state = PlanState.RUNNING
                await asyncio.sleep(self._delay_s)
                form = plan.request.wish.model_dump_json().encode()
                async with asyncio.timeout(self._limit_s):
                    path = await self._process.run(planned, form, str(plan.note))
            plan.result, plan.state = PlanPath.model_validate_json(path), PlanState.DONE
        except PlanRefused as refused:
            self._fail(plan, Problem(code=refused.code, text=refused.text[:400], field=refused.field))
        except TimeoutError:
            self._fail(plan, Problem(code="too_long", text=f"Planning took more than {self._limit_s:.0f} s."))
        except (SideProcessDied, MemoryError):
            self._fail(plan, Problem(code="planner_failed", text="The planner ended unexpectedly. Try again."))
        except Exception:  # whatever a wish from outside does, the service goes on
            log.exception("a plan failed")
            self._fail(plan, Problem(code="planner_failed", text="The planner cannot plan this wish."))
        except asyncio.CancelledError:
            plan.state = PlanState.CANCELLED
            raise
        finally:
            plan.ended_s = self._mono_s()
            plan.note.unlink(missing_ok=True)

    def _fail(self, plan: _Plan, problem: Problem) -> None:
        plan.problem, plan.state = problem, PlanState.FAILED

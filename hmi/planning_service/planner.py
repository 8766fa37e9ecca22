"""The console's planner where a service is set: asks it, checks what comes, and plans here where that fails."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from pydantic import ValidationError

from backend_clients.planner.client import PlanFailed, PlannerClient, TooSlow
from backend_clients.service.errors import BadRequest, NoAnswer, ServiceError, Unreadable
from hmi.clock import Clock
from hmi.domain.ids import new_id
from hmi.domain.mission_plan import Candidate, PathUnfit, PlannedMission, PlanWish, Tell, nobody
from hmi.planning import jobs
from hmi.planning.worker import PlanningProcess
from hmi.planning_service.form import form_of
from hmi.planning_service.place import P, made_here, made_there
from hmi.service_link import LinkState, ServiceLink, state_of

Given = Callable[[PlanWish, list[dict[str, Any]], list[str]], P]
MAX_WHY = 200
CHECKING = "Checking the plan"


class ServicePlanner:
    """A ``Planner``. What it returns says in its statistics, as ``planned_at``, where it was made and why not there.

    Args:
        local: plans here, and checks what the service planned.
        link: whether the service may be asked now.
    """

    def __init__(self, local: PlanningProcess, client: PlannerClient, link: ServiceLink, clock: Clock) -> None:
        self._local, self._client, self._link, self._clock = local, client, link, clock

    async def candidate(self, wish: PlanWish, tell: Tell = nobody) -> Candidate:
        """See ``Planner``; cancelling cancels at the service, too."""
        return await self._planned(wish, tell, jobs.given_candidate, self._local.candidate)

    async def plan(self, wish: PlanWish, tell: Tell = nobody) -> PlannedMission:
        """See ``Planner``; cancelling cancels at the service, too."""
        return await self._planned(wish, tell, jobs.given_mission, self._local.plan)

    async def _planned(
        self, wish: PlanWish, tell: Tell, given: Given[P], here: Callable[[PlanWish, Tell], Awaitable[P]]
    ) -> P:
        why = self._why_not_asked()
        if not why:
            begin_s = self._clock.mono_s()
            try:
                found = await self._asked(wish, tell, given)
            except ServiceError as error:
                why = self._failed(error)
            else:
                took_s = self._clock.mono_s() - begin_s
                return made_there(found, took_s)
        tell(0.0, f"Planning on this server: {why}")
        return made_here(await here(wish, tell), why)

    async def _asked(self, wish: PlanWish, tell: Tell, given: Given[P]) -> P:
        """Return the service's plan after it was checked; raises ``ServiceError`` and, of the wish, ``PlanRefused``."""
        tell(0.0, "Asking the planner service")
        try:
            form = await self._local.run(form_of, wish)
        except ValidationError as error:
            raise BadRequest(f"the wish does not fit the format: {error.error_count()} values") from None
        except ValueError as error:
            raise BadRequest(str(error)) from error
        begin_s = self._clock.mono_s()
        path = await self._client.path(form, new_id(), tell)
        took_s = self._clock.mono_s() - begin_s
        tell(1.0, CHECKING)
        segments = [one.model_dump() for one in path.segments]
        try:
            found = await self._local.run(given, wish, segments, list(path.notes))
        except PathUnfit as unfit:
            raise UnfitPlan(unfit.text) from unfit
        self._link.worked(took_s)
        return found

    def _why_not_asked(self) -> str:
        if self._link.may_ask:
            return ""
        return f"{_REASONS.get(self._link.state, 'the planner service failed')}; it is asked again by itself"

    def _failed(self, error: ServiceError) -> str:
        """Note a failure; return it in words that go on after ``because``."""
        if isinstance(error, PlanFailed):
            return f"the planner service refused the wish: {_sentence(error.text)}"
        if isinstance(error, BadRequest):
            return f"the wish cannot be sent: {_sentence(str(error))}"
        if isinstance(error, TooSlow):
            self._link.late(error)
            return f"the planner service {str(error).removeprefix('it ')}"
        if state_of(error) is LinkState.NOT_UNDERSTOOD:
            self._link.bad_work(error)
            is_unfit = isinstance(error, UnfitPlan)
            what = "the plan of the planner service was refused." if is_unfit else "the planner service failed:"
            return f"{what} {_sentence(str(error))}"
        self._link.failed(error)
        if isinstance(error, NoAnswer):
            return f"the planner service did not answer in {self._client.timeout_s:g} s"
        return _REASONS.get(self._link.state, f"the planner service failed: {_sentence(str(error))}")


class UnfitPlan(Unreadable):
    """The service's path breaks a rule that every plan keeps."""

    mend = "Tell whoever runs the planner service; its plans are not used."


_REASONS = {
    LinkState.SLOW: "the planner service had no plan in time",
    LinkState.UNREACHABLE: "the planner service cannot be reached",
    LinkState.SILENT: "the planner service did not answer",
    LinkState.UNTRUSTED: "the certificate of the planner service is not trusted",
    LinkState.REFUSED: "the planner service does not let us in",
    LinkState.FAILING: "the planner service failed",
    LinkState.BUSY: "the planner service is busy",
    LinkState.NOT_UNDERSTOOD: "the planner service gave answers that cannot be used",
}


def _sentence(text: str) -> str:
    """Return words from outside as plain text, without their full stop."""
    return "".join(c for c in text[:MAX_WHY] if c.isprintable()).strip().rstrip(".")

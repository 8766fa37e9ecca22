"""The planner of the console: here, or a service with this one behind it. Nothing more is loaded if none is set."""

from __future__ import annotations

import asyncio
import importlib
from typing import TYPE_CHECKING, Any

from backend_clients.service.errors import ServiceError
from hmi.app.service_report import away_finding, clock_finding, service_off, service_report
from hmi.clock import Clock
from hmi.domain.alarm.finding import NOTHING, Findings
from hmi.domain.mission_plan import Candidate, PlannedMission, Planner, PlanWish, Tell, nobody
from hmi.domain.mission_rest import PlannedRest, RestWish
from hmi.planning.worker import PlanningProcess
from hmi.planning_service.place import made_here
from hmi.service_link import LinkState, ServiceLink
from hmi.settings import Settings

if TYPE_CHECKING:
    from backend_clients.planner.client import PlannerClient

KEY, NAME = "planner", "Planner service"
LATER_S = 12.0  # after everything that somebody waits for
LOOK_EVERY_S = 60.0
LOOK_SOON_S = 5.0


class PlannerRoom:
    """A ``Planner`` and a ``RestPlanner``; rests of missions under way are planned here, always. Close it."""

    def __init__(self, settings: Settings, clock: Clock) -> None:
        self._settings, self._clock = settings, clock
        self._local = PlanningProcess()
        self._asks: Planner | None = None
        self._link = ServiceLink(clock, name="planner service")
        self._client: PlannerClient | None = None
        self._task: asyncio.Task[None] | None = None

    @property
    def is_on(self) -> bool:
        """Whether a planner service is set."""
        return self._settings.planner_url is not None

    async def plan(self, wish: PlanWish, tell: Tell = nobody) -> PlannedMission:
        """See ``Planner``."""
        if self._asks is not None:
            return await self._asks.plan(wish, tell)
        made = await self._local.plan(wish, tell)
        return made_here(made, self._why_here()) if self.is_on else made

    async def candidate(self, wish: PlanWish, tell: Tell = nobody) -> Candidate:
        """See ``Planner``."""
        if self._asks is not None:
            return await self._asks.candidate(wish, tell)
        made = await self._local.candidate(wish, tell)
        return made_here(made, self._why_here()) if self.is_on else made

    async def rest(self, wish: RestWish) -> PlannedRest:
        """See ``RestPlanner``: it must not depend on a link, and needs what only this console knows of the mission."""
        return await self._local.rest(wish)

    def start(self) -> None:
        """Begin to look after the service, if one is set."""
        if self.is_on:
            self._task = asyncio.create_task(self._run(), name="planner-service")

    async def stop(self) -> None:
        """End it, and planning."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        if self._client is not None:
            await self._client.close()
        await asyncio.to_thread(self._local.close)

    def findings(self) -> Findings:
        """Return what is wrong with the link for the alarms."""
        return (*away_finding("planner-away", self._link), *clock_finding(NAME, self._link)) if self.is_on else NOTHING

    def report(self) -> dict[str, Any]:
        """Return the row for Admin, Cloud."""
        url = self._settings.planner_url
        if url is None:
            return service_off(KEY, NAME)
        facts = [("A plan may take", f"{self._settings.planner_timeout_s:g} s")]
        return service_report(KEY, NAME, url, self._link, self._clock, facts)

    def _why_here(self) -> str:
        """Say why there is no planner that asks the service."""
        if self._link.state is LinkState.CONNECTING:
            return "the planner service was not reached yet since the start"
        return f"the planner service cannot be used, {self._link.why}"

    async def _run(self) -> None:
        await asyncio.sleep(LATER_S)
        await asyncio.to_thread(importlib.import_module, "hmi.app.planner_work")
        from hmi.app.planner_work import look, make_client, make_planner  # loaded above, beside the event loop

        try:
            self._client = await asyncio.to_thread(make_client, self._settings)  # reads certificates
        except ServiceError as error:
            self._link.failed(error)
            return
        self._asks = make_planner(self._local, self._client, self._link, self._clock)
        while True:
            if self._link.may_ask:
                await look(self._client, self._link, self._clock)
            await asyncio.sleep(LOOK_EVERY_S if self._link.is_well else LOOK_SOON_S)

"""A planner service on loopback and a console's planner that asks it; geometry runs in this process."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

from pydantic import SecretStr

from backend_clients.planner.client import PlannerClient, limited
from backend_clients.service.connection import Service
from backend_clients.simulator.faulty_http import FaultyHttp
from hmi.clock import FakeClock
from hmi.domain.mission_plan import Candidate, PlannedMission, PlanWish, Tell, nobody
from hmi.planning.mission import plan_candidate, plan_mission
from hmi.planning.side_process import SideProcess
from hmi.planning_service.application import make_application
from hmi.planning_service.desk import PlanDesk
from hmi.planning_service.planner import ServicePlanner
from hmi.service_link import ServiceLink
from tests.served import served

TOKEN = "service-token"


class HereProcess(SideProcess):
    """Does the work of a process right here; ``held`` keeps it waiting."""

    def __init__(self) -> None:
        super().__init__()
        self.held: asyncio.Event | None = None
        self.is_given_up = False

    async def run(self, work: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        """Return what ``work`` returns."""
        try:
            if self.held is not None:
                await self.held.wait()
            return work(*args, **kwargs)
        except asyncio.CancelledError:
            self.is_given_up = True
            raise


class LocalPlanner:
    """The console's own planner, in this process; counts what it planned itself."""

    def __init__(self) -> None:
        self.planned = 0

    async def plan(self, wish: PlanWish, tell: Tell = nobody) -> PlannedMission:
        """See ``Planner``."""
        self.planned += 1
        return plan_mission(wish)

    async def candidate(self, wish: PlanWish, tell: Tell = nobody) -> Candidate:
        """See ``Planner``."""
        self.planned += 1
        return plan_candidate(wish)

    async def run(self, work: Callable[..., Any], *given: Any) -> Any:
        """See ``PlanningProcess``."""
        return work(*given)


class ServiceRig:
    """Both ends, with faults in between."""

    def __init__(self, url: str, desk: PlanDesk, process: HereProcess, faulty: FaultyHttp, timeout_s: float) -> None:
        self.url, self.desk, self.process, self.faulty = url, desk, process, faulty
        self.clock = FakeClock()
        self.link = ServiceLink(self.clock, jitter=1.0)
        self.local = LocalPlanner()
        service = Service(url, SecretStr(TOKEN), timeout_s=timeout_s)
        self.client = PlannerClient(limited(service), 30.0)
        self.planner = ServicePlanner(self.local, self.client, self.link, self.clock)  # type: ignore[arg-type]


async def until(holds: Callable[[], bool]) -> None:
    """Wait until something holds."""
    async with asyncio.timeout(30):
        for _ in iter(holds, True):
            await asyncio.sleep(0.005)


@asynccontextmanager
async def service_rig(timeout_s: float = 5.0) -> AsyncIterator[ServiceRig]:
    """Run a service and a planner that asks it."""
    process = HereProcess()
    desk = PlanDesk(process=process)
    faulty = FaultyHttp(make_application(desk, TOKEN))
    async with served(faulty) as url:
        rig = ServiceRig(url, desk, process, faulty, timeout_s)
        try:
            yield rig
        finally:
            await rig.client.close()

"""What speaks to a planner service; built by ``hmi.app.planner``."""

from __future__ import annotations

from backend_clients.planner.client import PlannerClient, limited
from backend_clients.service.connection import Service
from backend_clients.service.errors import ServiceError
from hmi.clock import Clock
from hmi.domain.mission_plan import Planner
from hmi.planning.worker import PlanningProcess
from hmi.planning_service.planner import ServicePlanner
from hmi.service_link import ServiceLink
from hmi.settings import Settings

ANSWER_S = 5.0  # of one request; the plan itself may take ``planner_timeout_s``


def make_client(settings: Settings) -> PlannerClient:
    """Return the client; raises ``BadRequest`` for settings it cannot work with."""
    assert settings.planner_url is not None
    timeout_s = min(ANSWER_S, settings.planner_timeout_s)
    ca = str(settings.planner_ca) if settings.planner_ca else ""
    service = Service(settings.planner_url, settings.planner_token, ca, timeout_s)
    return PlannerClient(limited(service), settings.planner_timeout_s)


def make_planner(local: PlanningProcess, client: PlannerClient, link: ServiceLink, clock: Clock) -> Planner:
    """Return the planner that asks the service."""
    return ServicePlanner(local, client, link, clock)


async def look(client: PlannerClient, link: ServiceLink, clock: Clock) -> None:
    """Ask the service whether it is there."""
    begin_s = clock.mono_s()
    try:
        _, headers = await client.info()
    except ServiceError as error:
        link.failed(error)
    else:
        link.well(clock.mono_s() - begin_s, headers.get("date", ""))

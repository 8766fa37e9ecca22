"""The REST interface ``/api/v1``, put together; see docs/protocols/rest.md."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from fastapi import APIRouter, FastAPI

from hmi.api import errors
from hmi.api.access import Access
from hmi.api.diagnostics import Sources, diagnostics_routes
from hmi.api.health import Health, HealthRoutes, health_routes
from hmi.api.limits import BodyLimit
from hmi.api.orders import order_routes
from hmi.api.records import RecordRoutes, record_routes
from hmi.api.robots import RobotRoutes, robot_routes
from hmi.api.sessions import SessionRoutes, session_routes
from hmi.api.stop import StopSender, stop_routes
from hmi.api.users import user_routes
from hmi.commands.desk import CommandDesk
from hmi.security.accounts import Accounts

PREFIX = "/api/v1"


@dataclass(frozen=True, slots=True)
class ApiServices:
    """What each group of routes is given; nothing else reaches it.

    Args:
        further: routers of other packages, such as missions and features.
    """

    access: Access
    sessions: SessionRoutes
    accounts: Accounts
    robots: RobotRoutes
    records: RecordRoutes
    health: HealthRoutes
    desk: CommandDesk
    stop: StopSender
    diagnostics: Sources = field(default_factory=dict)
    further: Sequence[APIRouter] = ()


def build_api(services: ApiServices) -> FastAPI:
    """Return the application to be mounted at ``PREFIX``; its OpenAPI is at ``/openapi.json`` below that."""
    app = FastAPI(
        title="Headland",
        version=services.health.version,
        description="Operate field robots. Errors are `{code, text, field}` with a sentence for a person.",
        docs_url=None,  # the pages of FastAPI load scripts from the Internet
        redoc_url=None,
        redirect_slashes=False,
        responses={
            "4XX": {"description": "Refused", "content": {"application/json": {"schema": ERROR_SCHEMA}}},
            "5XX": {"description": "Failed", "content": {"application/json": {"schema": ERROR_SCHEMA}}},
        },
    )
    app.state.access = services.access
    health = Health(services.health)
    stop = stop_routes(services.stop)
    for router in (
        stop,
        health_routes(health),
        session_routes(services.sessions),
        robot_routes(services.robots),
        order_routes(services.desk),
        user_routes(services.accounts),
        record_routes(services.records),
        diagnostics_routes(health, services.robots.clock, services.diagnostics),
        *services.further,
    ):
        app.include_router(router)
    errors.install(app)
    app.add_middleware(BodyLimit)
    return app


ERROR_SCHEMA = {
    "type": "object",
    "required": ["code", "text", "field"],
    "properties": {
        "code": {"type": "string", "description": "stable machine-readable reason"},
        "text": {"type": "string", "description": "one sentence for a person"},
        "field": {"type": ["string", "null"], "description": "the input at fault"},
    },
}

"""The console as one ASGI application: REST, live lane, static files, pages, and the guards around them."""

from __future__ import annotations

from urllib.parse import urlsplit

from fastapi import APIRouter, FastAPI
from nicegui import app as pages_app
from nicegui import core, ui
from starlette.staticfiles import StaticFiles

from hmi import __version__
from hmi.api.access import Access
from hmi.api.cloud_notify import CloudNotify
from hmi.api.demo import demo_routes
from hmi.api.diagnostics import Sources
from hmi.api.health import HealthRoutes
from hmi.api.metrics import Gauge
from hmi.api.nodes import NodeRoutes, node_routes
from hmi.api.records import RecordRoutes
from hmi.api.robots import RobotRoutes
from hmi.api.router import PREFIX, ApiServices, build_api
from hmi.api.sessions import SessionRoutes
from hmi.api.state_chart import StateRoutes, state_chart_routes
from hmi.app.console import Console
from hmi.app.demo import SimulatorStage
from hmi.assets import CompressedAssets
from hmi.live.lane import lane_route
from hmi.page_compression import CompressedPages
from hmi.pages import bundle
from hmi.pages.services import PageServices, StopAddress
from hmi.pages.shell import RECONNECT_S, TITLE, shell
from hmi.security.origins import Origins
from hmi.security.request_guard import RequestGuard
from hmi.security.response_headers import ResponseHeaders
from hmi.security.socket_policy import PING_INTERVAL_S, PING_TIMEOUT_S, TRANSPORTS, allowed_origin
from hmi.settings import Settings, origin_of

STATIC_PREFIXES = ("/static/", "/_nicegui/")


def build_web(console: Console) -> FastAPI:
    """Return the application that uvicorn serves."""
    settings, sessions = console.settings, console.records.sessions
    origins = Origins(settings.allowed_origins, hosts=[settings.host])
    web = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)
    web.router.routes.append(
        lane_route(
            console.hub,
            sessions,
            lambda origin, host: origins.is_allowed(origin, "https" if settings.is_tls else "http", host or ""),
            console.client_frame,
            console.clock,
            console.desk.drive.connection_lost,
        )
    )

    def is_ours(origin: str | None, host: str | None) -> bool:
        return origins.is_allowed(origin, "https" if settings.is_tls else "http", host or "")

    web.router.routes.extend(console.twin.routes(is_ours))
    web.router.routes.extend(console.cameras.routes(is_ours))
    web.mount(PREFIX, build_api(_api(console)))
    web.router.routes.append(console.metrics.route())
    web.router.routes.extend(bundle.routes())
    web.mount("/static", StaticFiles(directory=bundle.STATIC))
    ui.run_with(
        web,
        root=shell(_pages(console)),
        title=TITLE,
        tailwind=False,
        reconnect_timeout=RECONNECT_S,
        gzip_middleware_factory=None,  # assets are compressed once, below
        show_welcome_message=False,
        storage_secret=settings.secret,
        favicon=bundle.STATIC / "icons/favicon.svg",
        binding_refresh_interval=None,  # nothing on our pages is bound
    )
    _tighten_socket(origins)
    # The last one added is the outermost.
    web.add_middleware(CompressedAssets, prefixes=STATIC_PREFIXES)
    tiles = settings.online_tiles_url
    web.add_middleware(
        ResponseHeaders,
        stop_url_of=lambda host: stop_url(settings, host),
        tiles_origin=origin_of(tiles) if tiles else None,
    )
    web.add_middleware(CompressedPages)
    web.add_middleware(RequestGuard, origins=origins, session_of=sessions.of_headers)
    web.add_middleware(CloudNotify, desk=console.cloud)
    return web


def stop_url(settings: Settings, host: str) -> str:
    """Return the STOP gateway's address for a browser that reached the console as ``host`` (with port)."""
    if settings.stop_public_url:
        return settings.stop_public_url
    name = urlsplit(f"//{host}").hostname or "127.0.0.1"
    shown = f"[{name}]" if ":" in name else name
    return f"{'https' if settings.is_tls else 'http'}://{shown}:{settings.stop_port}"


def _tighten_socket(origins: Origins) -> None:
    """Let the pages' own socket notice dead browsers in seconds and refuse foreign pages."""
    core.sio.eio.ping_interval = PING_INTERVAL_S
    core.sio.eio.ping_timeout = PING_TIMEOUT_S
    core.sio.eio.cors_allowed_origins = allowed_origin(origins)
    pages_app.config.socket_io_js_transports = list(TRANSPORTS)  # type: ignore[arg-type]


def _pages(console: Console) -> PageServices:
    return PageServices(
        settings=console.settings,
        clock=console.clock,
        fleet=console.edge.fleet,
        sessions=console.records.sessions,
        authorize=console.authorize,
        stop=StopAddress(console.settings.stop_port, console.settings.stop_public_url),
        missions=console.missions.book,
    )


def _api(console: Console) -> ApiServices:
    records, edge = console.records, console.edge
    robots = RobotRoutes(
        fleet=edge.fleet,
        registry=records.robots,
        database=records.database,
        leases=console.desk.leases,
        audit=records.audit,
        clock=console.clock,
        on_registry=console.sync_registry,
        title_of=console.missions.title_of,
        facts_of=console.missions.facts.of,
        is_supervised=console.missions.start_rules.is_supervised,
        is_stop_open=console.stops.is_open_at,
    )
    return ApiServices(
        access=Access(records.sessions, records.tokens, console.authorize),
        sessions=SessionRoutes(
            records.sign_in, records.sessions, records.tokens, records.enrolment, records.devices, records.database
        ),
        accounts=records.accounts,
        robots=robots,
        records=RecordRoutes(records.audit, records.history, records.robots, records.database, console.clock),
        health=HealthRoutes(
            version=__version__,
            keeper=console.keeper,
            clock=console.clock,
            broker=lambda: (
                "up" if edge.coordinator.is_broker_up else "down",
                _without_credentials(console.settings.broker_url),
            ),
            is_database_reachable=records.database.is_reachable,
            extra=lambda: {
                **console.chores.health(),
                **console.alarms.health(),
                **console.pictures.health(),
                **console.cloud.health(),
            },
        ),
        desk=console.desk,
        stop=console.stops,
        diagnostics=_diagnostics(console),
        further=[
            *console.missions.routes(console.desk),
            console.maps.routes(),
            console.base_maps.routes(),
            *console.pictures.routes(),
            console.queue.routes(),
            *console.fleet.routes(),
            *console.alarms.routes(),
            node_routes(NodeRoutes(edge.fleet.robot, console.desk.commands, edge.sender, console.clock)),
            state_chart_routes(
                StateRoutes(edge.fleet.robot, records.state_times, records.database, console.clock, console.authorize)
            ),
            console.twin.rest(records, console.clock),
            console.cameras.rest(records, console.desk.leases, edge.fleet),
            console.sensors.routes(),
            *console.cloud.routes(console.maps.book, console.authorize),
            *_demo_routes(console),
        ],
    )


def _demo_routes(console: Console) -> list[APIRouter]:
    if not console.settings.demo:
        return []
    return [demo_routes(SimulatorStage(console.settings.data), console.authorize)]


def _diagnostics(console: Console) -> Sources:
    records = console.records
    console.metrics.add(
        Gauge("lanes", "Browsers connected to the live lane.", lambda: console.hub.lanes),
        Gauge("ingest_messages", "Messages heard from robots.", lambda: console.edge.coordinator.messages, "", True),
        Gauge("audit_queued", "Audit lines waiting for the database.", lambda: records.audit.health().writer.queued),
        Gauge("recorder_dropped", "Samples lost.", lambda: records.recorder.health().dropped, is_counter=True),
        *console.arrivals.gauges(),
        *console.cloud.gauges(),
    )
    return {
        "ingest": console.edge.coordinator.diagnostics,
        "arrivals": console.arrivals.whole,
        "live": lambda: {"lanes": console.hub.lanes, "boot": console.hub.boot},
        "alarms": console.alarms.diagnostics,
        "audit": records.audit.health,
        "recorder": records.recorder.health,
        "pictures": console.pictures.shelf.health,
        "sensors": console.sensors.diagnostics,
    }


def _without_credentials(url: str) -> str:
    parts = urlsplit(url)
    return f"{parts.scheme}://{parts.hostname}:{parts.port}"

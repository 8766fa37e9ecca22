"""``headland simulate planner`` and ``forecast``: services outside the farm, with faults to try."""

from __future__ import annotations

import asyncio
import copy
import signal
import socket
from typing import Annotated, Any

import typer

from hmi.keeper.errors import StartError

Port = Annotated[int, typer.Option(min=0, max=65535, help="Port to listen on; 0 takes a free one.")]
Host = Annotated[str, typer.Option(help="Address to listen on.")]
Token = Annotated[str, typer.Option(help="Bearer token every request has to carry; none if empty.")]
Delay = Annotated[float, typer.Option(min=0, max=600, help="Each answer waits so long, seconds.")]
Clock = Annotated[float, typer.Option(help="How far its clock is ahead, seconds.")]
FAILS = "fail (503), half-open, too-large (413), refuse (401), not-json, huge, cut"


def register(app: typer.Typer) -> None:
    """Add the commands to ``app``."""
    app.command()(planner)
    app.command()(forecast)


def planner(
    port: Port = 8090,
    host: Host = "127.0.0.1",
    token: Token = "",
    delay: Delay = 0.0,
    plan_delay: Annotated[float, typer.Option(min=0, max=600, help="Each plan waits so long first, seconds.")] = 0.0,
    fail: Annotated[str, typer.Option(help=f"Instead of every answer: {FAILS}; bad-plan, other-wish.")] = "none",
    clock: Clock = 0.0,
) -> None:
    """A planner service that plans for real, with our own planner, behind the open format."""
    from hmi.planning_service.application import make_application
    from hmi.planning_service.desk import PlanDesk

    alter = {"bad-plan": moved, "other-wish": of_another}.get(fail)
    faults = {"fault": "none" if alter else fail, "delay_s": delay, "clock_s": clock, "alter": alter}
    _serve(host, port, lambda: make_application(PlanDesk(delay_s=plan_delay), token), faults, "planner service")


def forecast(
    port: Port = 8091,
    host: Host = "127.0.0.1",
    token: Token = "",
    seed: Annotated[int, typer.Option(help="Of the simulated weather, as of the simulated stations.")] = 1,
    delay: Delay = 0.0,
    fail: Annotated[str, typer.Option(help=f"Instead of every answer: {FAILS}.")] = "none",
    clock: Clock = 0.0,
) -> None:
    """A forecast service that knows the simulated weather ahead of time, about."""
    from datetime import timedelta

    from backend_clients.simulator.forecast import ForecastEndpoint
    from hmi.clock import SystemClock

    class Ahead(SystemClock):
        def utc(self) -> Any:
            return super().utc() + timedelta(seconds=clock)

    faults = {"fault": fail, "delay_s": delay, "clock_s": clock}
    _serve(host, port, ForecastEndpoint(seed, token, Ahead()).application, faults, "forecast service")


def moved(report: Any) -> Any:
    """Return a plan whose path leaves the field: 40 m to the east."""
    changed = copy.deepcopy(report)
    for segment in (changed.get("result") or {}).get("segments", []):
        segment["points"] = [[x + 40.0, y] for x, y in segment["points"]]
    return changed


def of_another(report: Any) -> Any:
    """Return a plan that says it belongs to another wish."""
    return {**report, "wish_sha256": "0" * 64} if "wish_sha256" in report else report


def _serve(host: str, port: int, make: Any, faults: dict[str, Any], name: str) -> None:
    from backend_clients.simulator.faulty_http import Fault, Faults, FaultyHttp

    try:
        broken = Faults(**{**faults, "fault": Fault(faults["fault"])})
    except ValueError as error:
        raise StartError(f"There is no fault {faults['fault']!r}; choose of {FAILS}.") from error
    try:
        listener = socket.create_server((host, port))
    except OSError as error:
        raise StartError(f"Cannot listen on {host}:{port}: {error}.") from error
    typer.echo(f"{name} at http://{host}:{listener.getsockname()[1]}")

    async def run() -> None:
        import uvicorn

        config = uvicorn.Config(
            FaultyHttp(make(), broken), log_config=None, log_level="critical", access_log=False, server_header=False,
            date_header=not broken.clock_s, timeout_graceful_shutdown=1, lifespan="on",
        )  # fmt: skip
        await uvicorn.Server(config).serve(sockets=[listener])

    with listener:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        asyncio.run(run())

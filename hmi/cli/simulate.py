"""``headland simulate``: simulated robots alone, over the same wire as real ones."""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from hmi.cli import services
from hmi.keeper.errors import StartError

app = typer.Typer(no_args_is_help=True)
services.register(app)


@app.callback()
def simulate() -> None:
    """Simulated robots alone, over the same wire as real ones."""


Broker = Annotated[str, typer.Option(help="MQTT broker, mqtt://host:port.")]
HttpPort = Annotated[int, typer.Option(min=0, max=65535, help="Port of the robots' HTTP; 0 takes a free one.")]
Seed = Annotated[int, typer.Option(help="Makes noise and what happens repeatable.")]
Speed = Annotated[float, typer.Option(min=0.1, max=200, help="Missions run this many times faster.")]
State = Annotated[Path | None, typer.Option(help="Folder where latch and mission survive a restart.")]
Name = Annotated[str, typer.Option(help="What people call it.")]
Token = Annotated[str, typer.Option(help="Bearer token of its HTTP; made and printed if empty.")]
Lat = Annotated[float | None, typer.Option(min=-90, max=90, help="Latitude of its datum.")]
Lon = Annotated[float | None, typer.Option(min=-180, max=180, help="Longitude of its datum.")]
Robots = Annotated[Path | None, typer.Option(help="JSON list of robots instead of one, as the demo uses.")]
LOCAL_BROKER = "mqtt://127.0.0.1:1883"


@app.command()
def weeder(
    broker: Broker = LOCAL_BROKER,
    port: HttpPort = 0,
    seed: Seed = 1,
    speed: Speed = 1.0,
    robot: Annotated[str, typer.Option("--id", help="Robot id.")] = "weeder-01",
    name: Name = "",
    token: Token = "",
    lat: Lat = None,
    lon: Lon = None,
    state: State = None,
    robots: Robots = None,
) -> None:
    """Start one simulated laser weeder, or the robots of a file."""
    _run(
        broker,
        port,
        seed,
        speed,
        state,
        lambda: _read(robots) if robots else (_one("weeder", robot, name, token, lat, lon),),
    )


@app.command()
def planter(
    broker: Broker = LOCAL_BROKER,
    port: HttpPort = 0,
    seed: Seed = 1,
    speed: Speed = 1.0,
    robot: Annotated[str, typer.Option("--id", help="Robot id.")] = "planter-01",
    name: Name = "",
    token: Token = "",
    lat: Lat = None,
    lon: Lon = None,
    state: State = None,
) -> None:
    """Start one simulated tree planter."""
    _run(broker, port, seed, speed, state, lambda: (_one("planter", robot, name, token, lat, lon),))


@app.command(name="planter-what-if")
def planter_what_if(
    hours: Annotated[float, typer.Option(min=0.1, max=1000, help="How long each planter works.")] = 8.0,
    crane_speed: Annotated[float, typer.Option(min=0.2, max=5, help="Times the crane's usual speed.")] = 1.5,
    seedlings_per_head: Annotated[int, typer.Option(min=1, max=10, help="Taken at one docking.")] = 2,
    seed: Seed = 1,
) -> None:
    """Trees an hour of other planters: a faster crane, more seedlings per head, docking while driving."""
    from backend_clients.simulator.what_if import compare

    usual = 0.0
    for run in compare(crane_speed=crane_speed, seedlings_per_head=seedlings_per_head, hours=hours, seed=seed):
        usual = usual or run.trees_per_hour
        change = run.trees_per_hour / usual - 1 if usual else 0.0
        typer.echo(
            f"{run.name:<32}{run.trees_per_hour:>7.1f} trees/h{change:>+8.0%}   "
            f"{run.planted} of {run.attempts} attempts, {run.times_faster:,.0f} times real time"
        )


@app.command()
def uav(
    broker: Broker = LOCAL_BROKER,
    port: HttpPort = 0,
    seed: Seed = 1,
    speed: Speed = 1.0,
    robot: Annotated[str, typer.Option("--id", help="Robot id.")] = "uav-01",
    name: Name = "",
    token: Token = "",
    lat: Lat = None,
    lon: Lon = None,
    state: State = None,
) -> None:
    """Start one simulated UAV."""
    _run(broker, port, seed, speed, state, lambda: (_one("uav", robot, name, token, lat, lon),))


@app.command()
def fleet(
    broker: Broker = LOCAL_BROKER,
    port: HttpPort = 0,
    seed: Seed = 1,
    speed: Speed = 1.0,
    state: State = None,
    robots: Annotated[Path | None, typer.Option(help="JSON list of robots instead of numbers of them.")] = None,
    weeders: Annotated[int, typer.Option(min=0, max=99, help="How many laser weeders.")] = 16,
    planters: Annotated[int, typer.Option(min=0, max=99, help="How many tree planters.")] = 4,
    uavs: Annotated[int, typer.Option(min=0, max=99, help="How many UAVs.")] = 4,
    lean: Annotated[int, typer.Option(min=0, max=5000, help="Only so many lean weeders, for load.")] = 0,
    out: Annotated[Path | None, typer.Option(help="Write ids and HTTP tokens of the robots here.")] = None,
    always_day: Annotated[bool, typer.Option(help="Cameras see daylight at any hour.")] = False,
    cloud: Annotated[str, typer.Option(help="Context broker where the robots take missions, too.")] = "",
    cloud_tenant: Annotated[str, typer.Option(help="Tenant there (Fiware-Service).")] = "",
    farm: Annotated[str, typer.Option(help="Farm in the names of the cloud's entities.")] = "farm",
    sensors: Annotated[bool, typer.Option(help="With the demo farm's field sensors.")] = False,
    cameras_ready: Annotated[bool, typer.Option(help="Be ready to draw pictures before somebody asks.")] = False,
) -> None:
    """Start many robots in one process: a farm at work, or a crowd for load."""
    from backend_clients.simulator.config import CloudConfig, SimulatorConfig
    from backend_clients.simulator.process import run_simulator
    from hmi.demo.crowd import fleet_rows, lean_jobs, lean_rows
    from hmi.demo.jobs import OPENING, jobs_of
    from hmi.demo.scenery import map_features

    try:
        rows = _rows(robots) if robots else lean_rows(lean) if lean else fleet_rows(weeders, planters, uavs)
        jobs = jobs_of(rows)
        config = SimulatorConfig(
            broker,
            _configs(rows, robots),
            port=port,
            seed=seed,
            speed=speed,
            state_dir=state,
            jobs=jobs | lean_jobs(rows),
            opening=OPENING if jobs else None,
            features=map_features(),
            is_always_day=always_day,
            cloud=CloudConfig(cloud, cloud_tenant, farm=farm) if cloud else None,
            stations=_stations if sensors else None,
            are_cameras_ready=cameras_ready,
        )
        if out is not None:
            _write_private(out, rows)
    except (ValueError, OSError) as error:
        raise StartError(f"{error}.") from error
    run_simulator(config)


@app.command()
def sensors(
    broker: Broker = LOCAL_BROKER,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port of the testers' HTTP; 0 takes a free one.")] = 0,
    seed: Annotated[int, typer.Option(help="Makes the weather repeatable.")] = 1,
    speed: Annotated[float, typer.Option(min=0.1, max=3600, help="The weather goes this many times faster.")] = 1.0,
    always_day: Annotated[bool, typer.Option(help="Cameras see daylight at any hour.")] = False,
) -> None:
    """Start the demo farm's field sensors alone: weather, soil, respiration, field cameras."""
    from backend_clients.simulator.config import SimulatorConfig
    from backend_clients.simulator.process import run_simulator
    from hmi.demo.scenery import map_features

    config = SimulatorConfig(
        broker,
        (),
        port=port,
        seed=seed,
        features=map_features(),
        is_always_day=always_day,
        stations=_stations,
        sensor_speed=speed,
    )
    try:
        run_simulator(config, on_ready=lambda at: typer.echo(f"Testers' HTTP: http://127.0.0.1:{at}"))
    except OSError as error:
        raise StartError(f"Cannot listen on port {port}: {error}.") from error


@app.command(name="context-broker")
def context_broker(
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port to listen on; 0 takes a free one.")] = 1026,
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    forecast: Annotated[bool, typer.Option(help="Serve a weather forecast beside it.")] = False,
    planner: Annotated[bool, typer.Option(help="Serve a planner beside it.")] = False,
) -> None:
    """Start a simulated context broker (NGSI-v2), which forgets everything when it ends."""
    from backend_clients.simulator.context_broker.__main__ import run
    from hmi.demo.cloud_services import beside_the_broker

    try:
        run(host, port, beside_the_broker(has_planner=planner, has_forecast=forecast))
    except OSError as error:
        raise StartError(f"Cannot listen on {host}:{port}: {error}.") from error


def _run(
    broker: str, port: int, seed: int, speed: float, state: Path | None, robots: Callable[[], tuple[Any, ...]]
) -> None:
    from backend_clients.simulator.config import SimulatorConfig
    from backend_clients.simulator.process import run_simulator
    from hmi.demo.scenery import map_features

    try:
        config = SimulatorConfig(
            broker, robots(), port=port, seed=seed, speed=speed, state_dir=state, features=map_features()
        )
    except ValueError as error:
        raise StartError(f"{error}.") from error
    run_simulator(config)


def _stations() -> Any:
    """Return the demo farm's field sensors; loaded when they begin."""
    from hmi.demo.stations import STATIONS

    return STATIONS


def _one(family: Any, robot: str, name: str, token: str, lat: float | None, lon: float | None) -> Any:
    from backend_clients.simulator.config import DEFAULT_LAT_DEG, DEFAULT_LON_DEG, RobotConfig

    if not token:
        token = secrets.token_urlsafe(24)
        typer.echo(f"HTTP token of {robot}: {token}")
    return RobotConfig(
        id=robot,
        name=name or robot.replace("-", " ").capitalize(),
        token=token,
        datum_lat_deg=DEFAULT_LAT_DEG if lat is None else lat,
        datum_lon_deg=DEFAULT_LON_DEG if lon is None else lon,
        family=family,
    )


def _read(path: Path) -> tuple[Any, ...]:
    return _configs(_rows(path), path)


def _write_private(path: Path, rows: list[dict[str, Any]]) -> None:
    path.touch(mode=0o600)
    path.write_text(json.dumps(rows, indent=1), encoding="utf-8")


def _rows(path: Path) -> list[dict[str, Any]]:
    try:
        rows: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ValueError(f"cannot read robots from {path}: {error}") from error
    return rows


def _configs(rows: list[dict[str, Any]], path: Path | None = None) -> tuple[Any, ...]:
    from backend_clients.simulator.config import RobotConfig

    try:
        known = RobotConfig.__dataclass_fields__
        return tuple(RobotConfig(**{k: v for k, v in row.items() if k in known}) for row in rows)
    except (TypeError, AttributeError) as error:
        raise ValueError(f"cannot read robots from {path}: {error}") from error

"""``headland simulate``: simulated robots alone, over the same wire as real ones."""

from __future__ import annotations

import json
import secrets
from pathlib import Path
from typing import Annotated, Any

import typer

from hmi.keeper.errors import StartError

app = typer.Typer(no_args_is_help=True)


@app.callback()
def simulate() -> None:
    """Simulated robots alone, over the same wire as real ones."""


@app.command()
def weeder(
    broker: Annotated[str, typer.Option(help="MQTT broker, mqtt://host:port.")] = "mqtt://127.0.0.1:1883",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port of the robots' HTTP; 0 takes a free one.")] = 0,
    seed: Annotated[int, typer.Option(help="Makes noise repeatable.")] = 1,
    speed: Annotated[float, typer.Option(min=0.1, max=200, help="Missions run this many times faster.")] = 1.0,
    robot: Annotated[str, typer.Option("--id", help="Robot id.")] = "weeder-01",
    name: Annotated[str, typer.Option(help="What people call it.")] = "",
    token: Annotated[str, typer.Option(help="Bearer token of its HTTP; made and printed if empty.")] = "",
    lat: Annotated[float | None, typer.Option(min=-90, max=90, help="Latitude of its datum.")] = None,
    lon: Annotated[float | None, typer.Option(min=-180, max=180, help="Longitude of its datum.")] = None,
    state: Annotated[Path | None, typer.Option(help="Folder where latch and mission survive a restart.")] = None,
    robots: Annotated[Path | None, typer.Option(help="JSON list of robots instead of --id, as the demo uses.")] = None,
) -> None:
    """Start one simulated laser weeder, or those of a file."""
    from backend_clients.simulator.config import SimulatorConfig
    from backend_clients.simulator.process import run_simulator

    try:
        weeders = _read(robots) if robots else (_one(robot, name, token, lat, lon),)
        config = SimulatorConfig(broker, weeders, port=port, seed=seed, speed=speed, state_dir=state)
    except ValueError as error:
        raise StartError(f"{error}.") from error
    run_simulator(config)


@app.command()
def weather(
    url: Annotated[str, typer.Option(help="Address of the console.")] = "http://127.0.0.1:8080",
    name: Annotated[str, typer.Option(help="Who signs in; needs the operator or planner role.")] = "operator",
    password: Annotated[str, typer.Option(help="Their password; as the name if empty, as in the demo.")] = "",
    seed: Annotated[int, typer.Option(help="Makes the weather repeatable.")] = 1,
) -> None:
    """A simulated weather station that reports wind and rain to the console each minute."""
    import httpx

    from hmi.demo.weather import WeatherStation, run_station

    with httpx.Client(base_url=url, timeout=10, trust_env=False) as client:
        run_station(client, name, password or name, WeatherStation(seed), say=typer.echo)


def _one(robot: str, name: str, token: str, lat: float | None, lon: float | None) -> Any:
    from backend_clients.simulator.config import DEFAULT_LAT_DEG, DEFAULT_LON_DEG, WeederConfig

    if not token:
        token = secrets.token_urlsafe(24)
        typer.echo(f"HTTP token of {robot}: {token}")
    return WeederConfig(
        id=robot,
        name=name or robot.replace("-", " ").capitalize(),
        token=token,
        datum_lat_deg=DEFAULT_LAT_DEG if lat is None else lat,
        datum_lon_deg=DEFAULT_LON_DEG if lon is None else lon,
    )


def _read(path: Path) -> tuple[Any, ...]:
    from backend_clients.simulator.config import WeederConfig

    try:
        rows = json.loads(path.read_text(encoding="utf-8"))
        known = WeederConfig.__dataclass_fields__
        return tuple(WeederConfig(**{k: v for k, v in row.items() if k in known}) for row in rows)
    except (OSError, TypeError, AttributeError) as error:
        raise ValueError(f"cannot read robots from {path}: {error}") from error

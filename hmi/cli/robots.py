"""``headland robot``: the registry of robots that may be operated."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from hmi.clock import SystemClock
from hmi.domain.family import Family
from hmi.domain.ids import is_id
from hmi.domain.robot_address import usable_address, usable_token
from hmi.keeper.errors import StartError
from hmi.stop_gateway.outbox import open_presses

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from hmi.cli.registry import OpenRegistry

app = typer.Typer(no_args_is_help=True)


@app.command()
def add(
    robot_id: Annotated[str, typer.Argument(help="Id, as the robot uses it in its topics.")],
    name: Annotated[str, typer.Option(help="What people call it.")],
    family: Annotated[Family, typer.Option(help="Kind of machine.")] = Family.WEEDER,
    http_url: Annotated[str | None, typer.Option(help="Address of its own HTTP, the second path of STOP.")] = None,
    http_token: Annotated[str | None, typer.Option(help="Bearer token of its HTTP.")] = None,
    decel: Annotated[float, typer.Option(min=0.1, max=50, help="Braking on STOP, m/s2.")] = 1.0,
) -> None:
    """Register a robot, so that it can be operated."""
    if not is_id(robot_id):
        raise StartError(f"{robot_id!r} is no robot id: lower-case letters, digits, - and _, at most 64.")
    try:
        address = http_url and usable_address(http_url)
        token = http_token and usable_token(http_token)
    except ValueError as error:
        raise StartError(f"The HTTP of {robot_id} cannot be used: {error}.") from error
    with _opened() as robots:
        from hmi.store.robots import RegisteredRobot

        entry = RegisteredRobot(
            id=robot_id,
            farm_id=robots.farm_id,
            name=name,
            family=family,
            added_by="command line",
            added_at=SystemClock().utc(),
            http_url=address or None,
            http_token=token or None,
            decel_mps2=decel,
        )
        robots.registry.add(entry)
        typer.echo(f"{name} ({robot_id}) can be operated. Restart the console if it runs.")


@app.command()
def unattended(
    robot_id: str,
    is_on: Annotated[bool, typer.Option("--on/--off", help="May an armed queue start it without a person?")],
) -> None:
    """Allow a robot to be started by an armed queue without a person at the moment, or forbid it."""
    with _opened() as robots:
        known = robots.registry.get(robot_id)
        if known is None:
            raise StartError(f"There is no robot {robot_id!r}.")
        robots.registry.change(replace(known, is_unattended_allowed=is_on))
        words = "may run unattended" if is_on else "needs a person now"
        typer.echo(f"{known.name} {words}. Restart the console if it runs.")


@app.command("list")
def show() -> None:
    """List registered robots; tokens are not shown."""
    with _opened() as robots:
        for robot in robots.registry.all():
            typer.echo(f"{robot.id:20} {robot.family:8} {robot.name:24} {robot.http_url or 'no HTTP'}")


@app.command()
def remove(robot_id: str) -> None:
    """Take a robot out of the registry; it is then shown but cannot be operated."""
    with _opened() as robots:
        if any(press.robot == robot_id for press in open_presses(robots.outbox)):
            raise StartError(f"A STOP at {robot_id} is not reset. Reset it, then remove the robot.")
        robots.registry.remove(robot_id)
        typer.echo(f"{robot_id} is removed. Restart the console if it runs.")


def _opened() -> AbstractContextManager[OpenRegistry]:
    """Open the registry; the database is imported here, so that other commands start without it."""
    from hmi.cli.registry import opened_registry

    return opened_registry()

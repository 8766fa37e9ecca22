"""``headland user``: people who may sign in."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hmi.domain.role import Role
from hmi.keeper.errors import StartError

if TYPE_CHECKING:
    from hmi.security.accounts import Accounts

app = typer.Typer(no_args_is_help=True)
BY = "command line"

Password = Annotated[
    str, typer.Option(prompt=True, confirmation_prompt=True, hide_input=True, help="Asked if left out.")
]


@app.command()
def add(
    name: Annotated[str, typer.Argument(help="Name as shown to others, e.g. 'Martha Keller'.")],
    password: Password,
    role: Annotated[Role, typer.Option(help="What the person is trusted with.")] = Role.OPERATOR,
    user_id: Annotated[str, typer.Option("--id", help="Name to sign in with; made from NAME if left out.")] = "",
) -> None:
    """Add a person."""
    user = _run(lambda accounts: accounts.create_user(name, role, password, by=BY, user_id=user_id))
    typer.echo(f"{user.name} signs in as {user.id} ({user.role}).")


@app.command("list")
def show() -> None:
    """List people."""
    for user in _run(lambda accounts: accounts.all()):
        typer.echo(f"{user.id:20} {user.role:11} {'' if user.is_active else 'off  '}{user.name}")


@app.command()
def password(user_id: str, password: Password) -> None:
    """Set a person's password."""
    _run(lambda accounts: accounts.set_password(user_id, password, by=BY))
    typer.echo(f"The password of {user_id} is changed.")


@app.command()
def disable(user_id: str) -> None:
    """Switch a person off; open pages close within five seconds."""
    _run(lambda accounts: accounts.change(user_id, by=BY, is_active=False))
    typer.echo(f"{user_id} cannot sign in any more.")


def _run(work: Callable[[Accounts], Coroutine[Any, Any, Any]]) -> Any:
    from hmi.app.records import Records
    from hmi.clock import SystemClock
    from hmi.keeper.data_folder import require_writable
    from hmi.security.errors import SecurityError
    from hmi.settings import Settings
    from hmi.store.errors import StoreError

    settings = Settings()  # type: ignore[call-arg]  # every field comes from file or variables
    require_writable(settings.data)
    records = Records(settings, SystemClock(), lambda _robot: False)
    try:
        records.open()
        records.audit.start()
        return asyncio.run(work(records.accounts))
    except (StoreError, SecurityError) as error:
        raise StartError(f"{error}") from error
    finally:
        records.close()

"""``headland cert``: a local certificate authority and a server certificate for the farm's network."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add the command to ``app``."""
    app.command()(cert)


def cert(
    names: Annotated[list[str], typer.Argument(help="Host names and addresses tablets use, e.g. 192.168.1.20")],
    folder: Annotated[Path | None, typer.Option(help="Where they go; `tls` in the data folder if left out.")] = None,
    days: Annotated[int, typer.Option(min=1, max=825, help="Validity of the server certificate.")] = 397,
) -> None:
    """Make a local CA (once) and a server certificate for NAMES, for `headland serve --tls`."""
    from hmi.keeper.certificates import make_certificates
    from hmi.settings import Settings

    # the folder's name needs no secret yet
    at = folder or Settings(demo=True).data / "tls"  # type: ignore[call-arg]  # the rest comes from file or variables
    made = make_certificates(names, at, days=days)
    typer.echo(f"Server certificate: {made.cert}\nServer key:         {made.key}")
    typer.echo(f"Install {made.ca} on each tablet as a trusted authority (never the key beside it).")
    if folder is None:
        typer.echo("Then start with: headland serve --tls")
    else:
        typer.echo(f"Then start with: HEADLAND_TLS_CERT={made.cert} HEADLAND_TLS_KEY={made.key} headland serve")

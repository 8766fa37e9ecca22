"""``headland bench``: the published figures, measured on this machine."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from typing import Annotated

import typer

from hmi.keeper.errors import StartError


def register(app: typer.Typer) -> None:
    """Add the command to ``app``."""
    app.command()(bench)


def bench(name: Annotated[str | None, typer.Argument(help="One figure, e.g. stop_idle_p99_ms.")] = None) -> None:
    """Print the published figures as JSON lines (from a checkout: the benches are not installed)."""
    if importlib.util.find_spec("bench") is None:
        raise StartError("The benches are part of the source: run this in a checkout, or `make bench`.")
    arguments = [name] if name else []
    raise typer.Exit(subprocess.run([sys.executable, "-m", "bench", *arguments], check=False).returncode)  # noqa: S603

"""The ``headland`` command.

Each module holds one group of commands; heavy imports happen inside the commands, so that ``--help`` is quick.
"""

from __future__ import annotations

import sys

import typer

from hmi import __version__
from hmi.cli import bench, cert, check, people, processes, records, robots, simulate
from hmi.keeper.failure import report_failures

app = typer.Typer(
    name="headland",
    help="Operator HMI and fleet console for field robots.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
processes.register(app)
check.register(app)
cert.register(app)
bench.register(app)
records.register(app)
app.add_typer(simulate.app, name="simulate", help="Start simulated robots alone.")
app.add_typer(robots.app, name="robot", help="The registry of robots that may be operated.")
app.add_typer(people.app, name="user", help="People who may sign in.")


@app.command()
def version() -> None:
    """Print the version."""
    typer.echo(__version__)


def main() -> None:
    """Run the command line; every foreseen failure is one sentence and a non-zero exit code."""
    with report_failures():
        app()
    sys.exit(0)

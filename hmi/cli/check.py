"""``headland check``: is this machine ready, and what to do where it is not."""

from __future__ import annotations

import typer


def register(app: typer.Typer) -> None:
    """Add the command to ``app``."""
    app.command()(check)


def check() -> None:
    """Check settings, data folder, broker, ports, clock and versions; exit code 1 if anything must be mended."""
    from hmi.keeper.checkup import checkup

    findings = checkup()
    for finding in findings:
        typer.echo(f"{'ok  ' if finding.is_ok else 'MEND'}  {finding.subject}: {finding.text}")
    if not all(finding.is_ok for finding in findings):
        raise typer.Exit(1)

"""``headland verify``: has anybody changed the audit log?"""

from __future__ import annotations

import typer


def register(app: typer.Typer) -> None:
    """Add the command to ``app``."""
    app.command()(verify)


def verify() -> None:
    """Check the hash chain of the audit log; exit code 1 if a row was changed or is missing."""
    from hmi.cli.storage import opened
    from hmi.clock import SystemClock
    from hmi.store.audit import Audit

    with opened() as (settings, database):
        audit = Audit(database, SystemClock(), settings.data / "audit-spill.jsonl")
        verdict = audit.verify(settings.farm_id)
        typer.echo(f"{verdict.rows} rows. {verdict.text}")
        if verdict.first_broken_seq is not None:
            raise typer.Exit(1)

"""Bring a database to the newest version, by Alembic and without its command line."""

from __future__ import annotations

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.util import CommandError
from sqlalchemy import Connection, text

from hmi.store.errors import DatabaseTooNew

FOLDER = Path(__file__).parent
_LOCK = 0x48454144  # "HEAD"; any number that only Headland uses


def alembic_config(connection: Connection) -> Config:
    """Return the configuration that an ``alembic.ini`` would hold, bound to an open connection."""
    config = Config()
    config.set_main_option("script_location", str(FOLDER).replace("%", "%%"))
    config.attributes["connection"] = connection
    return config


def upgrade_to_newest(connection: Connection) -> None:
    """Apply the missing steps inside the caller's transaction.

    Two processes that start together wait for each other: SQLite by the write lock that the caller's transaction
    holds, PostgreSQL by an advisory lock.

    Raises:
        DatabaseTooNew: the database has a version that this package does not know.
    """
    if connection.dialect.name == "postgresql":
        connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": _LOCK})
    try:
        command.upgrade(alembic_config(connection), "head")
    except CommandError as error:
        raise DatabaseTooNew(
            f"the database was written by another version of Headland: update this one ({error})"
        ) from error

"""Bring a database to the newest version, by Alembic and without its command line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import Connection, inspect, text

if TYPE_CHECKING:
    from alembic.config import Config

from hmi.store.errors import DatabaseTooNew

FOLDER = Path(__file__).parent
_LOCK = 0x48454144  # "HEAD"; any number that only Headland uses


def alembic_config(connection: Connection) -> Config:
    """Return the configuration that an ``alembic.ini`` would hold, bound to an open connection."""
    from alembic.config import Config

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
    if _version_of(connection) == newest_version():
        return  # the usual start; Alembic takes a third of a second to import
    from alembic import command
    from alembic.util import CommandError

    try:
        command.upgrade(alembic_config(connection), "head")
    except CommandError as error:
        raise DatabaseTooNew(
            f"the database was written by another version of Headland: update this one ({error})"
        ) from error


def newest_version() -> str:
    """Return the version after the last step, read from the names of the steps: ``v0008_fleet`` is ``0008``."""
    return max(path.stem.partition("_")[0] for path in (FOLDER / "versions").glob("v*.py")).removeprefix("v")


def _version_of(connection: Connection) -> str | None:
    if not inspect(connection).has_table("alembic_version"):
        return None
    version: str | None = connection.execute(text("SELECT version_num FROM alembic_version")).scalar()
    return version

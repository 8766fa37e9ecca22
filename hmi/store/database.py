"""The database: SQLite in the data folder, or PostgreSQL by URL.

Reads and writes are separate transactions on purpose. A write begins with ``BEGIN IMMEDIATE`` on SQLite, so that
two writers wait for each other (``BUSY_TIMEOUT_MS``) instead of failing half-way.
Nothing here may run on the event loop: use ``run``, which has its own few threads, so that a slow disk never takes
the threads that others need.
"""

from __future__ import annotations

import asyncio
import os
import sqlite3
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from sqlalchemy import Connection, Engine, create_engine, event, text
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import (
    DatabaseError,
    IntegrityError,
    InterfaceError,
    InternalError,
    OperationalError,
    SQLAlchemyError,
)
from sqlalchemy.exc import TimeoutError as PoolTimeout
from sqlalchemy.orm import Session

from hmi.store.errors import AlreadyExists, DatabaseFull, DatabaseUnavailable
from hmi.store.migrations.upgrade import upgrade_to_newest

P = ParamSpec("P")
R = TypeVar("R")

BUSY_TIMEOUT_MS = 5000  # longer than any batch or thinning step holds the write lock
SERVER_TIMEOUT_S = 5
"""A database server that neither answers nor refuses for so long is gone."""
THREADS = 4  # SQLite writes one at a time anyway; the others read
POSTGRES_DISK_FULL = "53100"
_WRITES = {"headland_writes": True}


class Database:
    """One database and the threads that talk to it.

    Args:
        url: SQLAlchemy URL, e.g. ``sqlite:////var/lib/headland/headland.db``.

    Raises:
        ValueError: the URL names an in-memory SQLite, which threads cannot share.
    """

    def __init__(self, url: str) -> None:
        self.url: URL = make_url(url)
        self.engine: Engine = _make_engine(self.url)
        self._writing = self.engine.execution_options(**_WRITES)
        self.is_closed = False
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="database")

    @property
    def is_sqlite(self) -> bool:
        """Whether this is SQLite, as opposed to a server."""
        return self.url.get_backend_name() == "sqlite"

    def migrate(self) -> None:
        """Bring the tables to the newest version; does nothing when they are.

        Raises:
            DatabaseUnavailable: it cannot be opened or written.
            DatabaseTooNew: a newer version of Headland made it.
        """
        with _translated(), self._writing.begin() as connection:
            upgrade_to_newest(connection)

    @contextmanager
    def read(self) -> Iterator[Session]:
        """Open a session for reading; what it changes is rolled back. Rows are detached at the end."""
        with _translated(), Session(self.engine, expire_on_commit=False) as session:
            yield session

    @contextmanager
    def write(self) -> Iterator[Session]:
        """Open a session in one write transaction: committed at the end, rolled back on any error.

        Raises:
            AlreadyExists: a key is taken, or a row that is referred to does not exist.
            DatabaseUnavailable: nothing was written.
        """
        with _translated(), Session(self._writing, expire_on_commit=False) as session, session.begin():
            yield session

    @contextmanager
    def connect_writing(self) -> Iterator[Connection]:
        """Open a bare connection in one write transaction, for batches."""
        with _translated(), self._writing.begin() as connection:
            yield connection

    async def run(self, work: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Run blocking ``work`` in a thread of the database and return what it returned."""
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._threads, lambda: work(*args, **kwargs))

    def is_reachable(self) -> bool:
        """Ask for one number; False instead of an error."""
        try:
            with self.read() as session:
                return bool(session.execute(text("SELECT 1")).scalar_one() == 1)
        except DatabaseUnavailable:
            return False

    def close(self) -> None:
        """Wait for running work, then close every connection."""
        self.is_closed = True
        self._threads.shutdown(wait=True)
        self.engine.dispose()


@contextmanager
def _translated() -> Iterator[None]:
    try:
        yield
    except IntegrityError as error:
        raise AlreadyExists(str(error.orig)) from error
    except (OperationalError, InterfaceError, InternalError, PoolTimeout) as error:
        kind = DatabaseFull if _is_full(error) else DatabaseUnavailable
        raise kind(f"the database cannot be used now: {_cause(error)}") from error
    except DatabaseError as error:
        if type(error) is not DatabaseError:  # a mistake in a statement is ours, not the disk's
            raise
        raise DatabaseUnavailable(f"the database cannot be used now: {_cause(error)}") from error


def _cause(error: SQLAlchemyError) -> object:
    return getattr(error, "orig", None) or error


def _is_full(error: SQLAlchemyError) -> bool:
    cause = _cause(error)
    code = getattr(cause, "sqlite_errorcode", None)
    return code == sqlite3.SQLITE_FULL or getattr(cause, "sqlstate", None) == POSTGRES_DISK_FULL


def _make_engine(url: URL) -> Engine:
    if url.get_backend_name() != "sqlite":
        return create_engine(
            url, pool_size=THREADS, max_overflow=4, pool_pre_ping=True, connect_args=_server_limits(url)
        )
    if not url.database or url.database == ":memory:":
        raise ValueError("SQLite in memory cannot be shared by threads: give a file")
    _make_private_file(Path(url.database))
    engine = create_engine(url, connect_args={"timeout": BUSY_TIMEOUT_MS / 1000, "check_same_thread": False})
    event.listen(engine, "connect", _set_up_sqlite)
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def _server_limits(url: URL) -> dict[str, object]:
    """Return how long a server may keep us waiting; what the URL says itself goes first.

    Without these a lock held elsewhere, or a server whose machine is gone, holds a thread for ever.
    """
    limits: dict[str, object] = {
        "connect_timeout": SERVER_TIMEOUT_S,
        "options": f"-c lock_timeout={BUSY_TIMEOUT_MS}",
        "tcp_user_timeout": SERVER_TIMEOUT_S * 1000,
        "keepalives_idle": SERVER_TIMEOUT_S,
        "keepalives_interval": 2,
        "keepalives_count": 3,
    }
    return {key: value for key, value in limits.items() if key not in url.query}


def _make_private_file(path: Path) -> None:
    """Make the file readable by its owner only: it holds password hashes and robot tokens."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        os.close(os.open(path, os.O_RDWR | os.O_CREAT, 0o600))
    except OSError as error:
        raise DatabaseUnavailable(f"the database {path} cannot be opened: {error.strerror}") from error


def _set_up_sqlite(connection: Any, _record: Any) -> None:
    connection.isolation_level = None  # we say BEGIN ourselves, see _begin_sqlite
    cursor = connection.cursor()
    cursor.execute(f"PRAGMA busy_timeout={BUSY_TIMEOUT_MS}")
    _switch_to_wal(cursor)
    # FULL, not NORMAL: a lease epoch that a power cut takes back would let old tokens pass again.
    cursor.execute("PRAGMA synchronous=FULL")
    cursor.execute("PRAGMA foreign_keys=ON")
    cursor.close()


def _switch_to_wal(cursor: Any) -> None:
    """Two processes that open a new file at once: SQLite refuses one of them without waiting, so we wait."""
    until_s = time.monotonic() + BUSY_TIMEOUT_MS / 1000
    while cursor.execute("PRAGMA journal_mode").fetchone()[0] != "wal":
        try:
            cursor.execute("PRAGMA journal_mode=WAL")
        except sqlite3.OperationalError:
            if time.monotonic() > until_s:
                raise
            time.sleep(0.01)


def _begin_sqlite(connection: Connection) -> None:
    is_write = connection.get_execution_options().get("headland_writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if is_write else "BEGIN")

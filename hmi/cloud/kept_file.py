"""A small SQLite file of the cloud's side; every call blocks, one at a time, from any thread."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any


class OutboxUnusable(Exception):
    """The disk is full, or the file cannot be read or written; nothing of the call took effect."""

    is_for_good = False
    """No other try reads what is in the file."""


class KeptFile:
    """What outlives the process.

    Args:
        path: the file; made if it is missing.
        statements: make its tables where they are missing.
    """

    def __init__(self, path: Path, statements: Sequence[str]) -> None:
        self._path, self._statements = path, statements
        self._lock = threading.Lock()
        self._file: sqlite3.Connection | None = None

    @property
    def may_hold(self) -> bool:
        """Whether pieces of an earlier run may be in the file, as far as that is seen from outside."""
        try:
            return self._path.stat().st_size > 0
        except (FileNotFoundError, NotADirectoryError):
            return False
        except OSError:
            return True

    def close(self) -> None:
        """Close the file; the next call opens it again."""
        with self._lock:
            if self._file is not None:
                self._file.close()
                self._file = None

    def _read(self, query: str, values: tuple[float, ...]) -> list[Any]:
        try:
            return self._opened().execute(query, values).fetchall()
        except sqlite3.Error as error:
            raise self._unusable(error) from error

    def _write(self, statement: str, rows: Sequence[tuple[object, ...]]) -> int:
        """Do it for each row, all or none, and return how many rows of the file it was about."""
        try:
            with self._opened() as file:  # one transaction
                return file.executemany(statement, rows).rowcount
        except sqlite3.Error as error:
            raise self._unusable(error) from error

    def _opened(self) -> sqlite3.Connection:
        if self._file is None:
            try:
                self._path.parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise OutboxUnusable(f"{self._path.parent}: {error.strerror}") from error
            file = sqlite3.connect(self._path, timeout=1.0, check_same_thread=False)
            try:
                file.execute("PRAGMA journal_mode = WAL")
                file.execute("PRAGMA synchronous = NORMAL")  # a power cut loses the last second, never the file
                for statement in self._statements:
                    file.execute(statement)
                self._look_at(file)
            except sqlite3.Error:
                file.close()
                raise
            self._file = file
        return self._file

    def _look_at(self, file: sqlite3.Connection) -> None:
        """Take what is in a file that was opened just now."""

    def _unusable(self, error: sqlite3.Error) -> OutboxUnusable:
        if self._file is not None:  # opened anew next time: the disk may have room, or be another one
            self._file.close()
            self._file = None
        found = OutboxUnusable(f"{self._path.name}: {error}")
        # sqlite's own words: what may pass is an OperationalError, a file that is damaged or none of ours is not
        found.is_for_good = type(error) is sqlite3.DatabaseError
        return found

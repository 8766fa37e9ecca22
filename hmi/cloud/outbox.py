"""What must reach the cloud waits here on disk: in order, bounded in size and age, each piece until it is delivered."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any

_TABLE = """
CREATE TABLE IF NOT EXISTS item (
    seq INTEGER PRIMARY KEY AUTOINCREMENT, stream TEXT NOT NULL, rank INTEGER NOT NULL, at_s REAL NOT NULL,
    size INTEGER NOT NULL, body TEXT NOT NULL)
"""
_OLDEST_FIRST = "CREATE INDEX IF NOT EXISTS by_rank ON item (rank, seq)"
_TOTAL = "SELECT COUNT(*), COALESCE(SUM(size), 0) FROM item"
_OVERHEAD = 64  # bytes of a row beside its body
_PART = 256  # rows dropped at once when there is no room


class Rank(IntEnum):
    """What is dropped first when there is no room."""

    EVENT = 0
    ALARM = 1
    MISSION = 2


@dataclass(frozen=True, slots=True)
class Piece:
    """One thing to deliver.

    Args:
        stream: pieces of one stream, such as a robot, are delivered in order.
        at_s: when it happened, seconds since the epoch.
        body: the entity as key-values, JSON.
        seq: place in the order, given by the outbox.
    """

    stream: str
    rank: Rank
    at_s: float
    body: str
    seq: int = 0

    @property
    def size(self) -> int:
        """Return what it takes on disk, about."""
        return len(self.body.encode()) + _OVERHEAD


class OutboxUnusable(Exception):
    """The disk is full, or the file cannot be read or written; nothing of the call took effect."""

    is_for_good = False
    """No other try reads what is in the file."""


class Outbox:
    """A file that outlives the process. Every call blocks; one at a time, from any thread.

    Args:
        path: the file; made if it is missing.
        max_bytes: what is over it makes room, the least important first, then the oldest.
        max_age_s: what is older is dropped.
    """

    def __init__(self, path: Path, max_bytes: int, max_age_s: float) -> None:
        self._path, self._max_bytes, self._max_age_s = path, max_bytes, max_age_s
        self._lock = threading.Lock()
        self._file: sqlite3.Connection | None = None
        self._bytes = self._count = 0

    def add(self, pieces: Iterable[Piece]) -> None:
        """Keep pieces, in this order, all or none; raises ``OutboxUnusable``."""
        rows = [(one.stream, int(one.rank), one.at_s, one.size, one.body) for one in pieces]
        with self._lock:
            self._write("INSERT INTO item (stream, rank, at_s, size, body) VALUES (?, ?, ?, ?, ?)", rows)
            self._count += len(rows)
            self._bytes += sum(row[3] for row in rows)

    def first(self, limit: int, after: int = 0) -> list[Piece]:
        """Return what has waited longest and comes after a ``seq``, in order; raises ``OutboxUnusable``."""
        with self._lock:
            query = "SELECT stream, rank, at_s, body, seq FROM item WHERE seq > ? ORDER BY seq LIMIT ?"
            found = self._read(query, (after, limit))
        return [Piece(stream, Rank(rank), at_s, body, seq) for stream, rank, at_s, body, seq in found]

    def delivered(self, pieces: Sequence[Piece]) -> None:
        """Forget pieces; raises ``OutboxUnusable``."""
        self.forget({one.seq: one.size for one in pieces})

    def forget(self, sizes: Mapping[int, int]) -> None:
        """Forget pieces by ``seq``, with the size of each; raises ``OutboxUnusable``."""
        with self._lock:
            gone = self._write("DELETE FROM item WHERE seq = ?", [(seq,) for seq in sizes])
            self._count -= len(sizes)
            self._bytes -= sum(sizes.values())
            if gone != len(sizes):  # another file meanwhile
                self._recount()

    @property
    def may_hold(self) -> bool:
        """Whether pieces of an earlier run may be in the file, as far as that is seen from outside."""
        try:
            return self._path.stat().st_size > 0
        except (FileNotFoundError, NotADirectoryError):
            return False
        except OSError:
            return True

    def trim(self, now_s: float) -> int:
        """Drop what is too old and what there is no room for; return how many. Raises ``OutboxUnusable``."""
        with self._lock:
            lost = self._drop("at_s < ?", (now_s - self._max_age_s,))
            while self._bytes > self._max_bytes and self._count:
                worst = "seq IN (SELECT seq FROM item ORDER BY rank, seq LIMIT ?)"
                lost += self._drop(worst, (_PART if self._count > _PART else max(1, self._count // 2),))
        return lost

    def waiting(self) -> tuple[int, int, float | None]:
        """Return how many pieces, how many bytes, and when the oldest happened; raises ``OutboxUnusable``."""
        with self._lock:
            oldest: float | None = self._read("SELECT MIN(at_s) FROM item", ())[0][0]
            return self._count, self._bytes, oldest

    def close(self) -> None:
        """Close the file; the next call opens it again."""
        with self._lock:
            if self._file is not None:
                self._file.close()
                self._file = None

    def _drop(self, which: str, values: tuple[float, ...]) -> int:
        count, size = self._read(f"{_TOTAL} WHERE {which}", values)[0]
        if count:
            self._write(f"DELETE FROM item WHERE {which}", [values])  # noqa: S608 - of two fixed texts
            self._count -= count
            self._bytes -= size
        return int(count)

    def _read(self, query: str, values: tuple[float, ...]) -> list[Any]:
        try:
            return self._opened().execute(query, values).fetchall()
        except sqlite3.Error as error:
            raise self._unusable(error) from error

    def _recount(self) -> None:
        self._count, self._bytes = self._read(_TOTAL, ())[0]

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
                file.execute(_TABLE)
                file.execute(_OLDEST_FIRST)
                self._count, self._bytes = file.execute(_TOTAL).fetchone()
            except sqlite3.Error:
                file.close()
                raise
            self._file = file
        return self._file

    def _unusable(self, error: sqlite3.Error) -> OutboxUnusable:
        if self._file is not None:  # opened anew next time: the disk may have room, or be another one
            self._file.close()
            self._file = None
        found = OutboxUnusable(f"{self._path.name}: {error}")
        # sqlite's own words: what may pass is an OperationalError, a file that is damaged or none of ours is not
        found.is_for_good = type(error) is sqlite3.DatabaseError
        return found

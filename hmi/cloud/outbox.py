"""What must reach the cloud waits here on disk: in order, bounded in size and age, each piece until it is delivered."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

from hmi.cloud.kept_file import KeptFile

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


class Outbox(KeptFile):
    """A file that outlives the process. Every call blocks; one at a time, from any thread.

    Args:
        path: the file; made if it is missing.
        max_bytes: what is over it makes room, the least important first, then the oldest.
        max_age_s: what is older is dropped.
    """

    def __init__(self, path: Path, max_bytes: int, max_age_s: float) -> None:
        super().__init__(path, (_TABLE, _OLDEST_FIRST))
        self._max_bytes, self._max_age_s = max_bytes, max_age_s
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

    def _drop(self, which: str, values: tuple[float, ...]) -> int:
        count, size = self._read(f"{_TOTAL} WHERE {which}", values)[0]
        if count:
            self._write(f"DELETE FROM item WHERE {which}", [values])  # noqa: S608 - of two fixed texts
            self._count -= count
            self._bytes -= size
        return int(count)

    def _recount(self) -> None:
        self._count, self._bytes = self._read(_TOTAL, ())[0]

    def _look_at(self, file: sqlite3.Connection) -> None:
        self._count, self._bytes = file.execute(_TOTAL).fetchone()

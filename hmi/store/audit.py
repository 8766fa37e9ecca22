"""The audit: append-only record of who did what, each entry hashing the one before it.

``append`` never waits: a thread writes in batches. While the database cannot be written, entries go to a file beside
it; when the disk is full they wait in memory; when that is full too they are dropped, counted, shown in health, and
the gap itself becomes an entry. After a crash in the middle of taking the file back, entries may appear twice,
never not at all.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, insert, select

from hmi.clock import Clock
from hmi.store.audit_chain import GENESIS, AuditEntry, AuditLine, digest, plain_fields
from hmi.store.audit_spill import AuditSpill
from hmi.store.batch_writer import BatchWriter, WriterHealth
from hmi.store.database import Database
from hmi.store.errors import StoreError
from hmi.store.tables import AuditRow, FarmRow

logger = logging.getLogger(__name__)

CAPACITY = 10_000
RETRY_S = 1.0
_PAGE = 1000

_COLUMNS = ("farm_id", "actor", "device", "kind", "robot_id", "ref", "outcome", "text", "at", "data")
__all__ = ["Audit", "AuditEntry", "AuditHealth", "AuditLine", "AuditRecord", "AuditVerdict"]


@dataclass(frozen=True, slots=True)
class AuditRecord:
    """One entry as it was written."""

    seq: int
    farm_id: str
    at: datetime
    actor: str
    device: str
    kind: str
    robot_id: str | None
    ref: str
    outcome: str
    text: str
    data: dict[str, Any]
    hash: str


@dataclass(frozen=True, slots=True)
class AuditVerdict:
    """Result of a check; ``head`` is the newest hash: kept elsewhere, it also shows a cut-off end."""

    rows: int
    first_broken_seq: int | None
    text: str
    head: str


@dataclass(frozen=True, slots=True)
class AuditHealth:
    """How the audit is doing. ``lost`` entries could be kept nowhere."""

    writer: WriterHealth
    is_spilling: bool
    lost: int

    @property
    def is_ok(self) -> bool:
        """Whether every entry reaches the database."""
        return self.writer.is_ok and not self.is_spilling and not self.lost


class Audit:
    """The audit; every farm has a chain of its own.

    Args:
        spill_path: file for entries that the database cannot take, e.g. ``HEADLAND_DATA/audit-spill.jsonl``.
    """

    def __init__(
        self, database: Database, clock: Clock, spill_path: Path, *, capacity: int = CAPACITY, retry_s: float = RETRY_S
    ) -> None:
        self._database = database
        self._clock = clock
        self._spill = AuditSpill(spill_path)
        self._retry_s = retry_s
        self._next_try_s = 0.0
        self._lost = 0
        self._told_lost = 0
        self._writer: BatchWriter[tuple[AuditLine, datetime]] = BatchWriter(
            "audit", self._write, capacity=capacity, batch_size=500, retry_s=retry_s, on_idle=self._take_back
        )

    def start(self) -> None:
        """Start writing; takes back what an earlier run left in the file."""
        self._writer.start()

    def close(self, timeout_s: float = 2.0) -> bool:
        """Write what waits and stop; False if something was left over. Blocks."""
        return self._writer.close(timeout_s)

    def append(self, entry: AuditLine) -> None:
        """Add an entry, from any thread; returns at once and never fails."""
        if not self._writer.put((entry, self._clock.utc())):
            self._lost += 1

    def flush(self, timeout_s: float = 5.0) -> bool:
        """Wait until what was recorded so far is written or in the file; False if that takes too long. Blocks."""
        return self._writer.flush(timeout_s)

    def health(self) -> AuditHealth:
        """Return queue, spill and losses."""
        return AuditHealth(self._writer.health(), not self._spill.is_empty, self._lost)

    def recent(
        self,
        farm_id: str,
        limit: int = 100,
        *,
        before_seq: int | None = None,
        robot_id: str | None = None,
        kind: str | None = None,
        ref: str | None = None,
    ) -> list[AuditRecord]:
        """Return entries, newest first; page on with ``before_seq``. Blocks."""
        query = select(AuditRow).filter_by(farm_id=farm_id).order_by(AuditRow.seq.desc()).limit(limit)
        if before_seq is not None:
            query = query.where(AuditRow.seq < before_seq)
        for column, value in ((AuditRow.robot_id, robot_id), (AuditRow.kind, kind), (AuditRow.ref, ref)):
            query = query if value is None else query.where(column == value)
        with self._database.read() as session:
            return [_record(row) for row in session.scalars(query)]

    def verify(self, farm_id: str, expected_head: str | None = None) -> AuditVerdict:
        """Walk the whole chain and name the first row that was changed, moved, put in or taken out. Blocks.

        Args:
            expected_head: a ``head`` noted earlier; must still be in the chain.
        """
        previous, rows, seq, is_seen = GENESIS, 0, 0, expected_head in (None, GENESIS)
        while page := self._page_after(farm_id, seq):
            for row in page:
                seq = row.seq
                if row.previous_hash != previous:
                    return AuditVerdict(rows, seq, f"Entry {seq} does not follow the one before it.", previous)
                if digest(previous, _fields(row)) != row.hash:
                    return AuditVerdict(rows, seq, f"Entry {seq} was changed.", previous)
                previous, rows = row.hash, rows + 1
                is_seen = is_seen or row.hash == expected_head
        if not is_seen:
            return AuditVerdict(rows, seq + 1, "The end of the record was cut off.", previous)
        return AuditVerdict(rows, None, f"All {rows} entries are as they were written.", previous)

    def _page_after(self, farm_id: str, seq: int) -> list[AuditRow]:
        query = select(AuditRow).where(AuditRow.farm_id == farm_id, AuditRow.seq > seq)
        with self._database.read() as session:
            return list(session.scalars(query.order_by(AuditRow.seq).limit(_PAGE)))

    def _write(self, entries: Sequence[tuple[AuditLine, datetime]]) -> None:
        """Put a batch into the database, else into the file; raises only if neither can take it."""
        rows = self._plain(entries)
        if self._take_back() or not self._insert(rows):
            self._spill.append(rows)

    def _take_back(self) -> bool:
        """Bring the file's rows into the database; True while some are left."""
        if self._spill.is_empty:
            return False
        if time.monotonic() < self._next_try_s:
            return True
        rows, torn = self._spill.read()
        if not self._insert(rows):
            return True
        self._lost += torn
        self._spill.clear()
        return False

    def _insert(self, rows: list[dict[str, Any]]) -> bool:
        if time.monotonic() < self._next_try_s:
            return False
        lost = self._lost
        if lost > self._told_lost and rows:
            rows = [*rows, plain_fields(_gap(rows[-1]["farm_id"], lost - self._told_lost), self._clock.utc())]
        try:
            with self._database.connect_writing() as connection:
                homeless = _append(connection, rows)
        except StoreError:
            self._next_try_s = time.monotonic() + self._retry_s
            return False
        self._told_lost = lost
        self._lost += homeless
        return True

    def _plain(self, entries: Sequence[tuple[AuditLine, datetime]]) -> list[dict[str, Any]]:
        rows = []
        for entry, at in entries:
            try:
                rows.append(plain_fields(entry, at))
            except Exception:
                logger.exception("an audit entry cannot be written at all")
                self._lost += 1
        return rows


def _append(connection: Connection, rows: list[dict[str, Any]]) -> int:
    """Chain and insert rows; return how many were left out because their farm does not exist."""
    newest: dict[str, str | None] = {}
    chained = []
    for row in rows:
        farm_id = row["farm_id"]
        if farm_id not in newest:
            newest[farm_id] = _newest_hash(connection, farm_id)
        if (previous := newest[farm_id]) is not None:
            newest[farm_id] = hashed = digest(previous, row)
            chained.append({**row, "previous_hash": previous, "hash": hashed})
    if chained:
        connection.execute(insert(AuditRow), chained)
    return len(rows) - len(chained)


def _newest_hash(connection: Connection, farm_id: str) -> str | None:
    # The farm's row is the lock that keeps two consoles from forking the chain; SQLite has its write lock.
    farm = connection.execute(select(FarmRow.id).filter_by(id=farm_id).with_for_update()).scalar_one_or_none()
    if farm is None:
        return None
    query = select(AuditRow.hash).filter_by(farm_id=farm_id).order_by(AuditRow.seq.desc()).limit(1)
    return connection.execute(query).scalar_one_or_none() or GENESIS


def _gap(farm_id: str, count: int) -> AuditEntry:
    text = f"{count} entries could not be kept."
    return AuditEntry(farm_id, "system", "", "audit", "lost", text=text, data={"count": count})


def _fields(row: AuditRow) -> dict[str, Any]:
    return {name: getattr(row, name) for name in _COLUMNS}


def _record(row: AuditRow) -> AuditRecord:
    return AuditRecord(seq=row.seq, hash=row.hash, **_fields(row))

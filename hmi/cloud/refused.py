"""What the broker will not take is kept here with its reason, until it goes up after all or a person forgets it."""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from backend_clients.ngsi.identifier import EntityRef
from hmi.clock import Clock
from hmi.cloud.kept_file import KeptFile, OutboxUnusable
from hmi.cloud.outbox import Piece, Rank
from hmi.fiware.urn import KeyValues

MOST, MOST_BYTES = 500, 32 * 2**20
MOST_UNREAD = 20_000  # of what arrived while the file could not be read: some hours of a farm's events
MAX_WHY = 300
_TABLE = """
CREATE TABLE IF NOT EXISTS refused (
    id TEXT NOT NULL, type TEXT NOT NULL, stream TEXT NOT NULL, rank INTEGER NOT NULL, at_s REAL NOT NULL,
    body TEXT NOT NULL, why TEXT NOT NULL, refused_s REAL NOT NULL, PRIMARY KEY (id, type))
"""
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Refused:
    """One record that the broker refused.

    Args:
        piece: as it waited in the outbox.
        why: what the broker said, or what was wrong with it.
        refused_s: when it was refused last, seconds since the epoch.
    """

    ref: EntityRef
    piece: Piece
    why: str
    refused_s: float


class RefusedFile(KeptFile):
    """The file of refused records: one of each entity, the newest."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, (_TABLE,))

    def all(self) -> list[Refused]:
        """Return everything, the oldest first; raises ``OutboxUnusable``."""
        with self._lock:
            query = "SELECT id, type, stream, rank, at_s, body, why, refused_s FROM refused ORDER BY at_s"
            found = self._read(query, ())
        return [
            Refused(EntityRef(one, model), Piece(stream, Rank(rank), at_s, body), why, refused_s)
            for one, model, stream, rank, at_s, body, why, refused_s in found
        ]

    def put(self, records: Iterable[Refused]) -> None:
        """Keep records; raises ``OutboxUnusable``."""
        rows = [
            (one.ref.id, one.ref.type, one.piece.stream, int(one.piece.rank), one.piece.at_s, one.piece.body, one.why,
             one.refused_s)
            for one in records
        ]  # fmt: skip
        with self._lock:
            self._write("INSERT OR REPLACE INTO refused VALUES (?, ?, ?, ?, ?, ?, ?, ?)", rows)

    def forget(self, refs: Iterable[EntityRef]) -> None:
        """Forget records; raises ``OutboxUnusable``."""
        with self._lock:
            self._write("DELETE FROM refused WHERE id = ? AND type = ?", [(ref.id, ref.type) for ref in refs])


class RefusedRecords:
    """The refused records of one farm, in memory and on disk; on the event loop.

    Each entity is told whole, so a newer record of one makes the older of no use.

    Args:
        file: where they outlive the process; a full disk keeps them in memory only.
    """

    def __init__(self, file: RefusedFile, clock: Clock) -> None:
        self._file, self._clock = file, clock
        self._known: dict[EntityRef, Refused] = {}
        self._unsaved: set[EntityRef] = set()
        self._unforgotten: set[EntityRef] = set()
        self._is_read = False
        self._writing = asyncio.Lock()
        self.dropped = 0
        """For want of room, since the start."""
        self.again: list[EntityRef] = []
        """What is to be sent again now."""

    def all(self) -> list[Refused]:
        """Return everything, what was refused last first."""
        return sorted(self._known.values(), key=lambda one: -one.refused_s)

    async def settle(self) -> None:
        """Read what an earlier run left and write what the disk did not take before."""
        async with self._writing:
            if self._is_read and not self._unsaved and not self._unforgotten:
                return
            try:
                await self._settle()
            except OutboxUnusable as error:  # asked again in some seconds; meanwhile memory has it
                log.warning("refused records of the cloud: %s", error)
                self._is_read |= error.is_for_good

    async def _settle(self) -> None:
        if not self._is_read:
            for one in await asyncio.to_thread(self._file.all):
                if one.ref not in self._unforgotten:
                    self._known.setdefault(one.ref, one)
            self._is_read = True
        records, gone = [self._known[ref] for ref in self._unsaved], set(self._unforgotten)
        await asyncio.to_thread(self._file.put, records)
        self._unsaved -= {one.ref for one in records if self._known.get(one.ref) is one}  # or it changed meanwhile
        await asyncio.to_thread(self._file.forget, gone)
        self._unforgotten -= gone

    async def close(self) -> None:
        """Write what can be written and close the file."""
        await self.settle()
        await asyncio.to_thread(self._file.close)

    async def keep(self, found: Sequence[tuple[EntityRef, Piece, str]]) -> None:
        """Keep what was refused; without room the least important goes first, then the oldest."""
        if not found:
            return
        now_s = self._clock.utc().timestamp()
        for ref, piece, why in found:
            self._known[ref] = Refused(ref, replace(piece, seq=0), why[:MAX_WHY], now_s)
            self._unsaved.add(ref)
            self._unforgotten.discard(ref)
        size = sum(one.piece.size for one in self._known.values())
        while len(self._known) > MOST or (size > MOST_BYTES and len(self._known) > 1):
            worst = min(self._known.values(), key=lambda one: (one.piece.rank, one.piece.at_s))
            size -= worst.piece.size
            self.dropped += 1
            self._drop(worst.ref)
        await self.settle()

    async def arrived(self, refs: Collection[EntityRef]) -> None:
        """Forget what is in the cloud now: it was taken after all, or something newer of the same entity was."""
        gone = self._known.keys() & refs
        for ref in gone:
            self._drop(ref)
        if not self._is_read and len(self._unforgotten) < MOST_UNREAD:
            self._unforgotten.update(refs)  # an older record of them may be in the file
        if gone:
            await self.settle()

    async def forget_all(self) -> int:
        """Forget everything, since a person decided it; return how many there were."""
        count = len(self._known)
        await self.arrived(list(self._known))
        return count

    def send_again(self) -> None:
        """Let everything be sent again, the oldest first."""
        self.again = [one.ref for one in sorted(self._known.values(), key=lambda one: one.piece.at_s)]

    def next(self, limit: int) -> list[tuple[Refused, KeyValues]]:
        """Return what to send again now, in order, with its entity."""
        self.again = [ref for ref in self.again if ref in self._known]
        part = [self._known[ref] for ref in self.again[:limit]]
        return [(one, json.loads(one.piece.body)) for one in part]

    def _drop(self, ref: EntityRef) -> None:
        del self._known[ref]
        self._unsaved.discard(ref)
        self._unforgotten.add(ref)

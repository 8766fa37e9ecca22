"""The outbox with a bounded memory before it, so that a full disk neither stops the console nor what can be sent."""

from __future__ import annotations

import asyncio
import itertools
import logging
from dataclasses import dataclass, replace

from hmi.clock import Clock
from hmi.cloud.outbox import Outbox, OutboxUnusable, Piece

MEMORY = 5000  # pieces while the disk is full: some hours of a farm's events
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Waiting:
    """What waits.

    Args:
        oldest_s: seconds since the epoch when the oldest happened, ``None`` if nothing waits.
        lost: dropped since the start for want of room or because they were too old.
        trouble: why the disk takes nothing, empty if it does.
    """

    count: int = 0
    bytes: int = 0
    oldest_s: float | None = None
    lost: int = 0
    trouble: str = ""


class Backlog:
    """What has to be delivered: new pieces in memory until the next ``settle``, then on disk.

    ``put`` may be called on the event loop and never waits. Everything else belongs to one task.

    Args:
        outbox: the file.
        clock: for the age of pieces.
        memory: most pieces in memory.
    """

    def __init__(self, outbox: Outbox, clock: Clock, memory: int = MEMORY) -> None:
        self._outbox, self._clock, self._memory = outbox, clock, memory
        self._fresh: dict[int, Piece] = {}  # by a number below zero, in order
        self._numbers = itertools.count(1)
        self.waiting = Waiting()
        self._lost = 0

    def put(self, piece: Piece) -> None:
        """Take a piece; when even the memory is full the least important is dropped and counted."""
        number = -next(self._numbers)
        self._fresh[number] = replace(piece, seq=number)
        if len(self._fresh) > self._memory:
            worst = min(self._fresh.values(), key=lambda one: one.rank)  # the oldest of them
            del self._fresh[worst.seq]
            self._lost += 1

    async def settle(self) -> None:
        """Bring new pieces to disk and make room there; a disk that takes none is asked again next time."""
        fresh = list(self._fresh.values())
        try:
            lost = await asyncio.to_thread(self._store, fresh)
        except OutboxUnusable as error:
            if not self.waiting.trouble:
                log.warning("cloud outbox: %s; keeping %d pieces in memory", error, len(fresh))
            self._tell(trouble=str(error))
            return
        for piece in fresh:
            self._fresh.pop(piece.seq, None)
        if lost:
            log.warning("cloud outbox: %d pieces dropped, too old or no room", lost)
        self._lost += lost
        try:
            count, size, oldest_s = await asyncio.to_thread(self._outbox.waiting)
        except OutboxUnusable as error:
            self._tell(trouble=str(error))
            return
        self.waiting = Waiting(count, size, oldest_s, self._lost)

    @property
    def total(self) -> int:
        """How many pieces wait, on disk and in memory."""
        return self.waiting.count + len(self._fresh)

    async def first(self, limit: int) -> list[Piece]:
        """Return what to deliver next, in order; from memory if the disk cannot be read."""
        try:
            found = await asyncio.to_thread(self._outbox.first, limit) if self.waiting.count else []
        except OutboxUnusable as error:
            self._tell(trouble=str(error))
            found = []
        return found or list(itertools.islice(self._fresh.values(), limit))

    async def delivered(self, pieces: list[Piece]) -> None:
        """Forget pieces that arrived, or that nobody will ever take."""
        for piece in pieces:
            self._fresh.pop(piece.seq, None)
        kept = [piece for piece in pieces if piece.seq > 0]
        try:
            if kept:
                await asyncio.to_thread(self._outbox.delivered, kept)
        except OutboxUnusable as error:  # they are sent again: the same entity twice is one
            self._tell(trouble=str(error))
            return
        self._tell(trouble=self.waiting.trouble, gone=kept)

    async def close(self) -> None:
        """Bring to disk what is in memory and close the file."""
        await self.settle()
        await asyncio.to_thread(self._outbox.close)

    def _store(self, fresh: list[Piece]) -> int:
        lost = self._outbox.trim(self._clock.utc().timestamp())
        if fresh:
            self._outbox.add(fresh)
        return lost

    def _tell(self, *, trouble: str, gone: list[Piece] | None = None) -> None:
        before, away = self.waiting, gone or []
        count, size = before.count - len(away), before.bytes - sum(one.size for one in away)
        self.waiting = Waiting(count, size, before.oldest_s if count else None, self._lost, trouble)

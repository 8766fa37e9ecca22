"""The outbox with a bounded memory before it, so that a full disk neither stops the console nor what can be sent."""

from __future__ import annotations

import asyncio
import itertools
import logging
from dataclasses import dataclass, replace

from hmi.clock import Clock
from hmi.cloud.kept_file import OutboxUnusable
from hmi.cloud.outbox import Outbox, Piece

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
        self._is_counted = False
        self._done: dict[int, int] = {}  # size by seq: delivered and still in the file, which could not be written
        self._passed = 0  # everything in the file up to here is of those
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
        fresh, trouble = list(self._fresh.values()), ""
        try:
            lost = await asyncio.to_thread(self._store, fresh)
        except OutboxUnusable as error:
            if not self.waiting.trouble:
                log.warning("cloud outbox: %s; keeping %d pieces in memory", error, len(fresh))
            trouble = str(error)
        else:
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
        count, size = count - len(self._done), size - sum(self._done.values())
        self.waiting = Waiting(count, size, oldest_s if count else None, self._lost, trouble)
        self._is_counted = True

    @property
    def total(self) -> int:
        """How many pieces wait, on disk and in memory."""
        return self.waiting.count + len(self._fresh)

    @property
    def bytes(self) -> int:
        """How large they are."""
        return self.waiting.bytes + sum(piece.size for piece in self._fresh.values())

    @property
    def oldest_s(self) -> float | None:
        """Seconds since the epoch when the oldest of them happened, ``None`` if nothing waits."""
        known = [piece.at_s for piece in self._fresh.values()]
        known += [] if self.waiting.oldest_s is None else [self.waiting.oldest_s]
        return min(known, default=None)

    async def first(self, limit: int) -> list[Piece]:
        """Return what to deliver next, in order: from memory only when nothing older can be in the file."""
        try:
            found = await asyncio.to_thread(self._from_file, limit) if self._may_hold else []
        except OutboxUnusable as error:
            self._tell(trouble=str(error))
            if not error.is_for_good and self._outbox.may_hold:
                return []
            found = []
        return found or list(itertools.islice(self._fresh.values(), limit))

    async def delivered(self, pieces: list[Piece]) -> None:
        """Forget pieces that arrived, or that nobody will ever take."""
        for piece in pieces:
            self._fresh.pop(piece.seq, None)
        kept = [piece for piece in pieces if piece.seq > 0]
        self._done.update((piece.seq, piece.size) for piece in kept)
        trouble = self.waiting.trouble
        try:
            await asyncio.to_thread(self._forget)
        except OutboxUnusable as error:  # a full disk lets nothing be deleted either: they are passed over
            trouble = str(error)
        self._tell(trouble=trouble, gone=kept)

    async def close(self) -> None:
        """Bring to disk what is in memory and close the file."""
        await self.settle()
        await asyncio.to_thread(self._outbox.close)

    @property
    def _may_hold(self) -> bool:
        """Whether pieces may be in the file: as long as it was not read, nobody knows."""
        return self.waiting.count > 0 or not self._is_counted

    def _from_file(self, limit: int) -> list[Piece]:
        """Return what waits in the file beyond what was delivered and could not be deleted."""
        found: list[Piece] = []
        after = self._passed
        while len(found) < limit:
            part = self._outbox.first(limit, after)
            found += [one for one in part if one.seq not in self._done]
            if len(part) < limit:
                break
            after = part[-1].seq
        self._passed = found[0].seq - 1 if found else after
        return found[:limit]

    def _forget(self) -> None:
        if self._done:
            self._outbox.forget(self._done)
            self._done.clear()
            self._passed = 0

    def _store(self, fresh: list[Piece]) -> int:
        self._forget()  # first: what was delivered is not lost when room is made
        lost = self._outbox.trim(self._clock.utc().timestamp())
        if fresh:
            self._outbox.add(fresh)
        return lost

    def _tell(self, *, trouble: str, gone: list[Piece] | None = None) -> None:
        before, away = self.waiting, gone or []
        count = max(0, before.count - len(away))
        size = max(0, before.bytes - sum(one.size for one in away))
        self.waiting = Waiting(count, size, before.oldest_s if count else None, self._lost, trouble)

"""The evidence store: files and their records together, written by a thread of its own.

Whoever hands in a picture waits for the disk only if it wants to; the event loop never does.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import ParamSpec, TypeVar

from hmi.clock import Clock
from hmi.domain.picture import Picture
from hmi.domain.picture_retention import Retention, too_many
from hmi.store.errors import NotFound, PicturesBusy, PicturesFull, TooMuchMarked
from hmi.store.picture_files import NewestFrame, PictureFiles
from hmi.store.pictures import Held, PictureRecords

P = ParamSpec("P")
R = TypeVar("R")
MOST_WAITING = 24  # of up to 8 MB each; a disk that slow has other troubles
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ShelfHealth:
    """How keeping pictures is; ``free_bytes`` is ``None`` before the disk was asked, counts are of this process."""

    is_ok: bool
    text: str
    used_bytes: int
    marked_bytes: int
    most_bytes: int
    free_bytes: int | None
    floor_bytes: int
    kept: int
    refused: int
    removed: int


class PictureShelf:
    """Keeps, finds and removes the pictures of one farm.

    Args:
        rules: how much is kept, and what the disk must have left.
    """

    def __init__(
        self, records: PictureRecords, files: PictureFiles, farm_id: str, clock: Clock, rules: Retention
    ) -> None:
        self.records, self.files, self.rules = records, files, rules
        self._farm_id, self._clock = farm_id, clock
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="pictures")
        self._waiting = self._kept = self._refused = self._removed = 0
        self._used = self._marked = 0
        self._free: int | None = None
        self._trouble = ""

    async def prepare(self) -> None:
        """Make the folders, and bring files and records together after a crash."""
        await self._run(self._prepare)

    async def close(self) -> None:
        """Wait for what is being written."""
        await asyncio.to_thread(self._thread.shutdown)

    def health(self) -> ShelfHealth:
        """Return how it is; answers from memory."""
        return ShelfHealth(
            not self._trouble, self._trouble, self._used, self._marked, self.rules.most_bytes, self._free,
            self.rules.free_bytes, self._kept, self._refused, self._removed,
        )  # fmt: skip

    async def keep(self, one: Picture, data: bytes) -> Picture:
        """Keep a picture whose size and hash are not known yet.

        Raises:
            PicturesFull, PicturesBusy, DatabaseUnavailable: nothing was kept.
        """
        return await self._bounded(self._keep, one, data)

    async def take(self, one: Picture) -> Picture:
        """Keep a file that was written to ``files.incoming``; raises as ``keep``."""
        return await self._bounded(self._keep, one, None)

    async def set_newest_frame(self, camera: str, frame: NewestFrame) -> None:
        """Replace the newest frame of a field camera, unless this one was taken before it.

        Raises:
            PicturesFull, PicturesBusy: it was not kept.
        """
        await self._bounded(self._newest, camera, frame)

    async def newest_frame(self, camera: str) -> NewestFrame | None:
        """Return the newest frame of a field camera."""
        return await asyncio.to_thread(self.files.newest, self._farm_id, camera)

    async def forget_frames(self, camera: str) -> None:
        """Forget the newest frame of a field camera; what was kept stays."""
        await self._run(self.files.drop_newest, self._farm_id, camera)

    async def path(self, one: Picture) -> Path:
        """Return where a picture is; raises ``FileNotFoundError``."""
        return await asyncio.to_thread(self.files.path, self._farm_id, one.id, one.media_type, one.captured_at)

    async def remove(self, one: Picture) -> None:
        """Delete a picture, record first."""
        await self._run(self._remove, [(one.id, one.media_type, one.captured_at)])
        await self._run(self._count)

    async def sweep(self) -> int:
        """Look at the disk and remove what is too old or too much; return how many."""
        return await self._run(self._sweep)

    async def marked(self, one: Picture, *, note: str | None, is_kept: bool | None) -> Picture:
        """Change note and mark of a picture.

        Raises:
            NotFound: there is none.
            TooMuchMarked: the marked ones would leave too little room for what comes.
        """
        return await self._run(self._mark, one, note, is_kept)

    # ---- in the thread ----

    def _prepare(self) -> None:
        self.files.prepare()
        known = {one.id for one in self.records.held(self._farm_id)}
        for path in self.files.strays(self._farm_id, known):
            log.warning("the picture %s has no record and is removed", path.name)
            path.unlink(missing_ok=True)
        self._sweep()

    def _keep(self, one: Picture, data: bytes | None) -> Picture:
        try:
            self._check_room()
            if data is not None:
                self.files.write(one.id, one.media_type, data)
            size, digest = self.files.take(one.farm_id, one.id, one.media_type, one.captured_at)
        except BaseException:
            self.files.drop(one.id, one.media_type)
            raise
        kept = replace(one, size_bytes=size, sha256=digest)
        try:
            self.records.add(kept)
        except BaseException:
            self.files.remove(one.farm_id, one.id, one.media_type, one.captured_at)
            raise
        self._kept += 1
        self._used += size
        if self._used > self.rules.most_bytes:
            self._sweep()
        return kept

    def _newest(self, camera: str, frame: NewestFrame) -> None:
        self._check_room()
        kept_unix_s = self.files.newest_taken_unix_s(self._farm_id, camera)
        if frame.taken_unix_s < kept_unix_s <= self._clock.utc().timestamp():  # one of tomorrow had a wrong clock
            return
        self.files.set_newest(self._farm_id, camera, frame)

    def _check_room(self) -> None:
        self._free = self.files.free_bytes()
        if self._free < self.rules.free_bytes:
            self._trouble = (
                f"{self._free / 1e9:.1f} GB free; below {self.rules.free_bytes / 1e9:.1f} GB nothing is kept."
            )
            raise PicturesFull(self._trouble)
        self._trouble = ""

    def _sweep(self) -> int:
        held = self.records.held(self._farm_id)
        of = {one.id: one for one in held}
        gone = too_many(held, self._clock.utc(), self.rules)
        self._remove([(i, of[i].media_type, of[i].captured_at) for i in gone])
        self._removed += len(gone)
        self._tally([one for one in held if one.id not in set(gone)])
        try:
            self._check_room()
        except PicturesFull as error:
            log.warning("pictures are not kept: %s", error)
        except OSError as error:
            self._trouble = f"The folder cannot be used: {error.strerror}."
        return len(gone)

    def _remove(self, which: list[tuple[str, str, datetime]]) -> None:
        self.records.remove(self._farm_id, [picture_id for picture_id, _type, _at in which])
        for picture_id, media_type, at in which:
            try:
                self.files.remove(self._farm_id, picture_id, media_type, at)
            except OSError as error:  # found again as a stray at the next start
                log.warning("the picture %s could not be deleted: %s", picture_id, error)

    def _mark(self, one: Picture, note: str | None, is_kept: bool | None) -> Picture:
        now = self.records.get(one.farm_id, one.id)
        if is_kept and not now.is_kept and self.records.used(one.farm_id)[1] + now.size_bytes > self.rules.marked_bytes:
            raise TooMuchMarked(f"more than {self.rules.marked_bytes / 1e9:.1f} GB would be marked")
        changed = self.records.mark(one.farm_id, one.id, note=note, is_kept=is_kept)
        self._count()
        return changed

    def _tally(self, held: list[Held]) -> None:
        self._used = sum(one.size_bytes for one in held)
        self._marked = sum(one.size_bytes for one in held if one.is_kept)

    def _count(self) -> None:
        self._used, self._marked = self.records.used(self._farm_id)

    # ---- between ----

    async def _bounded(self, work: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        if self._waiting >= MOST_WAITING:
            self._refused += 1
            raise PicturesBusy(f"{self._waiting} pictures wait to be written")
        self._waiting += 1
        done = asyncio.get_running_loop().run_in_executor(self._thread, lambda: work(*args, **kwargs))
        done.add_done_callback(self._written)  # also when the caller gives up: the picture still waits then
        return await self._ended(done)

    def _written(self, done: asyncio.Future[R]) -> None:
        self._waiting -= 1
        if not done.cancelled() and done.exception() is not None:
            self._refused += 1

    async def _run(self, work: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        loop = asyncio.get_running_loop()
        return await self._ended(loop.run_in_executor(self._thread, lambda: work(*args, **kwargs)))

    async def _ended(self, done: asyncio.Future[R]) -> R:
        """Wait; what was begun goes on when the caller gives up. A full disk becomes ``PicturesFull``."""
        try:
            return await asyncio.shield(done)
        except FileNotFoundError as error:
            raise NotFound(f"the file {error.filename or error} is not there") from error
        except OSError as error:
            self._trouble = f"The disk does not take pictures: {error.strerror or error}."
            raise PicturesFull(self._trouble) from error

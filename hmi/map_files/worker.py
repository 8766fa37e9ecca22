"""Reading a stranger's file in a process of its own, with a bound on time and memory, that can be killed."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import pickle
import tempfile
from dataclasses import replace
from pathlib import Path

from hmi.map_files import limits
from hmi.map_files.errors import BadMapFile
from hmi.map_files.imported import Imported, MapItem
from hmi.map_files.progress import Progress, Report
from hmi.planning.side_process import SideProcess, SideProcessDied, limit_memory

READ_LIMIT_S = 120.0  # the largest file that is allowed takes a quarter of it on an idle core
PART_VERTICES = 4000  # unpacked in one go: about 10 ms
MEMORY_BYTES = 2 * 1024**3  # address space of the process; libraries alone take half a GB of it
WAITING_LIMIT = 4  # files that may wait for the one at work
PROGRESS_S = 0.25  # how often the share that is done is looked at

_TOO_LARGE = "The file needs more memory than there is for one import. Split it, or simplify its shapes."


class MapReader:
    """Reads one file at a time. Close it: a process at work does not end by itself.

    Each file gets a process of its own, so that nothing of it stays behind.

    Args:
        limit_s: a file that takes longer is given up.
    """

    def __init__(self, limit_s: float = READ_LIMIT_S, memory_bytes: int = MEMORY_BYTES) -> None:
        self._limit_s = limit_s
        self._memory_bytes = memory_bytes
        self._turn = asyncio.Lock()
        self._waiting = 0
        self._work: asyncio.Task[Imported] | None = None

    async def read(self, data: bytes, name: str, on_progress: Report | None = None) -> Imported:
        """Return what the file holds.

        Args:
            on_progress: called on this loop with how far it is, rising.

        Cancelling the task that waits here kills the process at work; nothing of the file stays.

        Raises:
            BadMapFile: see ``read_map``; and ``too_long``, ``too_large``, ``cancelled``, ``busy``.
        """
        if len(data) > limits.FILE_BYTES:
            raise BadMapFile("too_large", f"The file is larger than {limits.FILE_BYTES // 1_000_000} MB. Split it.")
        if self._waiting >= WAITING_LIMIT:
            raise BadMapFile("busy", "Other files are being read. Try again in a minute.")
        self._waiting += 1
        try:
            async with self._turn:
                return await self._read(data, name, on_progress or (lambda progress: None))
        finally:
            self._waiting -= 1

    def cancel(self) -> None:
        """Give up the file at work; its ``read`` raises ``BadMapFile`` with the code ``cancelled``."""
        if self._work is not None:
            self._work.cancel()

    async def close(self) -> None:
        """Give up the file at work and wait until its process is gone."""
        self.cancel()
        if self._work is not None:
            await asyncio.wait({self._work})

    async def _read(self, data: bytes, name: str, on_progress: Report) -> Imported:
        with tempfile.TemporaryDirectory(prefix="headland-import-") as folder:
            share = Path(folder) / "share"
            work = asyncio.create_task(self._run(data, name, share), name="map-read")
            self._work = work
            watch = asyncio.create_task(_watch(share, on_progress), name="map-read-progress")
            try:
                await asyncio.wait({work}, timeout=self._limit_s)
                is_late = not work.done()
                return await _outcome(work, is_late=is_late, limit_s=self._limit_s)
            finally:
                work.cancel()
                watch.cancel()
                await asyncio.wait({work, watch})
                self._work = None

    async def _run(self, data: bytes, name: str, share: Path) -> Imported:
        process = SideProcess()
        try:
            return await _joined(await process.run(_read_bounded, data, name, str(share), self._memory_bytes))
        except SideProcessDied as error:
            raise BadMapFile("too_large", _TOO_LARGE) from error
        finally:
            await asyncio.shield(asyncio.to_thread(process.close))


async def _outcome(work: asyncio.Task[Imported], *, is_late: bool, limit_s: float) -> Imported:
    if is_late:
        text = f"Reading the file took more than {limit_s:g} s. Split it, or simplify its shapes."
        raise BadMapFile("too_long", text)
    if work.cancelled():
        raise BadMapFile("cancelled", "The import was given up.")
    return work.result()


async def _watch(share: Path, on_progress: Report) -> None:
    told = Progress(0.0)
    while True:
        await asyncio.sleep(PROGRESS_S)
        with contextlib.suppress(OSError, ValueError):
            done, shapes = (await asyncio.to_thread(share.read_text, encoding="ascii")).split()
            now = Progress(float(done), int(shapes))
            if now > told:
                told = now
                on_progress(told)


async def _joined(parts: list[bytes]) -> Imported:
    """Unpack what the process found, a little at a time: nobody else on this loop waits for a large file."""
    imported: Imported = pickle.loads(parts[0])  # noqa: S301 - from our own process, as its pool itself does
    items: list[MapItem] = []
    for part in parts[1:]:
        items += await asyncio.to_thread(pickle.loads, part)
    return replace(imported, items=tuple(items))


def _parts(imported: Imported) -> list[bytes]:
    """Pack a file, first without its items, then these in parts of about ``PART_VERTICES`` corners."""
    parts = [pickle.dumps(replace(imported, items=()))]
    part: list[MapItem] = []
    corners = 0
    for item in imported.items:
        part.append(item)
        corners += item.vertices
        if corners >= PART_VERTICES:
            parts.append(pickle.dumps(part))
            part, corners = [], 0
    return [*parts, pickle.dumps(part)]


def _read_bounded(data: bytes, name: str, share: str, memory_bytes: int) -> list[bytes]:
    """Read within the memory allowed; runs in the side process."""
    from hmi.map_files.reader import read_map  # the console itself reads no files

    limit_memory(memory_bytes)
    gc.disable()  # the process ends with the file; collecting would take most of the time of a large one
    try:
        return _parts(read_map(data, name, lambda done: _tell(share, done)))
    except MemoryError as error:
        raise BadMapFile("too_large", _TOO_LARGE) from error


def _tell(share: str, done: Progress) -> None:
    with contextlib.suppress(OSError):
        Path(share).write_text(f"{done.share:.3f} {done.shapes}", encoding="ascii")

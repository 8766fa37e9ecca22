"""Uploaded base maps are read and converted in a process of its own, bounded in time and memory, that can be killed."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import os
import time
from collections.abc import Callable
from pathlib import Path

from hmi.base_maps import limits
from hmi.base_maps.errors import BadBaseMap
from hmi.base_maps.facts import BaseMapFacts, MadeBaseMap
from hmi.base_maps.inspection import inspect_archive
from hmi.planning.side_process import SideProcess, SideProcessDied, limit_memory

PROGRESS_S = 0.5  # how often the share that is done is looked at
TOLD_S = 0.25
NICENESS = 15  # live values and commands go first
TIFF_MARKS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
PMTILES_MARK = b"PMTiles"

_TOO_LARGE = "The file needs more memory than there is for one base map. Save it tiled and cut it to the farm."
_UNKNOWN = "This is neither an aerial photo (GeoTIFF, .tif) nor a tile archive (PMTiles, .pmtiles)."
_TIMES = "Working on this file took more than {minutes:.0f} minutes. Cut it to the farm, or save it with larger pixels."


class BaseMapMaker:
    """Makes one base map at a time; others wait. Close it: a process at work does not end by itself.

    Args:
        limit_s: a photo that takes longer is given up.
    """

    def __init__(
        self, limit_s: float = limits.CONVERT_LIMIT_S, memory_bytes: int = limits.MEMORY_BYTES, niceness: int = NICENESS
    ) -> None:
        self._limit_s, self._memory_bytes, self._niceness = limit_s, memory_bytes, niceness
        self._turn = asyncio.Lock()

    async def make(
        self, source: Path, target: Path, most_bytes: int, on_progress: Callable[[float], None]
    ) -> MadeBaseMap:
        """Turn an uploaded file into a tile archive at ``target``; cancelling kills the process.

        Args:
            target: new file; its folder is the process's own place for temporary files.
            most_bytes: how large the archive may become.
            on_progress: called on this loop with the share that is done, 0 to 1, rising.

        Raises:
            BadBaseMap: the file is refused.
        """
        async with self._turn:
            share = target.with_suffix(".share")
            watch = asyncio.create_task(_watch(share, on_progress), name="base-map-progress")
            process = SideProcess()
            try:
                work = process.run(
                    _made, str(source), str(target), str(share), most_bytes, self._memory_bytes, self._niceness
                )
                return await asyncio.wait_for(work, self._limit_s)
            except TimeoutError as error:
                raise BadBaseMap("too_long", _TIMES.format(minutes=max(1, self._limit_s / 60))) from error
            except SideProcessDied as error:
                raise BadBaseMap("too_large", _TOO_LARGE) from error
            finally:
                watch.cancel()
                await asyncio.wait({watch})
                await asyncio.shield(asyncio.to_thread(process.close))


async def _watch(share: Path, on_progress: Callable[[float], None]) -> None:
    told = 0.0
    while True:
        await asyncio.sleep(PROGRESS_S)
        with contextlib.suppress(OSError, ValueError):
            now = float(await asyncio.to_thread(share.read_text, encoding="ascii"))
            if now > told:
                told = now
                on_progress(told)


def _made(
    source: str, target: str, share: str, most_bytes: int, memory_bytes: int, niceness: int
) -> MadeBaseMap:  # runs in the side process
    limit_memory(memory_bytes)
    if hasattr(os, "nice"):
        os.nice(niceness)
    try:
        facts = make_base_map(Path(source), Path(target), most_bytes, _Teller(Path(share)))
        with Path(target).open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        return MadeBaseMap(facts, digest, Path(target).stat().st_size)
    except MemoryError as error:
        raise BadBaseMap("too_large", _TOO_LARGE) from error


def make_base_map(source: Path, target: Path, most_bytes: int, told: Callable[[float], None]) -> BaseMapFacts:
    """Turn a file into a tile archive, in this process; raises ``BadBaseMap``."""
    with source.open("rb") as file:
        mark = file.read(8)
    if mark.startswith(TIFF_MARKS):
        from hmi.base_maps.photo import convert_photo

        return convert_photo(source, target, most_bytes, told)
    if not mark.startswith(PMTILES_MARK):
        raise BadBaseMap("unknown_format", _UNKNOWN)
    size = source.stat().st_size
    if size > most_bytes:
        text = f"The file has {size // 1_000_000} MB, but {most_bytes // 1_000_000} MB are left for base maps."
        raise BadBaseMap("no_room", text + " Delete one that is not needed.")
    facts = inspect_archive(source)
    source.replace(target)
    return facts


class _Teller:
    """Writes the share that is done where the console looks for it, not at every tile."""

    def __init__(self, share: Path) -> None:
        self._share = share
        self._next_s = 0.0

    def __call__(self, done: float) -> None:
        now_s = time.monotonic()
        if now_s < self._next_s:
            return
        self._next_s = now_s + TOLD_S
        with contextlib.suppress(OSError):
            self._share.write_text(f"{done:.3f}", encoding="ascii")

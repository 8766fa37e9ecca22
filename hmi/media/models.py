"""Models that admins uploaded: read in a process of their own, kept by robot."""

from __future__ import annotations

import asyncio
import shutil
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from backend_clients.edge.topics import check_id
from hmi.planning.side_process import SideProcess, SideProcessDied, limit_memory
from hmi.twin.errors import ModelError, UnsafeModel
from hmi.twin.limits import CHUNK_LIMIT_S, MAX_ZIP_BYTES, READ_LIMIT_S, READ_MEMORY_BYTES, STALLED
from hmi.twin.upload import MODEL, describe, load_kept, read_upload

FOLDER = "models"


class ModelShelf:
    """The uploads of one installation: any number come in, one is read at a time."""

    def __init__(self, data: Path) -> None:
        self.folder = data / FOLDER
        self._reader = SideProcess()
        self._one = asyncio.Lock()

    async def take(self, robot_id: str, chunks: AsyncIterator[bytes]) -> dict[str, Any]:
        """Read a zip as it comes and keep its model for a robot.

        Raises:
            ModelError: see ``hmi.twin.errors``; the model before stays.
        """
        target = self.folder / check_id(robot_id)
        self.folder.mkdir(parents=True, exist_ok=True)
        archive = Path(tempfile.mkstemp(dir=self.folder, suffix=".part")[1])
        try:
            await _save(chunks, archive)
            async with self._one:
                return await self._read(archive, target)
        finally:
            await asyncio.to_thread(archive.unlink, missing_ok=True)

    async def _read(self, archive: Path, target: Path) -> dict[str, Any]:
        try:
            async with asyncio.timeout(READ_LIMIT_S):
                return await self._reader.run(_read_bounded, archive, target)
        except TimeoutError as error:
            raise UnsafeModel(f"Reading the model took over {READ_LIMIT_S:.0f} s. Simplify its meshes.") from error
        except SideProcessDied as error:
            raise UnsafeModel("Reading the model took too much memory. Simplify its meshes.") from error
        finally:
            self._reader.close()

    async def describe(self, robot_id: str) -> dict[str, Any]:
        """Return what is known of a robot's own model; ``{"kept": False}`` without one."""
        target = self.folder / check_id(robot_id)
        if not (target / MODEL).is_file():
            return {"kept": False}
        model, skin = await asyncio.to_thread(load_kept, target)
        return {"kept": True, **describe(model, skin.faces)}

    async def remove(self, robot_id: str) -> bool:
        """Drop a robot's own model; return whether there was one."""
        target = self.folder / check_id(robot_id)
        if not target.is_dir():
            return False
        await asyncio.to_thread(shutil.rmtree, target)
        return True


def _read_bounded(archive: Path, target: Path) -> dict[str, Any]:
    limit_memory(READ_MEMORY_BYTES)
    try:
        return read_upload(archive, target)
    except MemoryError as error:
        raise UnsafeModel("Reading the model took too much memory. Simplify its meshes.") from error


async def _save(chunks: AsyncIterator[bytes], archive: Path) -> None:
    size = 0
    with archive.open("wb") as file:
        while (chunk := await _next(chunks)) is not None:
            size += len(chunk)
            if size > MAX_ZIP_BYTES:
                raise ModelError(f"The upload is over {MAX_ZIP_BYTES // 2**20} MB.")
            await asyncio.to_thread(file.write, chunk)


async def _next(chunks: AsyncIterator[bytes]) -> bytes | None:
    """Return the next piece, ``None`` at the end; an upload that stands still is given up."""
    try:
        async with asyncio.timeout(CHUNK_LIMIT_S):
            return await anext(chunks, None)
    except TimeoutError as error:
        raise ModelError(STALLED) from error

"""Uploads that become base maps: each has a place on disk, a share that is done, and an end."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from hmi.base_maps.errors import BadBaseMap

BUFFER_BYTES = 1_000_000  # written at once, in a thread
MOST_WORK = 3  # uploads of a farm at a time, the one being converted included
FAILED_KEPT = 5
SENDING, WAITING, WORKING, FAILED = "sending", "waiting", "working", "failed"


@dataclass(slots=True)
class Work:
    """One upload on its way.

    Attributes:
        state: ``sending``, ``waiting`` for another one, ``working``, ``failed``.
        share: what is done of the conversion, 0 to 1.
        text: why it failed.
    """

    id: str
    farm_id: str
    file_name: str
    name: str
    by: str
    user_id: str
    folder: Path
    size_bytes: int = 0
    state: str = SENDING
    share: float = 0.0
    code: str = ""
    text: str = ""
    task: asyncio.Task[None] | None = None

    @property
    def upload(self) -> Path:
        """The file as it was sent."""
        return self.folder / "upload"

    @property
    def made(self) -> Path:
        """The archive that is made of it."""
        return self.folder / "made"


class WorkList:
    """What is being uploaded and converted, and what failed and was not dismissed yet."""

    def __init__(self) -> None:
        self._all: dict[str, Work] = {}

    def of(self, farm_id: str) -> list[Work]:
        """Return the work of a farm, oldest first."""
        return [one for one in self._all.values() if one.farm_id == farm_id]

    def get(self, farm_id: str, work_id: str) -> Work | None:
        """Return one piece of work of this farm."""
        found = self._all.get(work_id)
        return found if found is not None and found.farm_id == farm_id else None

    def tasks(self) -> list[asyncio.Task[None]]:
        """Return what runs."""
        return [one.task for one in self._all.values() if one.task is not None]

    def check_room(self, farm_id: str) -> None:
        """Refuse more than a few at a time; raises ``BadBaseMap``."""
        if sum(one.state != FAILED for one in self.of(farm_id)) >= MOST_WORK:
            raise BadBaseMap("busy", "Other base maps are being made. Wait until one is ready, or cancel it.")

    def add(self, work: Work) -> None:
        """Take new work; the oldest failures make room."""
        failed = [one.id for one in self.of(work.farm_id) if one.state == FAILED]
        for one in failed[: max(0, len(failed) - FAILED_KEPT + 1)]:
            del self._all[one]
        self._all[work.id] = work

    def drop(self, work: Work) -> None:
        """Forget it."""
        self._all.pop(work.id, None)


async def written(work: Work, chunks: AsyncIterator[bytes], most_bytes: int, too_large: BadBaseMap) -> None:
    """Write an upload to disk as it comes; raises ``too_large`` once it has more than ``most_bytes``."""
    waiting: list[bytes] = []
    held = 0
    file = await asyncio.to_thread(work.upload.open, "wb")
    try:
        async for chunk in chunks:
            work.size_bytes += len(chunk)
            if work.size_bytes > most_bytes:
                raise too_large
            waiting.append(chunk)
            held += len(chunk)
            if held >= BUFFER_BYTES:
                await asyncio.to_thread(_write, file, waiting)
                waiting, held = [], 0
        await asyncio.to_thread(_write, file, waiting)
    except OSError as error:
        raise BadBaseMap("no_disk", "The disk of the server did not take the file. Tell an admin.") from error
    finally:
        await asyncio.to_thread(file.close)


def _write(file: BinaryIO, chunks: list[bytes]) -> None:
    file.writelines(chunks)

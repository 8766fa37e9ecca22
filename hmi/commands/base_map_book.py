"""The base maps of a farm: who may add, rename and delete them, how much room they take, and their tiles."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol

from hmi.base_maps.errors import BadBaseMap
from hmi.base_maps.facts import MadeBaseMap
from hmi.base_maps.files import BaseMapFiles
from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.base_map_work import FAILED, WAITING, WORKING, Work, WorkList, written
from hmi.commands.ports import AuditSink, LaneEvent
from hmi.domain.ids import new_id
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.base_maps import BaseMapRecords, StoredBaseMap
from hmi.store.database import Database
from hmi.store.errors import AlreadyExists, NotFound, StoreError

MB = 1_000_000
log = logging.getLogger(__name__)
_GONE = "The file of this base map is gone from the server. Delete it and upload it again."


class Maker(Protocol):
    """Turns an upload into a tile archive; ``hmi.base_maps.worker.BaseMapMaker`` is one."""

    async def make(
        self, source: Path, target: Path, most_bytes: int, on_progress: Callable[[float], None]
    ) -> MadeBaseMap:
        """Return what was made at ``target``; raises ``BadBaseMap``."""
        ...


@dataclass(frozen=True, slots=True)
class BaseMapParts:
    """What the book is wired to.

    Attributes:
        farm_bytes: room for all base maps of a farm.
        upload_bytes: largest file to upload.
    """

    records: BaseMapRecords
    files: BaseMapFiles
    maker: Maker
    database: Database
    authorize: Authorize
    audit: AuditSink
    clock: Clock
    on_event: LaneEvent
    farm_bytes: int
    upload_bytes: int


@dataclass(frozen=True, slots=True)
class Shelf:
    """What a farm has: maps with whether their file is there, work, and room."""

    maps: list[tuple[StoredBaseMap, bool]]
    work: list[Work]
    used_bytes: int
    farm_bytes: int
    upload_bytes: int


@dataclass(frozen=True, slots=True)
class Tile:
    """A tile as it is stored; ``data`` is ``None`` where the map has none."""

    data: bytes | None
    media_type: str
    is_packed: bool
    version: str


class BaseMapBook:
    """Answers everything about base maps.

    Raises (every method): ``NotSignedIn``, ``NotAllowed``, ``StoreError`` and what it names itself.
    """

    def __init__(self, parts: BaseMapParts) -> None:
        self._parts = parts
        self._run = parts.database.run
        self._work = WorkList()
        self._known: dict[str, dict[str, StoredBaseMap]] = {}  # tiles come by the dozen: no query for each

    async def prepare(self) -> None:
        """Throw away uploads of an earlier process."""
        await asyncio.to_thread(self._parts.files.prepare)

    async def close(self) -> None:
        """Give up what is being made."""
        tasks = self._work.tasks()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def shelf(self, session: SessionInfo) -> Shelf:
        """Return what the farm has and what is on its way."""
        self._parts.authorize(session, Permission.WATCH)
        parts, farm_id = self._parts, session.farm_id
        work = self._work.of(farm_id)  # before the maps: what becomes ready between them must not be in neither
        maps = await self._run(parts.records.all, farm_id)
        ready = self._known[farm_id] = {one.id: one for one in maps}
        there = await asyncio.to_thread(lambda: [parts.files.is_there(farm_id, one.sha256) for one in maps])
        used = sum(one.size_bytes for one in maps)
        return Shelf(
            maps=list(zip(maps, there, strict=True)),
            work=[one for one in work if one.id not in ready],
            used_bytes=used,
            farm_bytes=parts.farm_bytes,
            upload_bytes=parts.upload_bytes,
        )

    async def receive(
        self, session: SessionInfo, file_name: str, name: str, announced: int | None, chunks: AsyncIterator[bytes]
    ) -> Work:
        """Take an upload and begin to make a base map of it.

        Args:
            announced: size of the file in bytes, if the browser told it.

        Raises:
            BadBaseMap: it is too large, there is no room, or others are at work.
        """
        parts = self._parts
        parts.authorize(session, Permission.EDIT_MAP)
        self._work.check_room(session.farm_id)
        too_large = BadBaseMap("too_large", f"The file is larger than {parts.upload_bytes // MB} MB. Cut the photo.")
        if (announced or 0) > parts.upload_bytes:
            raise too_large
        await self._room(session.farm_id)
        free = await asyncio.to_thread(parts.files.free_bytes)
        if (announced or 1) > free:
            raise BadBaseMap("no_disk", f"The disk of the server has {free // MB} MB left for this. Tell an admin.")
        work_id = new_id()
        folder = await asyncio.to_thread(parts.files.begin, work_id)
        work = Work(work_id, session.farm_id, file_name, name, session.user_name, session.user_id, folder)
        self._work.add(work)
        try:
            await written(work, chunks, min(parts.upload_bytes, free), too_large)
            parts.authorize(session, Permission.EDIT_MAP)  # an hour may have gone by
        except BaseException:
            self._work.drop(work)
            await asyncio.shield(asyncio.to_thread(parts.files.end, work_id))
            raise
        work.state = WAITING
        work.task = asyncio.create_task(self._make(session, work), name=f"base-map-{work_id}")
        return work

    async def rename(self, session: SessionInfo, base_map_id: str, name: str, credit: str) -> StoredBaseMap:
        """Give a base map another name and credit; raises ``NotFound``."""
        self._parts.authorize(session, Permission.EDIT_MAP)
        stored = await self._run(self._parts.records.describe, session.farm_id, base_map_id, name, credit)
        self._changed(session.farm_id, "renamed", base_map_id)
        self._audit(session, "renamed", f"Base map is called {name} now.", base_map_id)
        return stored

    async def remove(self, session: SessionInfo, base_map_id: str) -> None:
        """Delete a base map with its file, or give up one that is being made; raises ``NotFound``."""
        self._parts.authorize(session, Permission.EDIT_MAP)
        work = self._work.get(session.farm_id, base_map_id)
        if work is not None:
            await self._give_up(session, work)
            return
        stored = await self._run(self._parts.records.remove, session.farm_id, base_map_id)
        await asyncio.to_thread(self._parts.files.remove, session.farm_id, stored.sha256)
        self._changed(session.farm_id, "removed", base_map_id)
        self._audit(session, "removed", f"Base map {stored.name} deleted.", base_map_id)

    async def tile(self, session: SessionInfo, base_map_id: str, z: int, x: int, y: int) -> Tile:
        """Return one tile.

        Raises:
            NotFound: the farm has no such base map.
            BadBaseMap: its file is gone or damaged.
        """
        self._parts.authorize(session, Permission.WATCH)
        one = await self._stored(session.farm_id, base_map_id)
        try:
            return await asyncio.to_thread(self._tile, one, z, x, y)
        except OSError as error:
            raise BadBaseMap("file_gone", _GONE) from error

    def _tile(self, one: StoredBaseMap, z: int, x: int, y: int) -> Tile:
        archive = self._parts.files.archive(one.farm_id, one.sha256)
        return Tile(archive.tile(z, x, y), archive.media_type, archive.is_packed, one.sha256[:16])

    async def _stored(self, farm_id: str, base_map_id: str) -> StoredBaseMap:
        found = self._known.get(farm_id, {}).get(base_map_id)
        if found is None:
            maps = await self._run(self._parts.records.all, farm_id)
            self._known[farm_id] = {one.id: one for one in maps}
            found = self._known[farm_id].get(base_map_id)
        if found is None:
            raise NotFound(f"there is no base map {base_map_id}")
        return found

    async def _room(self, farm_id: str) -> int:
        """Return how many bytes a new base map may have; raises ``BadBaseMap`` when there are none."""
        maps = await self._run(self._parts.records.all, farm_id)
        left = self._parts.farm_bytes - sum(one.size_bytes for one in maps)
        if left <= 0:
            text = f"The base maps of this farm fill their {self._parts.farm_bytes // MB} MB. Delete one first."
            raise BadBaseMap("no_room", text)
        return left

    async def _make(self, session: SessionInfo, work: Work) -> None:
        try:
            left = await self._room(work.farm_id)
            made = await self._parts.maker.make(work.upload, work.made, left, lambda share: _progress(work, share))
            await self._keep(session, work, made)
            self._work.drop(work)
        except BadBaseMap as error:
            self._failed(session, work, error.code, error.text)
        except StoreError as error:
            log.warning("a base map was not kept: %s", error)
            self._failed(session, work, "database_unavailable", "The records cannot be used right now. Try again.")
        except OSError as error:
            log.warning("a base map was not kept: %s", error)
            self._failed(session, work, "no_disk", "The disk of the server did not take the file. Tell an admin.")
        except Exception:  # the end of a task: nobody above would say it
            log.exception("a base map was not made")
            self._failed(session, work, "failed", "Something went wrong here. It was written to the log.")
        finally:
            work.task = None
            await asyncio.shield(asyncio.to_thread(self._parts.files.end, work.id))

    async def _keep(self, session: SessionInfo, work: Work, made: MadeBaseMap) -> None:
        facts, parts = made.facts, self._parts
        stored = StoredBaseMap(
            id=work.id, farm_id=work.farm_id, name=work.name, kind=facts.kind.value, **asdict(facts.bounds),
            min_zoom=facts.min_zoom, max_zoom=facts.max_zoom, tile_px=facts.tile_px, schema=facts.schema,
            media_type=facts.media_type, credit=facts.credit, size_bytes=made.size_bytes, sha256=made.sha256,
            by=work.by, added_at=parts.clock.utc(),
        )  # fmt: skip
        there = {one.sha256: one.name for one in await self._run(parts.records.all, work.farm_id)}
        if made.sha256 in there:
            raise BadBaseMap("already_there", f"The farm has this base map already: {there[made.sha256]}.")
        await asyncio.to_thread(parts.files.keep, work.made, work.farm_id, made.sha256)
        await asyncio.to_thread(parts.files.end, work.id)  # before anybody is told that it is ready
        try:
            await self._run(parts.records.add, stored)
        except AlreadyExists as error:  # the same file came twice at once: its archive is the other's now
            raise BadBaseMap("already_there", "The farm has this base map already.") from error
        self._changed(work.farm_id, "ready", work.id)
        self._audit(session, "added", f"Base map {work.name} added.", work.id)

    async def _give_up(self, session: SessionInfo, work: Work) -> None:
        task = work.task
        if task is not None:
            task.cancel()
            await asyncio.wait({task})
        self._work.drop(work)
        if work.state != FAILED:
            self._changed(work.farm_id, "cancelled", work.id)
            self._audit(session, "cancelled", f"Base map {work.name} given up.", work.id)

    def _failed(self, session: SessionInfo, work: Work, code: str, text: str) -> None:
        work.state, work.code, work.text = FAILED, code, text
        self._changed(work.farm_id, "failed", work.id)
        self._audit(session, "refused", f"Base map {work.name} was not made: {text}", work.id)

    def _changed(self, farm_id: str, what: str, base_map_id: str) -> None:
        self._known.pop(farm_id, None)
        self._parts.on_event({"kind": "base_map", "what": what, "id": base_map_id})

    def _audit(self, session: SessionInfo, outcome: str, text: str, ref: str) -> None:
        self._parts.audit.append(audit_line(session, "map", outcome, text, ref=ref))


def _progress(work: Work, share: float) -> None:
    work.state, work.share = WORKING, share

"""Map files in and out: a file is read beside this process, looked at by a person, and taken over in one step."""

from __future__ import annotations

import asyncio
import re
from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from hmi.commands.map_book import MapBook
from hmi.domain.ids import new_id
from hmi.domain.map_log import FeatureChange, MapFeatures
from hmi.domain.role import Permission
from hmi.map_files.errors import BadMapFile
from hmi.map_files.exported import MapFile
from hmi.map_files.imported import Imported, MapItem
from hmi.map_files.own_words import settled
from hmi.map_files.progress import Progress, Report
from hmi.mapping.attributes import LONGEST_NAME
from hmi.mapping.feature import parse_feature
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.errors import NotFound
from hmi.store.maps import MapDraft

if TYPE_CHECKING:
    from hmi.mapping.row_field import Parcels

WORD_CHARS = 56  # of an id: leaves room for a number
KEPT = 4  # read files a farm may have waiting for a choice
_NO_ID = re.compile(r"[^a-z0-9]+")


class Reader(Protocol):
    """Reads a map file in bounded time and memory; ``hmi.map_files.worker.MapReader`` is one."""

    async def read(self, data: bytes, name: str, on_progress: Report | None = None) -> Imported:
        """Return what the file holds; raises ``BadMapFile``. Cancelling ends the work and leaves nothing."""
        ...


@dataclass(frozen=True, slots=True)
class Waiting:
    """A read file of which somebody has still to choose."""

    id: str
    farm_id: str
    name: str
    content: Imported


@dataclass(slots=True)
class Reading:
    """A file that is being read now."""

    farm_id: str
    task: asyncio.Task[Imported]
    progress: Progress = field(default_factory=lambda: Progress(0.0))


class MapExchange:
    """Imports and exports.

    Raises (every method): ``NotSignedIn``, ``NotAllowed``, ``StoreError``, ``BadMapFile`` and what it names itself.
    """

    def __init__(self, book: MapBook, reader: Reader, authorize: Authorize, farm_name: str) -> None:
        self._book, self._reader, self._authorize, self._farm_name = book, reader, authorize, farm_name
        self._waiting: OrderedDict[str, Waiting] = OrderedDict()
        self._reading: dict[str, Reading] = {}

    async def read(self, session: SessionInfo, data: bytes, name: str, ref: str | None = None) -> Waiting:
        """Read a file; nothing of it is in the map yet.

        Args:
            ref: names the work while it goes on, for ``progress`` and ``cancel``.
        """
        self._authorize(session, Permission.EDIT_MAP)
        ref = ref or new_id()
        if ref in self._reading:
            raise BadMapFile("busy", "This import is being read already.")
        work = self._reader.read(data, name, lambda progress: self._told(ref, progress))
        self._reading[ref] = Reading(session.farm_id, asyncio.create_task(work, name="map-reading"))
        try:
            content = await self._outcome(self._reading[ref].task)
        finally:
            del self._reading[ref]
        waiting = Waiting(new_id()[:16], session.farm_id, name, content)
        self._waiting[waiting.id] = waiting
        own = [one.id for one in self._waiting.values() if one.farm_id == session.farm_id]
        for key in own[:-KEPT]:
            del self._waiting[key]
        return waiting

    def progress(self, session: SessionInfo, ref: str) -> Progress:
        """Return how far the file named ``ref`` is read; raises ``NotFound`` when it is not being read."""
        self._authorize(session, Permission.EDIT_MAP)
        return self._own(session, ref).progress

    def cancel(self, session: SessionInfo, ref: str) -> None:
        """Give up a file that is being read, or forget one that waits for a choice; raises ``NotFound``."""
        self._authorize(session, Permission.EDIT_MAP)
        waiting = self._waiting.get(ref)
        if waiting is not None and waiting.farm_id == session.farm_id:
            del self._waiting[ref]
        else:
            self._own(session, ref).task.cancel()

    def _own(self, session: SessionInfo, ref: str) -> Reading:
        reading = self._reading.get(ref)
        if reading is None or reading.farm_id != session.farm_id:
            raise NotFound("this import is not there any more")
        return reading

    def _told(self, ref: str, progress: Progress) -> None:
        if ref in self._reading:
            self._reading[ref].progress = progress

    async def _outcome(self, task: asyncio.Task[Imported]) -> Imported:
        try:
            await asyncio.wait({task})
        finally:
            task.cancel()  # whoever waited is gone; a finished task is not touched by this
        if task.cancelled():
            raise BadMapFile("cancelled", "The import was given up. Nothing of it was kept.")
        return task.result()

    async def take(
        self, session: SessionInfo, import_id: str, ref: str, chosen: Sequence[int], kinds: Mapping[str, str]
    ) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        """Put the chosen items into the draft as one step; an id that the map has already gets a number,
        and what names it in the same take names it by its new id. Rows that name no parcel get the one they lie in.
        The same ``ref`` again changes nothing.

        Raises:
            NotFound: this import is not there any more, or there is no draft.
            BadFeature, MapLocked, ChangedMeanwhile: see ``MapBook.change``.
        """
        self._authorize(session, Permission.EDIT_MAP)
        if (made := await self._book.made(session, ref)) is not None:
            return made
        waiting = self._waiting.get(import_id)
        draft = await self._book.draft(session)
        if waiting is None or waiting.farm_id != session.farm_id or draft is None:
            raise NotFound("this import is not there any more")
        items = {one.n: one for one in waiting.content.items}
        taken = [items[n] for n in dict.fromkeys(chosen) if n in items]
        if not taken:
            raise BadMapFile("nothing_chosen", "Nothing was chosen to take over.")
        wished = [(one, kinds.get(str(one.n), one.kind)) for one in taken]
        changes = await asyncio.to_thread(_changes, wished, draft.features)
        what = "1 feature" if len(changes) == 1 else f"{len(changes)} features"
        return await self._book.change(session, ref, f"Imported {what}, {waiting.name}"[:200], changes)

    async def export(self, session: SessionInfo, file_format: str, *, is_draft: bool) -> MapFile:
        """Return the published map or the draft as a file; raises ``NotFound`` without a draft."""
        self._authorize(session, Permission.WATCH)
        if is_draft:
            draft = await self._book.draft(session)
            if draft is None:
                raise NotFound("there is no draft of this map")
            raw = draft.features
        else:
            raw = (await self._book.published(session))[1]
        return await asyncio.to_thread(self._written, raw, file_format, session.farm_id)

    def _written(self, raw: MapFeatures, file_format: str, farm_id: str) -> MapFile:
        from hmi.map_files.writer import write_map  # formats, geometry and all: not for a console's start

        features = [parse_feature(one) for one in raw.values()]
        return write_map(features, file_format, farm_id, self._farm_name)


def _changes(taken: Sequence[tuple[MapItem, str]], there: MapFeatures) -> list[FeatureChange]:
    ids = _FreeIds(there)
    named = [(item, kind, ids.take(item, kind)) for item, kind in taken]
    fields = _Fields(named, there)
    return [FeatureChange(feature_id, None, _raw(item, kind, feature_id, fields)) for item, kind, feature_id in named]


def _raw(item: MapItem, kind: str, feature_id: str, fields: _Fields) -> dict[str, Any]:
    own = item.properties if kind == item.kind else settled(kind, item.geometry, item.properties, [])
    properties: dict[str, Any] = {**own, "id": feature_id, "kind": kind, "name": item.name[:LONGEST_NAME]}
    if kind == "rows" and (parcel := fields.of(item)):
        properties["parcel_id"] = parcel
    return {"type": "Feature", "id": feature_id, "properties": properties, "geometry": item.geometry}


class _Fields:
    """Finds the parcel of rows: the one they name, then the file's, then the one that holds most of them."""

    def __init__(self, named: Sequence[tuple[MapItem, str, str]], there: MapFeatures) -> None:
        self._taken = [(item, feature_id) for item, kind, feature_id in named if kind == "parcel"]
        self._by_id = {item.id: feature_id for item, feature_id in reversed(self._taken) if item.id}
        self._there = {key: one for key, one in there.items() if one["properties"].get("kind") == "parcel"}
        self._of_site: dict[int, list[tuple[str, Any]]] = {}
        for item, feature_id in self._taken:
            if item.site is not None:
                self._of_site.setdefault(item.site, []).append((feature_id, item.geometry))
        self._drawn: Parcels | None = None

    def of(self, item: MapItem) -> str | None:
        """Return the id of the parcel on the map, ``None`` where nothing tells."""
        told = str(item.properties.get("parcel_id"))
        if told in self._by_id:
            return self._by_id[told]  # rows stay with the field they came with, whatever it is called now
        if told in self._there:
            return told
        own = self._of_site.get(item.site, []) if item.site is not None else []
        return own[0][0] if len(own) == 1 else self._holding(item, own)

    def _holding(self, item: MapItem, own: list[tuple[str, Any]]) -> str | None:
        from hmi.mapping.row_field import Parcels  # geometry: not for a console's start

        if own and (found := Parcels(own).holding(item.geometry)):
            return found
        if self._drawn is None:
            taken = [(feature_id, one.geometry) for one, feature_id in self._taken]
            self._drawn = Parcels([*taken, *((key, one["geometry"]) for key, one in self._there.items())])
        return self._drawn.holding(item.geometry)


class _FreeIds:
    """Hands out ids that the map has not yet, each once: the file's own where that is free."""

    def __init__(self, there: Iterable[str]) -> None:
        self._used = set(there)
        self._last: dict[str, int] = {}  # of thousands of fields of one name, each is numbered at once

    def take(self, item: MapItem, kind: str) -> str:
        wish = item.id or _NO_ID.sub("-", (item.name or kind).lower()).strip("-")[:WORD_CHARS] or kind
        found = wish if wish not in self._used else self._numbered(wish[:WORD_CHARS])
        self._used.add(found)
        return found

    def _numbered(self, word: str) -> str:
        number = self._last.get(word, 1) + 1
        while f"{word}-{number}" in self._used:
            number += 1
        self._last[word] = number
        return f"{word}-{number}"

"""Reads the map entities of the cloud when something hints at a change, and keeps the proposals true."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence

from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import NgsiError
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.query import Query
from hmi.clock import Clock
from hmi.cloud.hints import Hints
from hmi.cloud.link import is_about_one
from hmi.cloud.map_subscription import IsOurs, MapSubscription
from hmi.cloud.marker import TenantMoved
from hmi.cloud.proposals import ProposalBook
from hmi.cloud.told_ids import ToldIds
from hmi.fiware.map_change import KIND_OF, is_as_told
from hmi.fiware.normalized import key_values
from hmi.fiware.urn import KeyValues
from hmi.mapping.feature import MapFeature

READ_ALL_S = 300.0  # what no notification told, for instance while the console was off
STORM_S = 10.0  # while more is told than can be looked at, everything is read so often and no oftener
MOST_SINGLE = 20  # with more hints than this one question for all is cheaper
Features = Callable[[], Awaitable[Mapping[str, MapFeature]]]
log = logging.getLogger(__name__)


class MapChanges:
    """Proposals from the cloud; ``round`` is called by the mirror's task while the link is up.

    Args:
        features: the published map by id.
        on_changed: called when proposals came, went or changed.
        subscription: ``None`` where the broker cannot reach this console.
        told: which entities were told; without it a deletion is seen only while it is notified.
        is_ours: whether the tenant that answers now is ours. In another one everything of ours is missing, which is
            nobody's wish.
    """

    def __init__(
        self,
        client: NgsiClient,
        book: ProposalBook,
        hints: Hints | None,
        clock: Clock,
        features: Features,
        on_changed: Callable[[], None],
        subscription: MapSubscription | None = None,
        told: ToldIds | None = None,
        *,
        is_ours: IsOurs,
    ) -> None:
        self._client, self.book, self.hints, self._clock = client, book, hints, clock
        self._features, self._on_changed = features, on_changed
        self.subscription, self._told, self._is_ours = subscription, told, is_ours
        self._read_s = self._read_at_s = float("-inf")

    def read_soon(self) -> None:
        """Read everything in the next round."""
        self._read_s = float("-inf")

    async def written(self, refs: Iterable[EntityRef]) -> None:
        """Note that entities of the map were written."""
        if self._told is not None:
            await asyncio.to_thread(self._told.add, [ref for ref in refs if ref.type in KIND_OF])

    async def placed(self) -> None:
        """Expect nothing there if the tenant has nothing that we told; else what is missing was deleted by somebody.

        Raises:
            NgsiError: it could not be asked.
        """
        if self.subscription is not None:
            self.subscription.ensure_soon()  # a broker that forgot us, or is another one, forgot that too
        told = frozenset[EntityRef]() if self._told is None else self._told.all()
        if told:
            async for one in self._client.entities(Query(types=tuple(KIND_OF))):
                if one.ref in told:
                    return
        await self._forget()

    async def _forget(self) -> None:
        if self._told is not None:
            await asyncio.to_thread(self._told.forget)
        if self.book.clear():
            self._on_changed()

    async def round(self) -> None:
        """Subscribe and read if it is time; raises ``NgsiError``, ``TenantMoved``."""
        now_s = self._clock.mono_s()
        if self.subscription is not None and await self.subscription.round():
            self.read_soon()  # who knows what it did not tell
        is_storm = self.hints is not None and self.hints.is_too_many
        if is_storm and now_s < self._read_at_s + STORM_S:
            return
        hinted = self.hints.waiting() if self.hints is not None else {}
        if now_s >= self._read_s or len(hinted) > MOST_SINGLE or is_storm:
            await self.read_all()
        elif hinted:
            try:
                await self._read(hinted)
            except (NgsiError, TenantMoved):
                self.read_soon()  # the hints are used up
                raise

    async def read_all(self) -> None:
        """Read every map entity and keep the proposals true; raises ``NgsiError``, ``TenantMoved``."""
        if self.hints is not None:
            self.hints.is_too_many = False
        found = [key_values(one) async for one in self._client.entities(Query(types=tuple(KIND_OF)))]
        await self._check_ours()  # after reading: only then it is known whose answer it was
        if self.book.keep({one["id"] for one in found}):
            self._on_changed()
        await self._look(found)
        await self._miss(found)
        await self._clear(found)
        self._read_at_s = self._clock.mono_s()
        self._read_s = self._read_at_s + READ_ALL_S

    async def _miss(self, entities: Sequence[KeyValues]) -> None:
        """Take what was told and is not among all entities of the cloud as deleted there."""
        if self._told is None:
            return
        there = {EntityRef(one["id"], one["type"]) for one in entities}
        features, now = await self._features(), self._clock.utc()
        missing = sorted(self._told.all() - there)
        before = self.book.all()
        over = [ref for ref in missing if not self.book.gone(ref.id, ref.type, features, now)]
        if over and features:  # nothing of our map: it went from there, too
            await asyncio.to_thread(self._told.drop, over)
        if self.book.all() != before:
            self._on_changed()

    async def _check_ours(self) -> None:
        if not await self._is_ours():
            self.read_soon()
            raise TenantMoved

    async def _clear(self, entities: Sequence[KeyValues]) -> None:
        """Delete what we told of features that are on our map no more, unless somebody else changed it since."""
        features = await self._features()
        gone = [one for one in entities if is_as_told(one) and self.book.is_ours_no_more(one, features)]
        refs = [EntityRef(one["id"], one["type"]) for one in gone if features]
        segments = [ref.id for ref in refs if ref.type == "RoadSegment"]
        refs += [EntityRef(one.replace(":RoadSegment:", ":Road:", 1), "Road") for one in segments]
        refs = list(dict.fromkeys(refs))  # what moves between pages comes twice
        if refs:
            if self._told is not None:  # first: what we deleted ourselves is never taken for somebody else's deletion
                await asyncio.to_thread(self._told.drop, refs)
            await self._client.batch("delete", [Entity(ref=ref) for ref in refs])

    async def _read(self, hinted: Mapping[EntityRef, bool]) -> None:
        found = {ref: await self._client.find(ref) for ref in hinted}
        await self._check_ours()
        for ref, entity in found.items():
            if entity is None and hinted[ref] and await self._is_gone(ref):
                self._on_changed()
        await self._look([key_values(one) for one in found.values() if one is not None])

    async def _is_gone(self, ref: EntityRef) -> bool:
        """Take that somebody deleted an entity; return whether a proposal came or went."""
        is_expected = self._told is None or ref in self._told.all()
        if is_expected and self.book.gone(ref.id, ref.type, await self._features(), self._clock.utc()):
            return True
        return self.book.vanished(ref.id)

    async def _look(self, entities: Sequence[KeyValues]) -> None:
        if not entities:
            return
        named = [one for one in entities if "hasAgriCrop" in one or "hasAgriSoil" in one]
        names: dict[str, str] = {}
        try:
            names = await self._names() if named else {}
        except NgsiError as error:
            if not is_about_one(error):
                raise
            log.warning("the names of crops and soils cannot be read: %s", error)
            # without them a change of a crop would look like none: what is open stays, and nothing is written over
            self.book.hold(named)
            entities = [one for one in entities if one not in named]
        if self.book.look(entities, await self._features(), self._clock.utc(), names):
            self._on_changed()

    async def _names(self) -> dict[str, str]:
        """Return the names of crops and kinds of soil."""
        found = [one async for one in self._client.entities(Query(types=("AgriCrop", "AgriSoil")))]
        return {one.ref.id: str(one.value("name")) for one in found if one.value("name")}

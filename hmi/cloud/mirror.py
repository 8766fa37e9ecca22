"""Brings the farm to the cloud, round by round: robots as they are now first, then what waits, in order."""

from __future__ import annotations

import json
import logging
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from datetime import datetime
from functools import partial
from typing import NamedTuple

from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import NgsiError
from backend_clients.ngsi.identifier import EntityRef
from hmi.clock import Clock
from hmi.cloud.backlog import Backlog
from hmi.cloud.counts import Counts
from hmi.cloud.delays import Delays
from hmi.cloud.guard import Guard
from hmi.cloud.link import TWO_AT_ONCE, CloudLink, Delivery
from hmi.cloud.map_changes import MapChanges
from hmi.cloud.marker import TenantMoved
from hmi.cloud.newest import Newest
from hmi.cloud.outbox import Piece
from hmi.cloud.refused import RefusedRecords
from hmi.cloud.states import Report, RobotStates
from hmi.fiware.leftover import gone_from
from hmi.fiware.normalized import key_values, normalized
from hmi.fiware.urn import KeyValues

MOST_ROBOTS = 200  # in one round: one request
MOST_OF_OTHERS = 200  # entities of each kind in one round
PART = 100  # pieces in one request
PARTS = 5  # requests of a backlog in one round, so that the newest state never waits for all of it
MOST_NOT_TAKEN = 200  # entities named
SETTLE_S = 5.0  # how often age and room are looked at when nothing is new
log = logging.getLogger(__name__)


class NotTaken(NamedTuple):
    """Why the broker did not take an entity, and when it was tried last."""

    why: str
    at: datetime


class Mirror:
    """Everything that goes up; ``round`` is called by one task.

    Args:
        whole: returns the farm's map and missions, told at first and after ``tell_whole``.
        refused: where records go that the broker will not take.
        changes: what the cloud wants changed, ``None`` if nobody asks.
        others: what else there is of which the newest goes up: field stations, cameras.
    """

    def __init__(
        self,
        link: CloudLink,
        states: RobotStates,
        backlog: Backlog,
        clock: Clock,
        whole: Callable[[], Awaitable[Sequence[KeyValues]]],
        changes: MapChanges | None = None,
        others: Callable[[], Sequence[Newest]] = tuple,
        *,
        refused: RefusedRecords,
    ) -> None:
        self._others, self.refused = others, refused
        self.not_taken: dict[EntityRef, NotTaken] = {}  # of what is told anew when it changes: nothing is kept
        self.link, self._states, self._backlog, self._clock, self._whole = link, states, backlog, clock, whole
        self.changes = changes
        self.counts = Counts()
        self.guard = Guard()
        self.to_console, self.to_cloud = Delays(), Delays()
        self._settle_s = float("-inf")
        self._wishes, self._told_wish = 1, 0  # of telling map and missions: asked for, done
        self._sent_wish, self._sent = 0, dict[EntityRef, KeyValues]()  # what of a wish arrived before the link failed
        self._whole_refs: set[EntityRef] = set()
        self._placed = 0
        self._had: dict[EntityRef, frozenset[str]] = {}  # attributes that stations and cameras were told with
        self._doubtful: set[EntityRef] = set()

    def tell_whole(self) -> None:
        """Tell map and missions again, e.g. after a map was published."""
        self._wishes += 1

    @property
    def _is_whole_told(self) -> bool:
        return self._told_wish == self._wishes

    async def round(self) -> None:
        """Deliver what can be delivered now; returns when the link is not up or everything of this round is done."""
        if self._backlog.total > self._backlog.waiting.count or self._clock.mono_s() >= self._settle_s:
            self._settle_s = self._clock.mono_s() + SETTLE_S
            await self._backlog.settle()
            await self.refused.settle()
        if not await self.link.is_ready():
            return
        if self.link.placed != self._placed and not await self._begin_again():
            return
        run = self.guard.run
        # the map last: it is the largest, and over a slow way nothing waits until it got through
        if (
            await run("Robots", self._send_robots)
            and await self._send_others()
            and await run("What was refused", self._send_refused)
            and await run("What waits", self._send_backlog)
        ):
            await run("Map", self._send_map)

    async def _begin_again(self) -> bool:
        """Tell everything to a tenant that may know nothing of us; return whether the link is still up."""
        placed = self.link.placed
        try:
            if self.changes is not None:
                await self.changes.placed()
        except NgsiError as error:
            self.link.failed(error)
            return False
        self._placed = placed
        self.tell_whole()
        self._had.clear()
        self._states.forget()
        for other in self._others():
            other.forget()
        self.refused.send_again()
        return True

    def send_again(self) -> None:
        """Tell once more what the broker refused; records first, before anything that is newer."""
        self.refused.send_again()
        if self.not_taken:
            self.tell_whole()
            self._states.forget()
            for other in self._others():
                other.forget()

    async def forget_refused(self) -> int:
        """Forget what the broker refused, since a person decided it; return how many there were."""
        count = len(self.not_taken)
        self.not_taken.clear()
        return count + await self.refused.forget_all()

    async def _send_robots(self) -> bool:
        is_up = await self._send_reports()
        if is_up:  # after what is new: a long answer may not get through a slow way
            await self._look_for_left()
        return is_up

    async def _send_reports(self) -> bool:
        reports = self._states.reports(MOST_ROBOTS)
        if not reports:
            return True
        gone = {_ref(report.entity): report.gone for report in reports}
        found = await self._deliver([report.entity for report in reports], gone)
        now_s, settled = self._clock.mono_s(), found.done | set(found.refused)
        arrived = [report for report in reports if _ref(report.entity) in settled]
        self._states.told(arrived)
        self.counts.states += len(found.done)
        self._time(arrived, now_s)
        return not found.is_cut

    async def _look_for_left(self) -> None:
        """Read once, some time after the start, what an earlier run told of robots: some are heard no more.

        It takes the link down for nobody: where it is down, what is told next shows it.
        """
        wanted = self._states.wanted()
        if wanted is None:
            return
        try:
            left = [key_values(one) async for one in self.link.client.entities(wanted)]
        except NgsiError as error:
            log.warning("cloud: what an earlier run told of robots cannot be read: %s", error)
            self._states.left_later()
            return
        self._states.found(left)

    async def _send_others(self) -> bool:
        for other in self._others():
            if not await self.guard.run(other.what, partial(self._send_newest, other)):
                return False
        return True

    async def _send_newest(self, other: Newest) -> bool:
        entities = other.reports(MOST_OF_OTHERS)
        if not entities:
            return True
        gone = {_ref(one): gone_from(one, self._had.get(_ref(one))) for one in entities}
        found = await self._deliver(entities, gone)
        self._had.update((_ref(one), frozenset(one)) for one in entities if _ref(one) in found.done)
        settled = found.done | set(found.refused)
        other.told(one for one in entities if _ref(one) in settled)
        self.counts.others += len(found.done)
        return not found.is_cut

    def _time(self, reports: Sequence[Report], now_s: float) -> None:
        for report in reports:
            if report.source_s is not None and report.received_s is not None:
                self.to_cloud.add(now_s - report.source_s)
                self.to_console.add(report.received_s - report.source_s)

    async def _send_map(self) -> bool:
        return await self._look_around() and await self._send_whole()

    async def _look_around(self) -> bool:
        """Read what the cloud wants changed, always before the map is told: nothing of it is written over."""
        if self.changes is None:
            return True
        try:
            if not self._is_whole_told:
                await self.changes.read_all()
            await self.changes.round()
        except NgsiError as error:
            self.link.failed(error)
            return False
        except TenantMoved:
            self.link.look_again()
            return False
        if self.changes.book.has_let_go:  # somebody's change is gone, or was refused: ours goes up at once
            self.tell_whole()
        return True

    async def _send_whole(self) -> bool:
        if self._is_whole_told:
            return True
        wish = self._wishes  # a map may be published, or a proposal refused, while this one goes up
        if self._sent_wish != wish:
            self._sent_wish = wish
            self._sent.clear()
        whole = await self._whole()
        once = self._once(whole)
        for ref in self._whole_refs - once.keys():  # on the map no more
            self.not_taken.pop(ref, None)
        self._whole_refs = set(once)
        entities = [one for ref, one in once.items() if self._sent.get(ref) != one]
        while entities:
            size = self.link.most
            part, entities = entities[:size], entities[size:]
            found = await self._deliver(part)
            if self.changes is not None:
                await self.changes.written(found.done)
            settled = found.done | set(found.refused)
            self._sent.update((_ref(one), one) for one in part if _ref(one) in settled)
            if found.is_cut:
                return False
            if entities and not await self.guard.run("Robots", self._send_robots):  # they wait for one request at most
                return False
        self._told_wish = wish
        self._sent.clear()
        return True

    def _once(self, whole: Sequence[KeyValues]) -> dict[EntityRef, KeyValues]:
        """Return the first entity of each id; another one under it is a mistake of ours, named and never written."""
        for ref in [ref for ref, one in self.not_taken.items() if one.why == TWO_AT_ONCE]:
            del self.not_taken[ref]
        found: dict[EntityRef, KeyValues] = {}
        for one in whole:
            if found.setdefault(_ref(one), one) != one:
                self._note_refused(Delivery(refused={_ref(one): TWO_AT_ONCE}))
        return found

    async def _send_backlog(self) -> bool:
        for _ in range(PARTS):
            pieces = await self._backlog.first(PART)
            if not pieces:
                return True
            part, entities = _in_order(pieces)
            found = await self._deliver(entities)
            settled = found.done | set(found.refused)
            gone = [piece for piece, entity in zip(part, entities, strict=True) if _ref(entity) in settled]
            await self._keep_refused(found, zip(part, entities, strict=True))  # before the outbox forgets them
            await self._backlog.delivered(gone)
            self.counts.pieces += len(gone) - len(found.refused)
            if found.is_cut:
                return False
        return True

    async def _send_refused(self) -> bool:
        """Send refused records again where that was asked for: they are older than everything that waits."""
        while pairs := self.refused.next(PART):
            found = await self._deliver([entity for _, entity in pairs])
            await self._keep_refused(found, ((one.piece, entity) for one, entity in pairs))
            self.counts.pieces += len(found.done)
            if found.is_cut:
                return False
            sent = {one.ref for one, _ in pairs}
            self.refused.again = [ref for ref in self.refused.again if ref not in sent]
        return True

    async def _keep_refused(self, found: Delivery, pairs: Iterable[tuple[Piece, KeyValues]]) -> None:
        kept = [(_ref(entity), piece, found.refused[_ref(entity)]) for piece, entity in pairs
                if _ref(entity) in found.refused]  # fmt: skip
        for ref, _, _ in kept:
            self.not_taken.pop(ref, None)
        await self.refused.keep(kept)

    def _note_refused(self, found: Delivery) -> None:
        for ref in found.done & self.not_taken.keys():
            if self.not_taken[ref].why != TWO_AT_ONCE:  # the first of two arrived, the other never will
                del self.not_taken[ref]
        for ref, text in found.refused.items():
            self.not_taken.pop(ref, None)
            self.not_taken[ref] = NotTaken(text, self._clock.utc())
        while len(self.not_taken) > MOST_NOT_TAKEN:
            del self.not_taken[next(iter(self.not_taken))]

    async def _deliver(
        self, entities: Sequence[KeyValues], gone: Mapping[EntityRef, frozenset[str]] | None = None
    ) -> Delivery:
        """Deliver entities and note what became of them.

        Args:
            gone: attributes to delete, where it is known better than by what whole entities lack.
        """
        wire: list[Entity] = [normalized(entity) for entity in entities]
        refs = {one.ref for one in wire}
        self.counts.resent += len(refs & self._doubtful)
        gone = {_ref(one): gone_from(one) for one in entities} if gone is None else gone
        found = await self.link.deliver(wire, gone)
        self._doubtful -= refs
        if found.is_doubtful:
            self._doubtful |= refs - found.done - set(found.refused)
        self._note_refused(found)
        await self.refused.arrived(found.done)  # an older record of the same entity, too
        if found.refused:
            self.counts.refused += len(found.refused)
            ref, text = next(iter(found.refused.items()))
            self.counts.last_refusal = f"{ref.type}: {text}"
            log.warning("cloud: %d entities refused, e.g. %s %s: %s", len(found.refused), ref.type, ref.id, text)
        return found


def _in_order(pieces: Sequence[Piece]) -> tuple[list[Piece], list[KeyValues]]:
    """Return the pieces before the first that changes an entity a second time: that one goes after them."""
    entities: list[KeyValues] = []
    seen: set[EntityRef] = set()
    for piece in pieces:
        entity = json.loads(piece.body)
        if _ref(entity) in seen:
            break
        seen.add(_ref(entity))
        entities.append(entity)
    return list(pieces[: len(entities)]), entities


def _ref(entity: KeyValues) -> EntityRef:
    return EntityRef(entity["id"], entity["type"])

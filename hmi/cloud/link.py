"""The way to one broker: asks who it is, delivers, backs off, and says how it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from backend_clients.http.trouble import Trouble
from backend_clients.ngsi.batch import MAX_ENTITIES
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Call
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import BrokerRefused, NgsiError, NoAnswer, NotFound, Unreadable
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.query import Query
from hmi.clock import Clock
from hmi.cloud.broker_link import broker_link
from hmi.cloud.marker import Marker
from hmi.service_link import LinkState, ServiceLink

_NEVER_TAKEN = frozenset({400, 413, 422})  # whatever else is said to a write may be otherwise next time
TWO_AT_ONCE = "two at once under one id, of which the first is sent"
ASKED = 50  # ids in one question: they stand in its address
SMALL, SMALLEST = 20, 10  # a request that small is late for another reason than its size, if larger ones arrive
GROW_S = 30.0  # small requests say little of larger ones: with them the size grows so often and no oftener
LOOK_EVERY_S = 15.0  # a proxy may send us to another tenant at any time; two small questions beside a write a second


@dataclass(slots=True)
class Delivery:
    """What became of a delivery.

    Args:
        done: taken by the broker.
        refused: never taken, however often it is sent.
        is_cut: the link failed; what is in neither is to be sent again.
        is_doubtful: some of that may have arrived all the same.
    """

    done: set[EntityRef] = field(default_factory=set)
    refused: dict[EntityRef, str] = field(default_factory=dict)
    is_cut: bool = False
    is_doubtful: bool = False


class CloudLink:
    """One broker. Calls belong to one task.

    Args:
        client: to the broker; its own retries are off, since the link backs off.
        link: how the broker is.
    """

    def __init__(self, client: NgsiClient, marker: Marker, clock: Clock, link: ServiceLink | None = None) -> None:
        self.client, self._marker, self._clock = client, marker, clock
        self.link = link or broker_link(clock)
        self.placed = 0
        """How often the tenant turned out to know nothing of us: then everything has to be told again."""
        self._look_s = float("-inf")
        self.most = MAX_ENTITIES
        """Entities in one request that the way up carries in time."""
        self._fitted_s = float("-inf")

    async def is_ready(self) -> bool:
        """Say whether something can be delivered now; tries a lost link again when it is time."""
        if not self.link.may_ask:
            return False
        if not self.link.is_well or self._clock.mono_s() >= self._look_s:
            await self._look()
        return self.link.is_well

    async def deliver(self, entities: Sequence[Entity], gone: Mapping[EntityRef, frozenset[str]]) -> Delivery:
        """Write entities, each once; a failed link is known by ``is_cut`` and by ``link``.

        Args:
            gone: attributes that are deleted before, where an entity has them.
        """
        begin_s = self._clock.mono_s()
        try:
            await self._delete(gone)
        except NgsiError as lost:
            self.failed(lost)
            return Delivery(is_cut=True)
        found, once = Delivery(), dict[EntityRef, Entity]()
        for one in entities:
            if once.setdefault(one.ref, one) is not one:  # a mistake of ours about one thing: the others go up
                found.refused[one.ref] = TWO_AT_ONCE
        outcome = await self.client.batch("append", list(once.values()), most=self.most)
        self._fit(len(once), is_late=any(isinstance(error, NoAnswer) for error in outcome.failed.values()))
        if outcome.too_large is not None:  # asked for in two halves from now on
            self.most, self._fitted_s = max(1, min(self.most, outcome.too_large // 2)), self._clock.mono_s()
        found.done.update(outcome.done)
        for ref, error in outcome.failed.items():
            if is_about_one(error):
                found.refused[ref] = f"{error}"[:300]
                continue
            found.is_doubtful |= error.is_outcome_unknown
            if not found.is_cut:
                found.is_cut = True
                self.failed(error)
        if not found.is_cut:
            self.link.well(self._clock.mono_s() - begin_s)
        return found

    def _fit(self, count: int, *, is_late: bool) -> None:
        """Fit the size of requests to what the way up carries in time; what went is only slowly followed by more."""
        now_s, before = self._clock.mono_s(), self.most
        if is_late and before > SMALLEST:
            self.most = max(SMALLEST, min(before, max(count, SMALL)) // 2)
        elif is_late and count >= before:
            self.most = max(1, before // 2)
        elif not is_late and (count >= before or now_s >= self._fitted_s + GROW_S):
            self.most = min(MAX_ENTITIES, before + max(1, before // 4))
        if self.most != before:
            self._fitted_s = now_s

    async def _delete(self, gone: Mapping[EntityRef, frozenset[str]]) -> None:
        """Delete attributes that entities have in the cloud; nothing else of them is touched."""
        by_type: dict[str, list[EntityRef]] = {}
        for ref, names in gone.items():
            if names:
                by_type.setdefault(ref.type, []).append(ref)
        left: list[Entity] = []
        for model, refs in by_type.items():
            wanted = tuple(sorted(set().union(*(gone[ref] for ref in refs))))
            for begin in range(0, len(refs), ASKED):
                ids = tuple(ref.id for ref in refs[begin : begin + ASKED])
                query = Query(types=(model,), ids=ids, attrs=wanted)
                left += [one async for one in self.client.entities(query)]
        left = list({one.ref: one for one in left}.values())  # what moves between pages comes twice
        stale = [
            (one.ref, {key: value for key, value in one.attributes.items() if key in gone[one.ref]}) for one in left
        ]
        # one without attributes would be deleted whole
        outcome = await self.client.batch("delete", [Entity(ref=ref, attributes=some) for ref, some in stale if some])
        for error in outcome.failed.values():
            if not isinstance(error, NotFound) and not is_about_one(error):
                raise error

    async def take_tenant(self) -> None:
        """Write here from now on, whoever did before; a person decided it. Raises ``NgsiError``."""
        await self._marker.place(self.client)
        self.placed += 1
        self._look_s = float("-inf")
        self.link.ask_now()

    def failed(self, error: NgsiError) -> None:
        """Take that a call failed."""
        self._look_s = float("-inf")
        self.link.failed(error)

    def look_again(self) -> None:
        """Ask whose tenant it is before anything else is written."""
        self._look_s = float("-inf")

    async def _look(self) -> None:
        begin_s = self._clock.mono_s()
        try:
            await self._ask_version()
            state, why, is_new = await self._marker.look(self.client)
        except NgsiError as error:
            self.failed(error)
            return
        if state is LinkState.OK:
            self.placed += is_new
            self._look_s = self._clock.mono_s() + LOOK_EVERY_S
            self.link.well((self._clock.mono_s() - begin_s) / 2)  # two calls
        else:
            self._look_s = float("-inf")
            self.link.leave(state, why, "Check tenant and service path, or take this tenant for this console.")

    async def _ask_version(self) -> None:
        reply = await self.client.connection.send(Call("GET", "version", is_repeatable=True))
        body = reply.json()
        if not isinstance(body, dict) or not body:
            raise Unreadable("the answer names no broker")
        self.link.set_clock(reply.headers.get("date", ""))


def is_about_one(error: NgsiError) -> bool:
    """Say whether an error is about the entity alone: the link is well, and no other try would help."""
    if isinstance(error, BrokerRefused):
        return error.trouble is None and error.status in _NEVER_TAKEN
    return error.trouble is Trouble.MISSET

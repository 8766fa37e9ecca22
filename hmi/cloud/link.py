"""The way to one broker: asks who it is, delivers, backs off, and says how it is."""

from __future__ import annotations

import logging
import random
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from email.utils import parsedate_to_datetime

from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Call
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import NgsiError, Unreadable
from backend_clients.ngsi.identifier import EntityRef
from hmi.clock import Clock
from hmi.cloud.link_state import DELIVERS, Link, LinkState, is_about_one, state_of
from hmi.cloud.marker import Marker

FIRST_PAUSE_S, LONGEST_PAUSE_S = 1.0, 30.0
LOOK_EVERY_S = 60.0  # a proxy may send us to another tenant at any time
SLOW_S = 1.0
log = logging.getLogger(__name__)


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
        client: to the broker; its own retries are off, since this backs off.
        jitter: 0..1, spreads consoles that lost the same broker.
    """

    def __init__(self, client: NgsiClient, marker: Marker, clock: Clock, jitter: float | None = None) -> None:
        self.client, self._marker, self._clock, self._jitter = client, marker, clock, jitter
        self.link = Link(LinkState.CONNECTING, clock.mono_s())
        self.skew_s: float | None = None
        self.heard_at: datetime | None = None
        self.placed = 0
        """How often the tenant turned out to know nothing of us: then everything has to be told again."""
        self._failures = 0
        self._next_s = self._look_s = float("-inf")

    async def is_ready(self) -> bool:
        """Say whether something can be delivered now; tries a lost link again when it is time."""
        now_s = self._clock.mono_s()
        if now_s < self._next_s:
            return False
        if self.link.state not in DELIVERS or now_s >= self._look_s:
            await self._look()
        return self.link.state in DELIVERS

    async def deliver(self, entities: Sequence[Entity]) -> Delivery:
        """Write entities, each once; a failed link is known by ``is_cut`` and by ``link``."""
        begin_s = self._clock.mono_s()
        outcome, found = await self.client.batch("append", entities), Delivery()
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
            self._well(self._clock.mono_s() - begin_s)
        return found

    async def take_tenant(self) -> None:
        """Write here from now on, whoever did before; a person decided it. Raises ``NgsiError``."""
        await self._marker.place(self.client)
        self.placed += 1
        self._next_s = self._look_s = float("-inf")

    def failed(self, error: NgsiError) -> None:
        """Take that a call failed."""
        self._wait(state_of(error), f"{error}"[:300], error.mend)

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
            self._well((self._clock.mono_s() - begin_s) / 2)  # two calls
        else:
            self._wait(state, why, "Check tenant and service path, or take this tenant for this console.")

    async def _ask_version(self) -> None:
        reply = await self.client.connection.send(Call("GET", "version", is_repeatable=True))
        body = reply.json()
        if not isinstance(body, dict) or not body:
            raise Unreadable("the answer names no broker")
        self.skew_s = self._skew(reply.headers.get("date", ""))

    def _skew(self, date: str) -> float | None:
        """Return how far the broker's clock is ahead of ours; it tells whole seconds."""
        try:
            ahead_s = (parsedate_to_datetime(date) - self._clock.utc()).total_seconds()
        except (ValueError, TypeError):
            return None
        return ahead_s if abs(ahead_s) > 1.5 else 0.0

    def _well(self, took_s: float) -> None:
        self._failures, self.heard_at = 0, self._clock.utc()
        self._next_s = float("-inf")
        state = LinkState.SLOW if took_s > SLOW_S else LinkState.OK
        self._be(state, f"The last answer took {took_s:.1f} s." if state is LinkState.SLOW else "", "")

    def _wait(self, state: LinkState, why: str, mend: str) -> None:
        pause_s = min(LONGEST_PAUSE_S, FIRST_PAUSE_S * 2.0**self._failures)
        self._failures = min(self._failures + 1, 10)
        chance = random.random() if self._jitter is None else self._jitter  # noqa: S311 - spreads load
        self._next_s = self._clock.mono_s() + pause_s * (0.5 + 0.5 * chance)
        self._look_s = float("-inf")
        self._be(state, why, mend)

    def _be(self, state: LinkState, why: str, mend: str) -> None:
        if state is self.link.state:
            self.link = Link(state, self.link.since_s, why, mend)
            return
        log.info("cloud: %s %s", state.value, why)
        self.link = Link(state, self._clock.mono_s(), why, mend)

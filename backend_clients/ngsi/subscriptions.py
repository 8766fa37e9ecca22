"""Keeping subscriptions at a broker: make or adopt, renew, clean up."""

from __future__ import annotations

from collections.abc import AsyncIterator, Collection
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, Literal
from urllib.parse import quote

from backend_clients.ngsi.connection import Call, Connection
from backend_clients.ngsi.errors import NgsiError, NotFound, TooLong, Unreadable
from backend_clients.ngsi.identifier import check_id
from backend_clients.ngsi.moment import moment_text
from backend_clients.ngsi.subscription import Subscription, Wanted, check_key, read_mark, read_subscription

PAGE = 100
MOST = 10_000
LIFE = timedelta(hours=24)  # what a console that is gone leaves behind ends by itself
_IN_FORCE = frozenset({"active", "failed"})  # a broker that could not deliver the last one goes on trying
How = Literal["made", "adopted", "renewed", "mended"]


@dataclass(frozen=True, slots=True)
class Kept:
    """A subscription that is in force.

    Args:
        how: ``made`` new, ``adopted`` as it was, ``renewed`` for longer, or ``mended``: it asked for something else,
            was switched off or had run out.
        until: the broker ends it then.
    """

    id: str
    how: How
    until: datetime


class Subscriptions:
    """The subscriptions of one owner in one tenant and path. Raises ``NgsiError`` everywhere.

    Args:
        connection: to the broker.
        owner: whose they are, e.g. the name of this console; others' are never touched.
        life: how long one lasts without being renewed.
    """

    def __init__(self, connection: Connection, owner: str, life: timedelta = LIFE) -> None:
        self._connection, self._owner, self._life = connection, check_key(owner), life

    async def ensure(self, wanted: Wanted, now: datetime) -> Kept:
        """Have a subscription in force; call it again before half its life is over, and when nothing comes any more.

        What an earlier run of ours left behind is adopted, doubles are deleted. A lost answer makes no double:
        the next look finds what it made.
        """
        found = [item async for item in self.mine() if item.mark and item.mark.key == wanted.key]
        for double in found[1:]:
            await self._forget(double.id)
        until = now + self._life
        if not found:
            return await self._make(wanted, until)
        return await self._adopt(found[0], wanted, now, until)

    async def mine(self) -> AsyncIterator[Subscription]:
        """Iterate over this owner's subscriptions, oldest first."""
        async for item in self.all():
            if item.mark is not None and item.mark.owner == self._owner:
                yield item

    async def all(self) -> AsyncIterator[Subscription]:
        """Iterate over everybody's subscriptions, oldest first."""
        seen: set[str] = set()
        for offset in range(0, MOST, PAGE):
            wanted = {"limit": str(PAGE), "offset": str(offset)}
            body = (await self._connection.send(Call("GET", "v2/subscriptions", wanted, is_repeatable=True))).json()
            if not isinstance(body, list):
                raise Unreadable("the answer is not a list")
            for item in map(read_subscription, body):
                if item.id not in seen:
                    seen.add(item.id)
                    yield item
            if len(body) < PAGE:
                return
        raise TooLong(f"more than {MOST} subscriptions")

    async def get(self, name: str) -> Subscription:
        """Return one subscription; raises ``NotFound``, as after somebody deleted it behind our back."""
        reply = await self._connection.send(Call("GET", _path(name), is_repeatable=True))
        return read_subscription(reply.json())

    async def clean_up(self, keep: Collection[str]) -> list[str]:
        """Delete this owner's subscriptions but those with the keys to keep; return their ids."""
        gone = [item.id async for item in self.mine() if item.mark and item.mark.key not in keep]
        for name in gone:
            await self._forget(name)
        return gone

    async def _make(self, wanted: Wanted, until: datetime) -> Kept:
        body = wanted.body(self._owner, until)
        try:
            reply = await self._connection.send(Call("POST", "v2/subscriptions", body=body))
        except NgsiError as error:
            if not error.is_outcome_unknown:
                raise
            made = [item async for item in self.mine() if item.mark and item.mark.key == wanted.key]
            if not made:
                raise
            return Kept(made[0].id, "made", until)
        name = reply.headers.get("location", "").rpartition("/")[2]
        if not name:
            raise Unreadable("the broker made a subscription and did not say which")
        return Kept(name, "made", until)

    async def _adopt(self, found: Subscription, wanted: Wanted, now: datetime, until: datetime) -> Kept:
        body = wanted.body(self._owner, until)
        is_same = found.mark == read_mark(body["description"])
        if not is_same or found.status not in _IN_FORCE:
            await self._patch(found.id, {**body, "status": "active"})
            return Kept(found.id, "mended", until)
        if found.expires is None or found.expires - now > self._life / 2:
            return Kept(found.id, "adopted", found.expires or until)
        await self._patch(found.id, {"expires": moment_text(until)})
        return Kept(found.id, "renewed", until)

    async def _patch(self, name: str, body: dict[str, Any]) -> None:
        await self._connection.send(Call("PATCH", _path(name), body=body, is_repeatable=True))

    async def _forget(self, name: str) -> None:
        try:
            await self._connection.send(Call("DELETE", _path(name), is_repeatable=True))
        except NotFound:
            return  # somebody was faster


def _path(name: str) -> str:
    return f"v2/subscriptions/{quote(check_id(name), safe='')}"

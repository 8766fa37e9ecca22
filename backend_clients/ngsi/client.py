"""Entities of a context broker: create, read, list, write, delete."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable, Mapping
from typing import Any
from urllib.parse import quote

import httpx
from pydantic import JsonValue

from backend_clients.ngsi import batch
from backend_clients.ngsi.batch import Action, BatchOutcome
from backend_clients.ngsi.connection import Broker, Call, Connection, Reply
from backend_clients.ngsi.entity import Attributes, Entity, attributes_to_wire, entity_from_wire
from backend_clients.ngsi.errors import BadInput, NotFound, TooLong, Unreadable
from backend_clients.ngsi.identifier import EntityRef, check_attribute_name, check_ref
from backend_clients.ngsi.query import Query
from backend_clients.ngsi.token import TokenSource

PAGE = 200
MAX_PAGE = 1000  # the broker's own limit
MOST = 100_000
MOST_BACKS = 100  # an order that never rests, as that of what is near and moves, must come to an end


class NgsiClient:
    """One tenant and path of one broker. Raises ``NgsiError`` everywhere.

    Args:
        broker: where it is.
        tokens: where credentials come from; ``None`` for an open broker.
        transport: test seam, as in httpx.
        connection: instead of both, a connection of the caller's.
    """

    def __init__(
        self,
        broker: Broker,
        tokens: TokenSource | None = None,
        *,
        transport: httpx.AsyncBaseTransport | None = None,
        connection: Connection | None = None,
    ) -> None:
        self.connection = connection or Connection(broker, tokens, transport=transport)

    async def close(self) -> None:
        """Close all connections."""
        await self.connection.close()

    async def __aenter__(self) -> NgsiClient:
        return self

    async def __aexit__(self, *_error: object) -> None:
        await self.close()

    async def version(self) -> str:
        """Return the broker's product and version, e.g. ``orion 4.3.0``: the cheapest sign of life."""
        body = await self._json(Call("GET", "version", is_repeatable=True))
        if not isinstance(body, dict) or not body:
            raise Unreadable("the answer names no broker")
        product, about = next(iter(body.items()))
        number = about.get("version", "") if isinstance(about, dict) else ""
        return f"{product} {number}".strip()[:80]

    async def create(self, entity: Entity) -> None:
        """Make an entity. Never sent twice; raises ``AlreadyExists``."""
        await self.connection.send(Call("POST", "v2/entities", body=entity.to_wire()))

    async def upsert(self, entity: Entity) -> None:
        """Make an entity, or write its attributes into the one that is there; others stay."""
        call = Call("POST", "v2/entities", {"options": "upsert"}, entity.to_wire(), is_repeatable=True)
        await self.connection.send(call)

    async def get(self, ref: EntityRef, attrs: tuple[str, ...] = (), metadata: tuple[str, ...] = ()) -> Entity:
        """Return an entity; raises ``NotFound``. Arguments as in ``Query``."""
        wanted = Query(types=(ref.type,), attrs=attrs, metadata=metadata).parameters()
        return entity_from_wire(await self._json(Call("GET", _path(ref), wanted, is_repeatable=True)))

    async def find(self, ref: EntityRef) -> Entity | None:
        """Return an entity, ``None`` if there is none."""
        try:
            return await self.get(ref)
        except NotFound:
            return None

    async def patch(self, ref: EntityRef, attributes: Attributes) -> None:
        """Write attributes that exist; raises ``PartlyApplied`` with those that do not."""
        await self._write("PATCH", ref, attributes)

    async def append(self, ref: EntityRef, attributes: Attributes) -> None:
        """Write attributes, new or not."""
        await self._write("POST", ref, attributes)

    async def append_new(self, ref: EntityRef, attributes: Attributes) -> None:
        """Write new attributes; raises ``PartlyApplied`` with those that exist. Never sent twice."""
        call = Call("POST", f"{_path(ref)}/attrs", _typed(ref, "append"), attributes_to_wire(attributes))
        await self.connection.send(call)

    async def replace(self, ref: EntityRef, attributes: Attributes) -> None:
        """Leave the entity with these attributes only."""
        await self._write("PUT", ref, attributes)

    async def increment(self, ref: EntityRef, name: str, by: float) -> None:
        """Add to a number, atomically. Never sent twice."""
        body = {check_attribute_name(name): {"value": {"$inc": by}, "type": "Number"}}
        await self.connection.send(Call("PATCH", f"{_path(ref)}/attrs", _typed(ref), body))

    async def delete(self, ref: EntityRef) -> None:
        """Delete an entity; raises ``NotFound``."""
        await self._delete(_path(ref), ref)

    async def delete_attribute(self, ref: EntityRef, name: str) -> None:
        """Delete one attribute; raises ``NotFound``."""
        await self._delete(f"{_path(ref)}/attrs/{quote(check_attribute_name(name), safe='')}", ref)

    async def count(self, query: Query) -> int:
        """Return how many entities a query means."""
        _, total = await self._page(query, {"limit": "1", "attrs": "id"}, limit=1, offset=0)
        return total

    async def entities(self, query: Query, *, page: int = PAGE, most: int = MOST) -> AsyncIterator[Entity]:
        """Iterate over all entities of a query, each once, page by page.

        What is deleted meanwhile moves the rest up: each page begins with the last entity of the one before, and
        where it does not, reading goes back, so nothing is left out. What is made meanwhile may be missing.

        Raises:
            TooLong: there are more than ``most``.
        """
        if not 0 < page <= MAX_PAGE:
            raise BadInput(f"a page has 1 to {MAX_PAGE} entities")
        steady, seen, offset, backs = query.steady(), set[EntityRef](), 0, 0
        limit = max(2, page)  # one of each page is the last of the page before
        while True:
            found, total = await self._page(steady, {}, limit=limit, offset=offset)
            if total > most:
                raise TooLong(f"{total} entities, at most {most} were wanted")
            if offset and (not found or found[0].ref not in seen) and backs < MOST_BACKS:
                offset, backs = max(0, offset - limit), backs + 1
                continue
            for entity in found:
                if entity.ref not in seen:
                    seen.add(entity.ref)
                    yield entity
            end = offset + len(found)
            if not found or end >= total:
                return
            offset = end - 1 if len(found) > 1 else end

    async def batch(
        self, action: Action, entities: Iterable[Entity], *, most: int = batch.MAX_ENTITIES
    ) -> BatchOutcome:
        """Do one action on many entities, in as few requests as their size allows; see ``BatchOutcome``.

        Args:
            most: entities in one request, fewer where an answer takes too long.
        """
        return await batch.run(self.connection, action, list(entities), most)

    async def types(self) -> dict[str, int]:
        """Return the entity types with how many entities each has."""
        wanted = {"limit": str(MAX_PAGE), "options": "noAttrDetail"}
        body = await self._json(Call("GET", "v2/types", wanted, is_repeatable=True))
        return {str(item["type"]): int(item["count"]) for item in _list(body, ("type", "count"))}

    async def _page(
        self, query: Query, more: Mapping[str, str], *, limit: int, offset: int
    ) -> tuple[list[Entity], int]:
        parameters = {**query.parameters(), "limit": str(limit), "offset": str(offset), "options": "count", **more}
        reply = await self.connection.send(Call("GET", "v2/entities", parameters, is_repeatable=True))
        return [entity_from_wire(item) for item in _list(reply.json())], _total(reply)

    async def _write(self, method: str, ref: EntityRef, attributes: Attributes) -> None:
        body = attributes_to_wire(attributes)
        if not body and method != "PUT":
            raise BadInput("no attributes to write")
        await self.connection.send(Call(method, f"{_path(ref)}/attrs", _typed(ref), body, is_repeatable=True))

    async def _delete(self, path: str, ref: EntityRef) -> None:
        try:
            await self.connection.send(Call("DELETE", path, _typed(ref), is_repeatable=True))
        except NotFound as error:
            if error.attempts == 1:  # after a lost answer it is gone because we deleted it
                raise

    async def _json(self, call: Call) -> Any:
        return (await self.connection.send(call)).json()


def _path(ref: EntityRef) -> str:
    return f"v2/entities/{quote(check_ref(ref).id, safe=':')}"


def _typed(ref: EntityRef, options: str = "") -> dict[str, str]:
    return {"type": ref.type, **({"options": options} if options else {})}


def _list(body: JsonValue, members: tuple[str, ...] = ()) -> list[Any]:
    if not isinstance(body, list):
        raise Unreadable("the answer is not a list")
    if not all(isinstance(item, dict) and item.keys() >= set(members) for item in body):
        raise Unreadable("a member of the answer is not what was asked for")
    return body


def _total(reply: Reply) -> int:
    text = reply.headers.get("fiware-total-count", "")
    if not text.isascii() or not text.isdigit() or len(text) > 15:
        raise Unreadable("the answer does not say how many there are")
    return int(text)

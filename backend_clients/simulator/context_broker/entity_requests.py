"""``/v2/entities`` and ``/v2/entities/{id}``, with the attributes of an entity as a whole."""

from __future__ import annotations

from collections.abc import Iterable

from backend_clients.simulator.context_broker.attribute import Given
from backend_clients.simulator.context_broker.entity import (
    Entity,
    Key,
    View,
    read_attributes,
    read_entity,
    render,
    render_attributes,
)
from backend_clients.simulator.context_broker.exchange import Answer, Exchange, as_json, nothing, require_json_accepted
from backend_clients.simulator.context_broker.refusal import bad_request, unprocessable
from backend_clients.simulator.context_broker.selection import Page, Selection
from backend_clients.simulator.context_broker.update import Action, append, append_strict, replace_all, update


def create(exchange: Exchange) -> Answer:
    """Keep a new entity; with ``upsert`` write into one that is there."""
    name, kind, given = read_entity(exchange.object(), plain=exchange.is_plain())
    key = Key(name, kind, exchange.scope.write_path())
    there = exchange.store.tenant(exchange.scope.tenant).entities.get(key)
    upsert = "upsert" in exchange.parameters.options
    if there is not None and not upsert:
        raise unprocessable("Already Exists")
    if there is None:
        exchange.store.create(exchange.scope.tenant, key, given, exchange.how)
    else:
        exchange.store.apply(exchange.scope.tenant, there, append, given, exchange.how, forced=exchange.is_forced())
    return nothing(204 if upsert else 201, Location=f"/v2/entities/{name}?type={kind}")


def listing(exchange: Exchange) -> Answer:
    """List entities."""
    require_json_accepted(exchange.headers)
    page = exchange.parameters.page()
    return page_of(exchange, exchange.parameters.selection(), page, exchange.parameters.view())


def page_of(exchange: Exchange, selection: Selection, page: Page, view: View) -> Answer:
    """Return one page of the entities that a selection means."""
    found: Iterable[Entity] = selection.pick(exchange.store.seen(exchange.scope), exchange.scope)
    ordered = selection.sort(list(found), page.order)
    shown = [render(entity, view) for entity in ordered[page.offset : page.offset + page.limit]]
    return as_json(shown, headers={"Fiware-Total-Count": str(len(ordered))} if page.with_count else None)


def get(exchange: Exchange) -> Answer:
    """Return one entity."""
    require_json_accepted(exchange.headers)
    return as_json(render(exchange.entity_to_read(), exchange.parameters.view()))


def delete(exchange: Exchange) -> Answer:
    """Forget one entity."""
    exchange.store.delete(exchange.scope.tenant, exchange.entity_to_write())
    return nothing()


def get_attributes(exchange: Exchange) -> Answer:
    """Return the attributes of one entity."""
    require_json_accepted(exchange.headers)
    entity, view = exchange.entity_to_read(), exchange.parameters.view()
    if view.form in ("values", "unique"):
        return as_json(render(entity, view))
    return as_json(render_attributes(entity, view))


def put_attributes(exchange: Exchange) -> Answer:
    """Replace all attributes."""
    return _write(exchange, replace_all, _given(exchange, may_be_empty=True))


def patch_attributes(exchange: Exchange) -> Answer:
    """Write attributes that exist."""
    return _write(exchange, update, _given(exchange))


def post_attributes(exchange: Exchange) -> Answer:
    """Write attributes, new or not; with ``append`` only new ones."""
    strict = "append" in exchange.parameters.options
    return _write(exchange, append_strict if strict else append, _given(exchange))


def _given(exchange: Exchange, *, may_be_empty: bool = False) -> dict[str, Given]:
    body = exchange.object()
    for name in ("id", "type"):
        if name in body:
            raise bad_request(f"entity {name} specified in payload")
    if not body and not may_be_empty:
        raise bad_request("empty payload")
    return read_attributes(body, plain=exchange.is_plain())


def _write(exchange: Exchange, action: Action, given: dict[str, Given]) -> Answer:
    entity = exchange.entity_to_write()
    outcome = exchange.store.apply(
        exchange.scope.tenant, entity, action, given, exchange.how, forced=exchange.is_forced()
    )
    if problem := outcome.problem():
        raise problem
    return nothing()

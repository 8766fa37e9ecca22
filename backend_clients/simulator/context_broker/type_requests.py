"""``/v2/types`` and the other small resources."""

from __future__ import annotations

from collections.abc import Iterable

from backend_clients.simulator.context_broker.entity import Entity
from backend_clients.simulator.context_broker.exchange import Answer, Exchange, as_json, require_json_accepted
from backend_clients.simulator.context_broker.json_text import Json
from backend_clients.simulator.context_broker.refusal import Refusal


def entry_point(exchange: Exchange) -> Answer:
    """Return where the resources are."""
    require_json_accepted(exchange.headers)
    resources = ("entities", "types", "subscriptions", "registrations")
    return as_json({f"{name}_url": f"/v2/{name}" for name in resources})


def version(exchange: Exchange) -> Answer:
    """Return what this is; the product name is Orion's so that clients recognise the dialect."""
    require_json_accepted(exchange.headers)
    return as_json({"orion": {"version": "4.3.0", "simulated": True}})


def registrations(exchange: Exchange) -> Answer:
    """Return that there are none."""
    require_json_accepted(exchange.headers)
    return as_json([])


def no_registrations(_exchange: Exchange) -> Answer:
    """Refuse to forward to other context providers."""
    raise Refusal(501, "NotImplemented", "the simulated broker forwards nothing")


def listing(exchange: Exchange) -> Answer:
    """List entity types with their attributes and numbers."""
    require_json_accepted(exchange.headers)
    page = exchange.parameters.page()
    by_type = _by_type(exchange.store.seen(exchange.scope))
    names = sorted(by_type)
    headers = {"Fiware-Total-Count": str(len(names))} if page.with_count else None
    wanted = names[page.offset : page.offset + page.limit]
    if "values" in exchange.parameters.options:
        return as_json(wanted, headers=headers)
    detail = "noAttrDetail" not in exchange.parameters.options
    shown = [{"type": name, **_census(by_type[name], detail=detail)} for name in wanted]
    return as_json(shown, headers=headers)


def get(exchange: Exchange) -> Answer:
    """Return one entity type."""
    require_json_accepted(exchange.headers)
    found = _by_type(exchange.store.seen(exchange.scope)).get(exchange.words[0])
    if found is None:
        raise Refusal(404, "NotFound", "Entity type not found")
    return as_json(_census(found, detail="noAttrDetail" not in exchange.parameters.options))


def _by_type(entities: Iterable[Entity]) -> dict[str, list[Entity]]:
    found: dict[str, list[Entity]] = {}
    for entity in entities:
        found.setdefault(entity.key.type, []).append(entity)
    return found


def _census(entities: list[Entity], *, detail: bool) -> dict[str, Json]:
    kinds: dict[str, set[str]] = {}
    for entity in entities:
        for name, attribute in entity.attributes.items():
            kinds.setdefault(name, set()).add(attribute.type)
    attrs = {name: {"types": sorted(kinds[name]) if detail else []} for name in sorted(kinds)}
    return {"attrs": attrs, "count": len(entities)}

"""``/v2/op/update`` and ``/v2/op/query``."""

from __future__ import annotations

from dataclasses import replace

from backend_clients.simulator.context_broker.entity import Entity, Key, View, check_members, read_entity
from backend_clients.simulator.context_broker.entity_requests import page_of
from backend_clients.simulator.context_broker.exchange import Answer, Exchange, member, nothing
from backend_clients.simulator.context_broker.json_text import Json
from backend_clients.simulator.context_broker.parameters import selection_of
from backend_clients.simulator.context_broker.refusal import Refusal, bad_request, no_entity, unprocessable
from backend_clients.simulator.context_broker.selection import Naming
from backend_clients.simulator.context_broker.subscription import naming_of
from backend_clients.simulator.context_broker.update import (
    Action,
    append,
    append_strict,
    delete,
    replace_all,
    update,
)

ACTIONS: dict[str, Action] = {
    "append": append,
    "appendStrict": append_strict,
    "update": update,
    "delete": delete,
    "replace": replace_all,
}
MAKES_ENTITIES = ("append", "appendStrict")


def batch_update(exchange: Exchange) -> Answer:
    """Do one action on many entities; what can be done is done, the rest is told together."""
    body = exchange.object()
    check_members(body, {"actionType", "entities"}, "batch update")
    action = member(body, "actionType", str, "")
    if action not in ACTIONS:
        raise bad_request(f"invalid update action type: {action}"[:100] if action else "empty update action type")
    entities = member(body, "entities", list)
    if not entities:
        raise bad_request("empty update payload")
    readings = [_reading(item, exchange) for item in entities]
    problems = [problem for item in readings if (problem := _one(exchange, action, *item)) is not None]
    if not problems:
        return nothing()
    raise _together(problems, of=len(readings))


def batch_query(exchange: Exchange) -> Answer:
    """List what a query in the body means."""
    body = exchange.object()
    check_members(body, {"entities", "attrs", "attributes", "expression", "metadata", "scopes"}, "query")
    namings = tuple(naming_of(item) for item in member(body, "entities", list, []))
    attrs = tuple(member(body, "attrs", list, []))
    metadata = tuple(member(body, "metadata", list, []))
    if not namings and not attrs and "expression" not in body:
        raise bad_request("empty payload")
    if not all(isinstance(item, str) for item in attrs + metadata):
        raise bad_request("attrs and metadata must be lists of texts")
    selection = selection_of(namings or (Naming(),), member(body, "expression", dict, {}))
    view: View = replace(exchange.parameters.view(), attrs=attrs, metadata=metadata)
    return page_of(exchange, selection, exchange.parameters.page(), view)


def _reading(item: Json, exchange: Exchange) -> tuple[str, tuple[str, ...], dict[str, Json]]:
    if not isinstance(item, dict):
        raise bad_request("members of entities must be JSON objects")
    name, kind, given = read_entity(item, plain=exchange.is_plain())
    return name, (kind,) if "type" in item else (), given


def _one(exchange: Exchange, action: str, name: str, types: tuple[str, ...], given: dict[str, Json]) -> Refusal | None:
    tenant, scope = exchange.scope.tenant, exchange.scope.for_writing()
    try:
        entity = exchange.store.one(scope, name, types)
    except Refusal as problem:
        if problem.status != 404 or action not in MAKES_ENTITIES:
            return Refusal(problem.status, problem.error, f"{problem.description}: {name}")
        key = Key(name, types[0] if types else "Thing", scope.write_path())
        exchange.store.create(tenant, key, given, exchange.how)
        return None
    return _change(exchange, action, entity, given)


def _change(exchange: Exchange, action: str, entity: Entity, given: dict[str, Json]) -> Refusal | None:
    tenant = exchange.scope.tenant
    if action == "delete" and not given:
        exchange.store.delete(tenant, entity)
        return None
    try:
        outcome = exchange.store.apply(
            tenant, entity, ACTIONS[action], given, exchange.how, forced=exchange.is_forced()
        )
    except Refusal as problem:
        return Refusal(problem.status, problem.error, f"{problem.description}: {entity.key.id}")
    return outcome.problem()


def _together(problems: list[Refusal], *, of: int) -> Refusal:
    if len(problems) == of and all(problem.status == 404 for problem in problems):
        return no_entity()
    if of == 1:
        return problems[0]
    is_partial = len(problems) < of or any(problem.error == "PartialUpdate" for problem in problems)
    return unprocessable("; ".join(problem.description for problem in problems), is_partial=is_partial)

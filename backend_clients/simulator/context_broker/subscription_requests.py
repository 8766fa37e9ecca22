"""``/v2/subscriptions``."""

from __future__ import annotations

import secrets

from backend_clients.simulator.context_broker.exchange import Answer, Exchange, as_json, nothing, require_json_accepted
from backend_clients.simulator.context_broker.json_text import Json
from backend_clients.simulator.context_broker.refusal import Refusal, bad_request
from backend_clients.simulator.context_broker.subscription import MEMBERS, STATES, Subscription, read_rule


def create(exchange: Exchange) -> Answer:
    """Keep a new subscription; it does not notify of what is there already."""
    body = exchange.object()
    rule = read_rule(body)
    subscription = Subscription(secrets.token_hex(12), body, rule, exchange.scope.paths, body.get("status", "active"))
    exchange.store.tenant(exchange.scope.tenant).subscriptions[subscription.id] = subscription
    return nothing(201, Location=f"/v2/subscriptions/{subscription.id}")


def listing(exchange: Exchange) -> Answer:
    """List subscriptions, oldest first."""
    require_json_accepted(exchange.headers)
    page = exchange.parameters.page()
    every = [item for item in _all(exchange).values() if _visible(exchange, item)]
    shown = [item.render(exchange.how.now) for item in every[page.offset : page.offset + page.limit]]
    return as_json(shown, headers={"Fiware-Total-Count": str(len(every))} if page.with_count else None)


def get(exchange: Exchange) -> Answer:
    """Return one subscription."""
    require_json_accepted(exchange.headers)
    return as_json(_one(exchange).render(exchange.how.now))


def patch(exchange: Exchange) -> Answer:
    """Change members of one subscription; a member is replaced as a whole."""
    subscription, given = _one(exchange), exchange.object()
    if not given:
        raise bad_request("empty payload")
    if not given.keys() <= MEMBERS:
        raise bad_request("Unknown field in subscription")
    body: dict[str, Json] = {**subscription.body, **given}
    subscription.rule = read_rule(body)
    subscription.body = body
    if given.get("status") in STATES:
        subscription.status, subscription.fails_in_a_row = given["status"], 0
    return nothing()


def delete(exchange: Exchange) -> Answer:
    """Forget one subscription."""
    del _all(exchange)[_one(exchange).id]
    return nothing()


def _one(exchange: Exchange) -> Subscription:
    found = _all(exchange).get(exchange.words[0])
    if found is None or not _visible(exchange, found):
        text = "The requested subscription has not been found. Check id"
        raise Refusal(404, "NotFound", text)
    return found


def _all(exchange: Exchange) -> dict[str, Subscription]:
    return exchange.store.tenant(exchange.scope.tenant).subscriptions


def _visible(exchange: Exchange, subscription: Subscription) -> bool:
    paths = subscription.paths or ("/",)
    return any(exchange.scope.sees(path.removesuffix("/#") or "/") or path in exchange.scope.paths for path in paths)

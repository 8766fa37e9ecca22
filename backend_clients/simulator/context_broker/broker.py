"""The broker: from a request to an answer, without a web framework."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from urllib.parse import unquote

import httpx
from starlette.datastructures import Headers, QueryParams

from backend_clients.simulator.context_broker import (
    attribute_requests,
    batch_requests,
    entity_requests,
    subscription_requests,
    type_requests,
)
from backend_clients.simulator.context_broker.exchange import JSON_TYPE, Answer, Exchange
from backend_clients.simulator.context_broker.json_text import write
from backend_clients.simulator.context_broker.notifier import Notifier
from backend_clients.simulator.context_broker.parameters import Parameters
from backend_clients.simulator.context_broker.refusal import Refusal, bad_request
from backend_clients.simulator.context_broker.store import Change, Store
from backend_clients.simulator.context_broker.tenancy import scope_of
from backend_clients.simulator.context_broker.update import How
from hmi.clock import Clock, SystemClock

Handler = Callable[[Exchange], Answer]
WITH_BODY = ("POST", "PUT", "PATCH")
# path below the root, {} for a variable part -> method -> handler; the order of methods is that of the Allow header
ROUTES: dict[str, dict[str, Handler]] = {
    "version": {"GET": type_requests.version},
    "v2": {"GET": type_requests.entry_point},
    "v2/entities": {"POST": entity_requests.create, "GET": entity_requests.listing},
    "v2/entities/{}": {"GET": entity_requests.get, "DELETE": entity_requests.delete},
    "v2/entities/{}/attrs": {
        "GET": entity_requests.get_attributes,
        "PUT": entity_requests.put_attributes,
        "POST": entity_requests.post_attributes,
        "PATCH": entity_requests.patch_attributes,
    },
    "v2/entities/{}/attrs/{}": {
        "GET": attribute_requests.get,
        "PUT": attribute_requests.put,
        "DELETE": attribute_requests.remove,
    },
    "v2/entities/{}/attrs/{}/value": {"GET": attribute_requests.get_value, "PUT": attribute_requests.put_value},
    "v2/types": {"GET": type_requests.listing},
    "v2/types/{}": {"GET": type_requests.get},
    "v2/subscriptions": {"GET": subscription_requests.listing, "POST": subscription_requests.create},
    "v2/subscriptions/{}": {
        "GET": subscription_requests.get,
        "PATCH": subscription_requests.patch,
        "DELETE": subscription_requests.delete,
    },
    "v2/registrations": {"GET": type_requests.registrations, "POST": type_requests.no_registrations},
    "v2/op/update": {"POST": batch_requests.batch_update},
    "v2/op/query": {"POST": batch_requests.batch_query},
}


class ContextBroker:
    """Entities, subscriptions and their notifications; all calls on one event loop.

    Args:
        clock: where times come from.
        notify_transport: test seam for notifications, as in httpx.
    """

    def __init__(self, clock: Clock | None = None, notify_transport: httpx.AsyncBaseTransport | None = None) -> None:
        self._clock = clock or SystemClock()
        self._correlator = ""
        self.notifier = Notifier(self._clock, notify_transport)
        self.store = Store(self._changed)

    def answer(self, method: str, path: str, query: QueryParams, headers: Headers, body: bytes) -> Answer:
        """Return the answer to a request; ``path`` is as it came, still encoded."""
        self._correlator = headers.get("fiware-correlator") or str(uuid.uuid4())
        try:
            answer = self._handled(method, path, query, headers, body)
        except Refusal as problem:
            answer = refused(problem)
        return Answer(
            answer.status,
            answer.body,
            answer.media_type,
            {**answer.headers, "Fiware-Correlator": self._correlator},
        )

    async def close(self) -> None:
        """Give up notifications under way."""
        await self.notifier.close()

    def _handled(self, method: str, path: str, query: QueryParams, headers: Headers, body: bytes) -> Answer:
        _check_body(method, headers, body)
        scope = scope_of(headers)
        parameters = Parameters(query)
        methods, words = _routed(path)
        handler = methods.get(method)
        if handler is None:
            raise Refusal(405, "MethodNotAllowed", "method not allowed", {"Allow": ", ".join(methods)})
        how = How(self._clock.utc(), "overrideMetadata" in parameters.options)
        return handler(Exchange(self.store, method, scope, words, parameters, headers, body, how))

    def _changed(self, tenant: str, change: Change) -> None:
        self.notifier.changed(self.store, tenant, change, self._correlator)


def refused(problem: Refusal) -> Answer:
    """Return the answer of a refusal."""
    body = write({"error": problem.error, "description": problem.description})
    headers = dict(problem.headers)
    return Answer(problem.status, body, headers.pop("Content-Type", JSON_TYPE), headers)


def _check_body(method: str, headers: Headers, body: bytes) -> None:
    if method not in WITH_BODY:
        if "content-type" in headers and method in ("GET", "DELETE"):
            raise bad_request(
                "Orion accepts no payload for GET/DELETE requests. HTTP header Content-Type is thus forbidden"
            )
        return
    if not body:
        raise Refusal(411, "ContentLengthRequired", "Zero/No Content-Length in PUT/POST/PATCH request")
    if "content-type" not in headers:
        text = "Content-Type header not used, default application/octet-stream is not supported"
        raise Refusal(415, "UnsupportedMediaType", text)
    kind = headers["content-type"].partition(";")[0].strip().lower()
    if kind not in (JSON_TYPE, "text/plain"):
        raise Refusal(415, "UnsupportedMediaType", f"not supported content type: {kind}")


def _routed(path: str) -> tuple[dict[str, Handler], tuple[str, ...]]:
    parts = [unquote(part) for part in path.strip("/").split("/")]
    for template, methods in ROUTES.items():
        pattern = template.split("/")
        if len(pattern) == len(parts) and all(a in ("{}", b) for a, b in zip(pattern, parts, strict=True)):
            return methods, tuple(b for a, b in zip(pattern, parts, strict=True) if a == "{}")
    raise bad_request("Service not found. Check your URL as probably it is wrong.")

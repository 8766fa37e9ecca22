"""Notifications: what a broker posts to us, read with distrust."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from backend_clients.ngsi.entity import Entity, entity_from_wire
from backend_clients.ngsi.errors import TooLong, Unreadable

MAX_BYTES = 1_048_576
MAX_ENTITIES = 1000  # Orion sends one
MAX_HEADER = 256


@dataclass(frozen=True, slots=True)
class Notification:
    """One notification; which tenant and path it is of stands in its headers."""

    subscription_id: str
    entities: tuple[Entity, ...]
    service: str
    path: str
    correlator: str


def read_notification(body: bytes, headers: Mapping[str, str]) -> Notification:
    """Return the notification of a request's body.

    Args:
        headers: with names in lower case, as ASGI gives them.

    Raises:
        TooLong: over a megabyte.
        Unreadable: not a normalized NGSI-v2 notification.
    """
    if len(body) > MAX_BYTES:
        raise TooLong(f"a notification of {len(body)} bytes")
    if headers.get("ngsiv2-attrsformat", "normalized") != "normalized":
        raise Unreadable(f"a notification in the format {headers['ngsiv2-attrsformat'][:40]!r}")
    try:
        content = json.loads(body, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise Unreadable("a notification that is not JSON") from error
    if not isinstance(content, dict) or not isinstance(content.get("subscriptionId"), str):
        raise Unreadable("a notification without a subscription")
    data = content.get("data")
    if not isinstance(data, list) or len(data) > MAX_ENTITIES:
        raise Unreadable("a notification without a list of entities")
    return Notification(
        subscription_id=content["subscriptionId"][:64],
        entities=tuple(entity_from_wire(item) for item in data),
        service=headers.get("fiware-service", "")[:MAX_HEADER],
        path=headers.get("fiware-servicepath", "/")[:MAX_HEADER],
        correlator=headers.get("fiware-correlator", "")[:MAX_HEADER],
    )


def _no_constant(text: str) -> None:
    raise ValueError(text)

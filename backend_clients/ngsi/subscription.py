"""Subscriptions: what is wanted, and what a broker says of one."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, Literal
from urllib.parse import urlsplit

from backend_clients.ngsi.errors import BadInput, Unreadable
from backend_clients.ngsi.escaping import FORBIDDEN
from backend_clients.ngsi.identifier import check_attribute_name, check_id
from backend_clients.ngsi.moment import moment_text, read_moment
from backend_clients.ngsi.query import Condition, check_pattern

Alteration = Literal["entityCreate", "entityChange", "entityUpdate", "entityDelete"]
SOURCE_ATTRS = ("*", "dateModified", "alterationType")  # every notification says when, and what happened
_KEY = re.compile(r"[a-z0-9][a-z0-9_.:-]{0,63}", re.ASCII)
_MARK = re.compile(r"headland/([^/ ]+)/([^/ ]+) ([0-9a-f]{16})", re.ASCII)


@dataclass(frozen=True, slots=True)
class Wanted:
    """A subscription that somebody of ours needs.

    Args:
        key: names it among those of one owner; lower case.
        url: where notifications go. Keep a secret path out of logs: it is what authenticates the broker.
        types: entity types, at least one.
        id_pattern: a regular expression found in the id.
        watch: attributes whose change notifies; all if empty.
        where: conditions an entity must meet.
        alterations: what notifies.
        fails: after so many failures in a row the broker stops; 0 is never.
    """

    key: str
    url: str = field(repr=False)
    types: tuple[str, ...]
    id_pattern: str = ".*"
    watch: tuple[str, ...] = ()
    where: tuple[Condition, ...] = ()
    alterations: tuple[Alteration, ...] = ("entityCreate", "entityChange", "entityDelete")
    fails: int = 0

    def __post_init__(self) -> None:
        check_key(self.key)
        if urlsplit(self.url).scheme not in ("http", "https") or not urlsplit(self.url).hostname:
            raise BadInput("the address for notifications is no http or https URL")
        if any(c in self.url for c in FORBIDDEN):
            raise BadInput(f"the address for notifications cannot have any of {FORBIDDEN}")
        if not self.types or not self.alterations:
            raise BadInput("a subscription needs a type and an alteration")
        for name in self.types:
            check_id(name)
        for name in self.watch:
            check_attribute_name(name)
        check_pattern(self.id_pattern)

    def body(self, owner: str, until: datetime) -> dict[str, Any]:
        """Return what is sent; no throttling, since a broker would throttle all entities together."""
        condition: dict[str, Any] = {"attrs": list(self.watch), "alterationTypes": list(self.alterations)}
        if self.where:
            condition["expression"] = {"q": ";".join(item.text for item in self.where)}
        limit = {"maxFailsLimit": self.fails} if self.fails else {}
        notification = {
            "http": {"url": self.url},
            "attrs": list(SOURCE_ATTRS),
            "attrsFormat": "normalized",
            **limit,
        }
        entities = [{"idPattern": self.id_pattern, "type": kind} for kind in self.types]
        body = {"subject": {"entities": entities, "condition": condition}, "notification": notification}
        digest = hashlib.sha256(json.dumps(body, sort_keys=True).encode()).hexdigest()[:16]
        mark = f"headland/{check_key(owner)}/{self.key} {digest}"
        return {"description": mark, "expires": moment_text(until), **body}


@dataclass(frozen=True, slots=True)
class Mark:
    """Whose subscription it is, as its description says; ``digest`` changes with what it asks for."""

    owner: str
    key: str
    digest: str


@dataclass(frozen=True, slots=True)
class Subscription:
    """A subscription as the broker tells of it; times are the broker's.

    Args:
        mark: ``None`` if it is somebody else's.
        status: ``active``, ``inactive``, ``expired``, ``failed`` or ``oneshot``.
        fails: failures since the last success.
    """

    id: str
    mark: Mark | None
    status: str
    expires: datetime | None
    times_sent: int = 0
    last_sent: datetime | None = None
    last_success: datetime | None = None
    last_failure: datetime | None = None
    last_failure_reason: str = ""
    fails: int = 0

    def delivers(self) -> bool:
        """Say whether it is switched on and its last attempt did not fail."""
        return self.status == "active" and not self.fails


def read_mark(description: str) -> Mark | None:
    """Return whose subscription a description names, ``None`` if none of ours."""
    found = _MARK.fullmatch(description)
    return Mark(*found.groups()) if found else None


def read_subscription(body: object) -> Subscription:
    """Return a subscription from a broker's answer; raises ``Unreadable``."""
    if not isinstance(body, dict) or not isinstance(body.get("id"), str):
        raise Unreadable("a subscription without an id")
    notification = body.get("notification", {})
    if not isinstance(notification, dict):
        raise Unreadable(f"subscription {body['id'][:80]}: notification is not an object")
    return Subscription(
        id=body["id"],
        mark=read_mark(str(body.get("description", ""))),
        status=str(body.get("status", "active"))[:20],
        expires=_moment(body, "expires"),
        times_sent=_count(notification, "timesSent"),
        last_sent=_moment(notification, "lastNotification"),
        last_success=_moment(notification, "lastSuccess"),
        last_failure=_moment(notification, "lastFailure"),
        last_failure_reason=str(notification.get("lastFailureReason", ""))[:200],
        fails=_count(notification, "failsCounter"),
    )


def check_key(text: str) -> str:
    """Return ``text`` if it may name an owner or a subscription; raises ``BadInput``."""
    if not _KEY.fullmatch(text):
        raise BadInput(f"not a key (a-z, 0-9, _ . : -, at most 64): {text[:80]!r}")
    return text


def _moment(body: Mapping[str, Any], name: str) -> datetime | None:
    return None if body.get(name) in (None, "") else read_moment(body[name])


def _count(body: Mapping[str, Any], name: str) -> int:
    found = body.get(name, 0)
    if isinstance(found, bool) or not isinstance(found, int) or found < 0:
        raise Unreadable(f"{name} is not a count")
    return found

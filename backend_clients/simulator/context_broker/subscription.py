"""Subscriptions: read from a body, matched with changes, shown with their counters."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from datetime import datetime
from urllib.parse import urlsplit

from backend_clients.simulator.context_broker import moment
from backend_clients.simulator.context_broker.entity import View, check_members
from backend_clients.simulator.context_broker.json_text import Json
from backend_clients.simulator.context_broker.names import check_value
from backend_clients.simulator.context_broker.parameters import selection_of
from backend_clients.simulator.context_broker.refusal import Refusal, bad_request
from backend_clients.simulator.context_broker.selection import Naming, Selection

ALTERATIONS = ("entityCreate", "entityChange", "entityUpdate", "entityDelete")
FORMATS = ("normalized", "keyValues", "values", "simplifiedNormalized", "simplifiedKeyValues")
MEMBERS = {"description", "subject", "notification", "expires", "throttling", "status"}
DEFAULT_TIMEOUT_S = 5.0  # Orion's own
STATES = ("active", "inactive", "oneshot")
CONDITION = {"attrs", "expression", "alterationTypes", "notifyOnMetadataChange"}
NOTIFICATION = {
    "attrs", "exceptAttrs", "http", "httpCustom", "mqtt", "mqttCustom", "attrsFormat", "metadata", "onlyChangedAttrs",
    "covered", "maxFailsLimit",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Target:
    """Where notifications go; headers and queries are those of ``httpCustom``."""

    url: str
    headers: tuple[tuple[str, str], ...] = ()
    qs: tuple[tuple[str, str], ...] = ()
    timeout_s: float = DEFAULT_TIMEOUT_S


@dataclass(frozen=True, slots=True)
class Rule:
    """What a subscription asks for, read from its body."""

    selection: Selection
    condition_attrs: frozenset[str]
    alterations: frozenset[str]
    on_metadata: bool
    target: Target
    view: View
    wire_format: str
    only_changed: bool
    covered: bool
    max_fails: int
    throttling_s: float
    expires: datetime | None


@dataclass(slots=True)
class Subscription:
    """A subscription and what became of its notifications; times are wall clock, UTC."""

    id: str
    body: dict[str, Json]
    rule: Rule
    paths: tuple[str, ...]
    status: str = "active"
    times_sent: int = 0
    last_sent: datetime | None = None
    last_success: datetime | None = None
    last_success_code: int = 0
    last_failure: datetime | None = None
    last_failure_reason: str = ""
    fails_in_a_row: int = 0
    throttle_mono_s: float | None = field(default=None, repr=False)

    def state(self, now: datetime) -> str:
        """Return the status that a reader is told."""
        expired = self.rule.expires is not None and self.rule.expires <= now
        return "expired" if expired else self.status

    def render(self, now: datetime) -> Json:
        """Return the body that a reader is given."""
        body = self.body
        notification = {
            "attrs": [],
            "onlyChangedAttrs": False,
            "attrsFormat": "normalized",
            "covered": False,
            **body["notification"],
            **self._counters(),
        }
        condition = {"attrs": [], "notifyOnMetadataChange": True, **body["subject"].get("condition", {})}
        subject = {"entities": body["subject"]["entities"], "condition": condition}
        shown: dict[str, Json] = {"id": self.id, **{k: body[k] for k in ("description", "throttling") if k in body}}
        if self.rule.expires is not None:
            shown["expires"] = moment.text_of(self.rule.expires)
        return {**shown, "status": self.state(now), "subject": subject, "notification": notification}

    def _counters(self) -> dict[str, Json]:
        times = {
            "lastNotification": self.last_sent,
            "lastSuccess": self.last_success,
            "lastFailure": self.last_failure,
        }
        shown: dict[str, Json] = {name: moment.text_of(at) for name, at in times.items() if at is not None}
        if self.times_sent:
            shown["timesSent"] = self.times_sent
        if self.last_success is not None:
            shown["lastSuccessCode"] = self.last_success_code
        if self.last_failure is not None:
            shown["lastFailureReason"] = self.last_failure_reason
        if self.fails_in_a_row:
            shown["failsCounter"] = self.fails_in_a_row
        return shown


def read_rule(body: dict[str, Json]) -> Rule:
    """Return what a subscription's body asks for, or refuse it."""
    check_members(body, MEMBERS, "subscription")
    check_value("subscription description", body.get("description", ""))
    subject, notification = _object(body, "subject"), _object(body, "notification")
    check_members(subject, {"entities", "condition"}, "subject")
    check_members(notification, NOTIFICATION, "notification")
    condition = _object(subject, "condition", {})
    check_members(condition, CONDITION, "condition")
    if body.get("status", "active") not in STATES:
        raise bad_request("invalid status value for a subscription")
    alterations = _texts(condition, "alterationTypes") or ("entityCreate", "entityChange")
    if not set(alterations) <= set(ALTERATIONS):
        raise bad_request("not supported alteration type")
    wire_format = notification.get("attrsFormat", "normalized")
    if wire_format not in FORMATS:
        raise bad_request("invalid attrsFormat (accepted values: keyValues, normalized, values)")
    return Rule(
        selection=selection_of(_namings(subject), _object(condition, "expression", {})),
        condition_attrs=frozenset(_texts(condition, "attrs")),
        alterations=frozenset(alterations),
        on_metadata=condition.get("notifyOnMetadataChange", True) is True,
        target=_target(notification),
        view=_view(notification, wire_format),
        wire_format=wire_format,
        only_changed=notification.get("onlyChangedAttrs", False) is True,
        covered=notification.get("covered", False) is True,
        max_fails=int(_number(notification, "maxFailsLimit")),
        throttling_s=_number(body, "throttling"),
        expires=_expires(body.get("expires")),
    )


def _view(notification: dict[str, Json], wire_format: str) -> View:
    attrs, left_out = _texts(notification, "attrs"), _texts(notification, "exceptAttrs")
    if attrs and left_out:
        raise bad_request("http notification has attrs and exceptAttrs")
    form = {"simplifiedNormalized": "normalized", "simplifiedKeyValues": "keyValues"}.get(wire_format, wire_format)
    return View(form, attrs, _texts(notification, "metadata"), frozenset(left_out))


def _namings(subject: dict[str, Json]) -> tuple[Naming, ...]:
    entities = subject.get("entities")
    if not isinstance(entities, list) or not entities:
        raise bad_request("no subject entities specified" if entities is None else "subject entities is empty")
    return tuple(naming_of(item) for item in entities)


def naming_of(item: Json) -> Naming:
    """Return one member of an ``entities`` list."""
    if not isinstance(item, dict) or not item.keys() <= {"id", "idPattern", "type", "typePattern"}:
        raise bad_request("invalid member of entities")
    if ("id" in item) == ("idPattern" in item):
        raise bad_request("entity needs exactly one of id and idPattern")
    if "type" in item and "typePattern" in item:
        raise bad_request("type and typePattern cannot be used at the same time")
    if not all(isinstance(text, str) and text for text in item.values()):
        raise bad_request("members of entities must be texts that are not empty")
    for pattern in (item.get("idPattern", ""), item.get("typePattern", "")):
        _check_pattern(pattern)
    types = (item["type"],) if "type" in item else ()
    ids = (item["id"],) if "id" in item else ()
    return Naming(ids, types, item.get("idPattern", ""), item.get("typePattern", ""))


def _check_pattern(pattern: str) -> None:
    try:
        re.compile(pattern)
    except re.error as error:
        raise bad_request("Invalid regex for entity id pattern") from error


def _target(notification: dict[str, Json]) -> Target:
    ways = [way for way in ("http", "httpCustom", "mqtt", "mqttCustom") if way in notification]
    if len(ways) != 1:
        raise bad_request("notification needs exactly one of http, httpCustom, mqtt and mqttCustom")
    if ways[0].startswith("mqtt"):
        raise Refusal(501, "NotImplemented", "the simulated broker sends notifications by HTTP only")
    way = _object(notification, ways[0])
    check_members(way, {"url", "timeout"} if ways[0] == "http" else {"url", "timeout", "headers", "qs"}, ways[0])
    url = way.get("url", "")
    if not isinstance(url, str) or urlsplit(url).scheme not in ("http", "https") or not urlsplit(url).hostname:
        raise bad_request("Invalid URL parsing notification url")
    check_value("notification url", url)
    timeout_s = _number(way, "timeout") / 1000 or DEFAULT_TIMEOUT_S
    return Target(url, _pairs(way, "headers"), _pairs(way, "qs"), timeout_s)


def _pairs(way: dict[str, Json], name: str) -> tuple[tuple[str, str], ...]:
    found = _object(way, name, {})
    if not all(isinstance(value, str) for value in found.values()):
        raise bad_request(f"{name} of httpCustom must be texts")
    return tuple(found.items())


def _expires(given: Json) -> datetime | None:
    if given in (None, ""):
        return None
    found = moment.parse(given) if isinstance(given, str) else None
    if found is None:
        raise bad_request("expires has an invalid format")
    return found


def _object(body: dict[str, Json], name: str, default: dict[str, Json] | None = None) -> dict[str, Json]:
    found = body.get(name, default)
    if not isinstance(found, dict):
        raise bad_request(f"{name} is missing or not a JSON object")
    return found


def _texts(body: dict[str, Json], name: str) -> tuple[str, ...]:
    found = body.get(name, [])
    if not isinstance(found, list) or not all(isinstance(item, str) and item for item in found):
        raise bad_request(f"{name} must be a list of texts that are not empty")
    return tuple(found)


def _number(body: dict[str, Json], name: str) -> float:
    found = body.get(name, 0)
    if isinstance(found, bool) or not isinstance(found, int | float) or found < 0:
        raise bad_request(f"{name} must be a positive number")
    return float(found)

"""Attributes: what a request may say of one, how it is kept and given back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime

from backend_clients.simulator.context_broker import moment
from backend_clients.simulator.context_broker.json_text import Json, stored
from backend_clients.simulator.context_broker.names import check_value, checked_name
from backend_clients.simulator.context_broker.place import is_geo_type, kept_geometry
from backend_clients.simulator.context_broker.refusal import bad_request

UNRESTRICTED = "TextUnrestricted"
DATE_TYPES = ("DateTime", "ISO8601")
BUILT_IN = ("dateCreated", "dateModified", "dateExpires", "servicePath", "alterationType")


@dataclass(frozen=True, slots=True)
class Metadatum:
    """One metadata item of an attribute."""

    type: str
    value: Json


@dataclass(frozen=True, slots=True)
class Given:
    """What a request says of an attribute; ``type`` is ``None`` when only the value was put."""

    type: str | None
    value: Json
    metadata: Mapping[str, Metadatum] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Attribute:
    """An attribute as it is kept."""

    type: str
    value: Json
    metadata: Mapping[str, Metadatum]
    created: datetime
    modified: datetime
    previous: Json = None

    def is_location(self) -> bool:
        """Say whether geo queries look at it."""
        ignored = self.metadata.get("ignoreType")
        return is_geo_type(self.type) and self.value is not None and not (ignored and ignored.value is True)

    def same_content(self, other: Attribute) -> bool:
        """Say whether type, value and metadata are those of ``other``."""
        return (self.type, self.value, self.metadata) == (other.type, other.value, other.metadata)


def derived_type(value: Json) -> str:
    """Return the type of a value that came without one."""
    if value is None:
        return "None"
    if isinstance(value, bool):
        return "Boolean"
    if isinstance(value, int | float):
        return "Number"
    return "Text" if isinstance(value, str) else "StructuredValue"


def read_attribute(body: Json) -> Given:
    """Return the attribute of a normalized body."""
    if not isinstance(body, dict):
        raise bad_request("attribute must be a JSON object, unless keyValues option is used")
    if not body.keys() <= {"type", "value", "metadata"}:
        raise bad_request("unrecognized property for context attribute")
    value = body.get("value")
    kind = checked_name("attribute type", body["type"]) if "type" in body else derived_type(value)
    metadata = body.get("metadata", {})
    if not isinstance(metadata, dict):
        raise bad_request("metadata must be a JSON object")
    return Given(kind, _kept_value(kind, value), {name: _metadatum(name, item) for name, item in metadata.items()})


def read_plain(value: Json) -> Given:
    """Return the attribute of a ``keyValues`` member."""
    kind = derived_type(value)
    return Given(kind, _kept_value(kind, value))


def read_value(value: Json, kind: str) -> Given:
    """Return a value that replaces another; its type stays."""
    return Given(None, _kept_value(kind, value))


def normalized(attribute: Attribute, metadata: tuple[str, ...] = ()) -> Json:
    """Return the long form; ``metadata`` are the items asked for by name, none means all but built-in ones."""
    every = {name: {"type": item.type, "value": item.value} for name, item in attribute.metadata.items()}
    if not metadata:
        return {"type": attribute.type, "value": attribute.value, "metadata": every}
    chosen: dict[str, Json] = dict(every) if "*" in metadata else {}
    for name in metadata:
        if name == "dateCreated":
            chosen[name] = {"type": "DateTime", "value": moment.text_of(attribute.created)}
        elif name == "dateModified":
            chosen[name] = {"type": "DateTime", "value": moment.text_of(attribute.modified)}
        elif name == "previousValue" and attribute.previous is not None:
            chosen[name] = {"type": derived_type(attribute.previous), "value": attribute.previous}
        elif name in every:
            chosen[name] = every[name]
    return {"type": attribute.type, "value": attribute.value, "metadata": chosen}


def _kept_value(kind: str, value: Json) -> Json:
    if kind != UNRESTRICTED:
        check_value("attribute value", value)
    if kind in DATE_TYPES and value is not None and not _is_operator(value):
        return _date(value, "attribute value")
    if is_geo_type(kind) and value is not None:
        return kept_geometry(kind, value)
    return stored(value)


def _metadatum(name: str, body: Json) -> Metadatum:
    checked_name("metadata name", name)
    if not isinstance(body, dict):
        raise bad_request("metadata must be a JSON object, unless keyValues option is used")
    if not body.keys() <= {"type", "value"}:
        raise bad_request("unrecognized property for context metadata")
    value = body.get("value")
    kind = checked_name("metadata type", body["type"]) if "type" in body else derived_type(value)
    if kind != UNRESTRICTED:
        check_value("metadata value", value)
    if kind in DATE_TYPES and value is not None:
        value = _date(value, "metadata value")
    return Metadatum(kind, stored(value))


def _date(value: Json, what: str) -> str:
    found = moment.parse(value) if isinstance(value, str) else None
    if found is None:
        raise bad_request(f"date has invalid format in {what}")
    return moment.text_of(found)


def _is_operator(value: Json) -> bool:
    return isinstance(value, dict) and any(key.startswith("$") for key in value)

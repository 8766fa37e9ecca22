"""Entities and attributes, checked on the way in and on the way out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import datetime

from pydantic import BaseModel, ConfigDict, Field, JsonValue, TypeAdapter, ValidationError

from backend_clients.ngsi.errors import BadInput, Unreadable
from backend_clients.ngsi.escaping import escape_value, unescape_value
from backend_clients.ngsi.identifier import EntityRef, check_attribute_name, check_id, check_ref
from backend_clients.ngsi.moment import moment_text, read_moment

EXACT = 2**53  # a broker keeps doubles: larger whole numbers lose digits
UNRESTRICTED = "TextUnrestricted"  # Orion takes any character in it
BUILT_IN = ("dateCreated", "dateModified", "servicePath", "alterationType")


class Metadatum(BaseModel):
    """One metadata item; a type of ``None`` lets the broker derive it."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    type: str | None = None
    value: JsonValue = None


class Attribute(BaseModel):
    """One attribute; texts are plain here and escaped on the wire."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    type: str | None = None
    value: JsonValue = None
    metadata: dict[str, Metadatum] = Field(default_factory=dict)

    def moment(self) -> datetime:
        """Return the value as an aware time; raises ``Unreadable`` if it is none."""
        return read_moment(self.value)

    def to_wire(self) -> dict[str, JsonValue]:
        """Return the normalized form, escaped; raises ``BadInput`` for what would be refused or lose digits."""
        body: dict[str, JsonValue] = {"value": _sent(self.type, self.value)}
        if self.type is not None:
            body["type"] = check_id(self.type)
        if self.metadata:
            body["metadata"] = {check_id(name): _metadatum(item) for name, item in self.metadata.items()}
        return body


Attributes = Mapping[str, Attribute]
_ATTRIBUTES = TypeAdapter(dict[str, Attribute])


class Entity(BaseModel):
    """An entity; ``ref`` names it."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    ref: EntityRef
    attributes: dict[str, Attribute] = Field(default_factory=dict)

    def value(self, name: str) -> JsonValue:
        """Return the value of an attribute, ``None`` if there is none."""
        attribute = self.attributes.get(name)
        return None if attribute is None else attribute.value

    def to_wire(self) -> dict[str, JsonValue]:
        """Return the normalized form, escaped; raises ``BadInput``."""
        ref = check_ref(self.ref)
        return {"id": ref.id, "type": ref.type, **attributes_to_wire(self.attributes)}


def attributes_to_wire(attributes: Attributes) -> dict[str, JsonValue]:
    """Return attributes in the normalized form, without those that only a broker sets; raises ``BadInput``."""
    own = {name: item for name, item in attributes.items() if name not in BUILT_IN}
    return {check_attribute_name(name): item.to_wire() for name, item in own.items()}


def entity_from_wire(body: object) -> Entity:
    """Return the entity of a normalized body; raises ``Unreadable``."""
    if not isinstance(body, dict) or not isinstance(body.get("id"), str) or not isinstance(body.get("type"), str):
        raise Unreadable("an entity without id and type")
    rest = {name: item for name, item in body.items() if name not in ("id", "type")}
    try:
        attributes = _ATTRIBUTES.validate_python(rest)
    except ValidationError as error:
        raise Unreadable(f"entity {body['id'][:80]}: {_first_problem(error)}") from error
    plain = {name: _received(attribute) for name, attribute in attributes.items()}
    return Entity.model_construct(ref=EntityRef(body["id"], body["type"]), attributes=plain)


def _received(attribute: Attribute) -> Attribute:
    metadata = {
        name: Metadatum.model_construct(type=item.type, value=_read(item.type, item.value))
        for name, item in attribute.metadata.items()
    }
    value = _read(attribute.type, attribute.value)
    return Attribute.model_construct(type=attribute.type, value=value, metadata=metadata)


def _read(kind: str | None, value: JsonValue) -> JsonValue:
    return value if kind == UNRESTRICTED else unescape_value(value)


def _metadatum(item: Metadatum) -> JsonValue:
    kind = {} if item.type is None else {"type": check_id(item.type)}
    return {**kind, "value": _sent(item.type, item.value)}


def _sent(kind: str | None, value: JsonValue) -> JsonValue:
    check_json(value)
    if kind != UNRESTRICTED:
        return escape_value(value)
    if not isinstance(value, str):
        raise BadInput(f"{UNRESTRICTED} is for texts")
    return value


def check_json(value: object) -> None:
    """Refuse what JSON or a broker's numbers cannot hold; raises ``BadInput``."""
    if isinstance(value, dict):
        for key, item in value.items():
            check_json(key)
            check_json(item)
    elif isinstance(value, list):
        for item in value:
            check_json(item)
    elif isinstance(value, float) and not math.isfinite(value):
        raise BadInput(f"not a number for JSON: {value}")
    elif isinstance(value, int) and abs(value) > EXACT:
        raise BadInput(f"a whole number over 2^53 would lose digits: {value}")
    elif isinstance(value, str) and any("\ud800" <= c <= "\udfff" for c in value):
        raise BadInput("a text must be valid Unicode")


def number(value: float, **metadata: Metadatum) -> Attribute:
    """Return a number; a broker keeps nine decimals."""
    return Attribute(type="Number", value=value, metadata=metadata)


def text(value: str, **metadata: Metadatum) -> Attribute:
    """Return a text; any characters."""
    return Attribute(type="Text", value=value, metadata=metadata)


def boolean(value: bool, **metadata: Metadatum) -> Attribute:
    """Return a truth value."""
    return Attribute(type="Boolean", value=value, metadata=metadata)


def date_time(value: datetime, **metadata: Metadatum) -> Attribute:
    """Return an aware time; a broker keeps milliseconds, UTC."""
    return Attribute(type="DateTime", value=moment_text(value), metadata=metadata)


def structured(value: JsonValue, **metadata: Metadatum) -> Attribute:
    """Return an object or a list."""
    return Attribute(type="StructuredValue", value=value, metadata=metadata)


def relationship(to: EntityRef) -> Attribute:
    """Return the link to another entity."""
    return Attribute(type="Relationship", value=check_id(to.id))


def _first_problem(error: ValidationError) -> str:
    first = error.errors(include_url=False, include_input=False)[0]
    return f"{'.'.join(str(step) for step in first['loc'])[:120]}: {first['msg']}"

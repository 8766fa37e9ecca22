"""Key-values and the normalized form of a context broker, both ways."""

from __future__ import annotations

from typing import Any

from backend_clients.ngsi.entity import BUILT_IN, Attribute, Entity, Metadatum
from backend_clients.ngsi.identifier import EntityRef
from hmi.fiware.urn import KeyValues

_PLACE = "location"
_PLACES = frozenset({_PLACE, "landLocation", "startPoint", "endPoint"})
_DATES = frozenset({"commandTime", "receivedTime", "validFrom", "validTo", "observedAt"})
_NOT_SEEN = {"ignoreType": Metadatum(value=True)}  # a broker lets geo queries see one place of an entity


def normalized(entity: KeyValues) -> Entity:
    """Return an entity as a broker keeps it: each attribute with its type, one place that geo queries see."""
    rest = {name: value for name, value in entity.items() if name not in ("id", "type")}
    attributes = {name: _attribute(name, value, has_place=_PLACE in rest) for name, value in rest.items()}
    return Entity.model_construct(ref=EntityRef(entity["id"], entity["type"]), attributes=attributes)


def key_values(entity: Entity) -> KeyValues:
    """Return the simplified form, without what only a broker sets."""
    values = {name: one.value for name, one in entity.attributes.items() if name not in BUILT_IN}
    return {"id": entity.ref.id, "type": entity.ref.type, **values}


def _attribute(name: str, value: Any, *, has_place: bool) -> Attribute:
    if name in _PLACES:
        metadata = _NOT_SEEN if has_place and name != _PLACE else {}
        return Attribute.model_construct(type="geo:json", value=value, metadata=metadata)
    return Attribute.model_construct(type=_type(name, value), value=value, metadata={})


def _type(name: str, value: Any) -> str:
    match value:
        case bool():
            return "Boolean"
        case int() | float():
            return "Number"
        case list() | dict():
            return "StructuredValue"
    if name in _DATES or name.startswith("date") or name.endswith("At"):
        return "DateTime"
    is_link = name.startswith(("has", "ref")) or name == "belongsTo"
    return "Relationship" if is_link else "Text"

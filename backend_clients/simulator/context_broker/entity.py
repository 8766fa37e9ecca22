"""Entities: read from a body, kept, and given back in the form asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import NamedTuple

from shapely.geometry.base import BaseGeometry

from backend_clients.simulator.context_broker import moment
from backend_clients.simulator.context_broker.attribute import (
    BUILT_IN,
    Attribute,
    Given,
    normalized,
    read_attribute,
    read_plain,
)
from backend_clients.simulator.context_broker.json_text import Json
from backend_clients.simulator.context_broker.names import checked_name
from backend_clients.simulator.context_broker.place import geometry_of
from backend_clients.simulator.context_broker.refusal import Refusal, bad_request

DEFAULT_TYPE = "Thing"


class Key(NamedTuple):
    """What makes an entity one of its kind within a tenant."""

    id: str
    type: str
    path: str


@dataclass(frozen=True, slots=True)
class Entity:
    """An entity as it is kept."""

    key: Key
    attributes: Mapping[str, Attribute]
    created: datetime
    modified: datetime

    def location(self) -> BaseGeometry | None:
        """Return where it is, lon and lat in degrees; ``None`` if it has no location."""
        found = next((a for a in self.attributes.values() if a.is_location()), None)
        return geometry_of(found.type, found.value) if found else None


@dataclass(frozen=True, slots=True)
class View:
    """How answers show entities.

    Args:
        form: ``normalized``, ``keyValues``, ``values`` or ``unique``.
        attrs: attributes asked for, in order; none means all but built-in ones.
        metadata: metadata asked for.
        left_out: attributes never shown.
    """

    form: str = "normalized"
    attrs: tuple[str, ...] = ()
    metadata: tuple[str, ...] = ()
    left_out: frozenset[str] = frozenset()


def read_entity(body: Mapping[str, Json], *, plain: bool = False) -> tuple[str, str, dict[str, Given]]:
    """Return id, type and attributes of a body; ``plain`` is the ``keyValues`` form."""
    name = checked_name("entity id", body.get("id", ""))
    kind = checked_name("entity type", body["type"]) if "type" in body else DEFAULT_TYPE
    return name, kind, read_attributes({k: v for k, v in body.items() if k not in ("id", "type")}, plain=plain)


def read_attributes(body: Mapping[str, Json], *, plain: bool = False) -> dict[str, Given]:
    """Return the attributes of a body without id and type; built-in ones are not set by anybody."""
    read = read_plain if plain else read_attribute
    return {checked_name("attribute name", k): read(v) for k, v in body.items() if k not in BUILT_IN}


def check_one_location(attributes: Mapping[str, Attribute]) -> None:
    """Refuse a second location."""
    if sum(attribute.is_location() for attribute in attributes.values()) > 1:
        raise Refusal(
            413,
            "NoResourcesAvailable",
            "You cannot use more than one geo location attribute when creating an entity [see Orion user manual]",
        )


def render(entity: Entity, view: View, *, alteration: str = "") -> Json:
    """Return an entity in the form of ``view``; ``alteration`` is what ``alterationType`` says, if asked for."""
    attributes = render_attributes(entity, view, alteration=alteration)
    if view.form == "values":
        return list(attributes.values())
    if view.form == "unique":
        values = list(attributes.values())
        return [value for place, value in enumerate(values) if value not in values[:place]]
    return {"id": entity.key.id, "type": entity.key.type, **attributes}


def render_attributes(entity: Entity, view: View, *, alteration: str = "") -> dict[str, Json]:
    """Return the attributes of an entity in the form of ``view``, by name."""
    shown: dict[str, Json] = {}
    for name in _wanted(entity, view):
        attribute = entity.attributes.get(name) or _built_in(entity, name, alteration)
        if attribute is not None and name not in view.left_out:
            metadata = view.metadata if name in entity.attributes else ()
            shown[name] = normalized(attribute, metadata) if view.form == "normalized" else attribute.value
    return shown


def _wanted(entity: Entity, view: View) -> list[str]:
    if not view.attrs:
        return sorted(entity.attributes)
    names: list[str] = []
    for name in view.attrs:
        names += sorted(entity.attributes) if name == "*" else [name]
    return list(dict.fromkeys(names))


def _built_in(entity: Entity, name: str, alteration: str) -> Attribute | None:
    texts = {
        "dateCreated": ("DateTime", moment.text_of(entity.created)),
        "dateModified": ("DateTime", moment.text_of(entity.modified)),
        "servicePath": ("Text", entity.key.path),
        "alterationType": ("Text", alteration),
    }
    kind, value = texts.get(name, ("", ""))
    return Attribute(kind, value, {}, entity.created, entity.modified) if value else None


def check_members(body: Mapping[str, Json], allowed: set[str], what: str) -> None:
    """Refuse a body with a member that nobody knows."""
    strange = sorted(body.keys() - allowed)
    if strange:
        raise bad_request(f"Unknown field in {what}: {strange[0]}"[:200])

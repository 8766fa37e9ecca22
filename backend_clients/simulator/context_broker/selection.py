"""Which entities a request means, in which order, and which page of them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from backend_clients.simulator.context_broker import moment
from backend_clients.simulator.context_broker.entity import Entity
from backend_clients.simulator.context_broker.expression import Expression
from backend_clients.simulator.context_broker.json_text import Json
from backend_clients.simulator.context_broker.place import GeoFilter
from backend_clients.simulator.context_broker.tenancy import Scope

DISTANCE = "geo:distance"


@dataclass(frozen=True, slots=True)
class Naming:
    """Ids and types; each list empty for any, patterns are searched for anywhere in the text."""

    ids: tuple[str, ...] = ()
    types: tuple[str, ...] = ()
    id_pattern: str = ""
    type_pattern: str = ""

    def names(self, entity: Entity) -> bool:
        """Say whether an entity is named; a pattern that is none names nothing."""
        key = entity.key
        return (
            (not self.ids or key.id in self.ids)
            and (not self.types or key.type in self.types)
            and _found(self.id_pattern, key.id)
            and _found(self.type_pattern, key.type)
        )


@dataclass(frozen=True, slots=True)
class Selection:
    """Names (one of them is enough), conditions and a place; all must hold."""

    namings: tuple[Naming, ...] = (Naming(),)
    expressions: tuple[Expression, ...] = ()
    geo: GeoFilter | None = None

    def means(self, entity: Entity) -> bool:
        """Say whether an entity is meant."""
        if not any(naming.names(entity) for naming in self.namings):
            return False
        if not all(expression.matches(entity) for expression in self.expressions):
            return False
        if self.geo is None:
            return True
        place = entity.location()
        return place is not None and self.geo.matches(place)

    def pick(self, entities: Iterable[Entity], scope: Scope) -> list[Entity]:
        """Return those that are meant and seen, oldest first."""
        return [entity for entity in entities if scope.sees(entity.key.path) and self.means(entity)]

    def sort(self, entities: list[Entity], keys: tuple[str, ...]) -> list[Entity]:
        """Return them ordered by attributes; ``!`` turns one round, what has none comes first.

        ``geo:distance`` works alone and with a ``near`` query; elsewhere it is an attribute that nobody has.
        """
        if keys == (DISTANCE,) and self.geo is not None and self.geo.relation == "near":
            return sorted(entities, key=self._distance_m)
        for key in reversed(keys):
            entities = sorted(entities, key=_Rank(key.removeprefix("!")), reverse=key.startswith("!"))
        return entities

    def _distance_m(self, entity: Entity) -> float:
        place = entity.location()
        assert self.geo is not None
        assert place is not None  # of entities that a near query means
        return self.geo.distance_m(place)


@dataclass(frozen=True, slots=True)
class Page:
    """Which part of a list is wanted."""

    limit: int = 20
    offset: int = 0
    with_count: bool = False
    order: tuple[str, ...] = field(default_factory=tuple)


def _found(pattern: str, text: str) -> bool:
    if not pattern:
        return True
    try:
        return re.search(pattern, text) is not None
    except re.error:
        return False


class _Rank:
    """Orders values as the store does: nothing, numbers, texts, objects, arrays, truth."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __call__(self, entity: Entity) -> tuple[int, Json]:
        value = self._value(entity)
        if value is None:
            return (0, 0)
        if isinstance(value, bool):
            return (5, value)
        if isinstance(value, int | float):
            return (1, value)
        return (2, value) if isinstance(value, str) else (3, str(value))

    def _value(self, entity: Entity) -> Json:
        attribute = entity.attributes.get(self._name)
        if attribute is not None:
            return attribute.value
        built_in = _BUILT_IN.get(self._name)
        return built_in(entity) if built_in else None


_BUILT_IN: dict[str, Callable[[Entity], str]] = {
    "id": lambda entity: entity.key.id,
    "type": lambda entity: entity.key.type,
    "servicePath": lambda entity: entity.key.path,
    "dateCreated": lambda entity: moment.text_of(entity.created),
    "dateModified": lambda entity: moment.text_of(entity.modified),
}

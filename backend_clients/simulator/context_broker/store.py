"""What the broker knows, tenant by tenant, in memory."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from backend_clients.simulator.context_broker.attribute import Attribute, Given, derived_type
from backend_clients.simulator.context_broker.entity import Entity, Key, check_one_location
from backend_clients.simulator.context_broker.operators import apply_operator
from backend_clients.simulator.context_broker.refusal import ambiguous, no_entity
from backend_clients.simulator.context_broker.subscription import Subscription
from backend_clients.simulator.context_broker.tenancy import Scope
from backend_clients.simulator.context_broker.update import Action, How, Outcome


@dataclass(frozen=True, slots=True)
class Change:
    """Something happened to an entity: what subscriptions look at."""

    kind: str  # entityCreate, entityUpdate or entityDelete
    entity: Entity
    touched: frozenset[str]
    changed: frozenset[str]
    only_metadata: frozenset[str] = frozenset()
    forced: bool = False


@dataclass(slots=True)
class Tenant:
    """One tenant's entities, oldest first, their keys by id, and its subscriptions."""

    entities: dict[Key, Entity] = field(default_factory=dict)
    by_id: dict[str, set[Key]] = field(default_factory=dict)
    subscriptions: dict[str, Subscription] = field(default_factory=dict)


OnChange = Callable[[str, Change], None]


class Store:
    """Holds all tenants and tells of each change.

    Args:
        on_change: called with the tenant's name and the change, after it took effect.
    """

    def __init__(self, on_change: OnChange) -> None:
        self._tenants: dict[str, Tenant] = {}
        self._on_change = on_change

    def tenant(self, name: str) -> Tenant:
        """Return a tenant; it begins with its first request."""
        return self._tenants.setdefault(name, Tenant())

    def clear(self) -> None:
        """Forget everything."""
        self._tenants.clear()

    def seen(self, scope: Scope) -> Iterable[Entity]:
        """Return what a reader sees, oldest first."""
        return [e for e in self.tenant(scope.tenant).entities.values() if scope.sees(e.key.path)]

    def one(self, scope: Scope, name: str, types: tuple[str, ...]) -> Entity:
        """Return the one entity of that id, or refuse: none, or several."""
        tenant = self.tenant(scope.tenant)
        keys = [key for key in tenant.by_id.get(name, ()) if scope.sees(key.path) and (not types or key.type in types)]
        found = [tenant.entities[key] for key in keys]
        if not found:
            raise no_entity()
        if len(found) > 1:
            raise ambiguous()
        return found[0]

    def create(self, tenant: str, key: Key, given: Mapping[str, Given], how: How) -> None:
        """Keep a new entity."""
        attributes = {name: _first(item, how) for name, item in given.items()}
        check_one_location(attributes)
        entity = Entity(key, attributes, how.now, how.now)
        self.tenant(tenant).entities[key] = entity
        self.tenant(tenant).by_id.setdefault(key.id, set()).add(key)
        names = frozenset(attributes)
        self._on_change(tenant, Change("entityCreate", entity, names, names))

    def apply(
        self, tenant: str, entity: Entity, action: Action, given: Mapping[str, Given], how: How, *, forced: bool = False
    ) -> Outcome:
        """Do an update; what the outcome refuses is for the caller to answer."""
        outcome = action(entity, given, how)
        if outcome.touched or not given:
            self.tenant(tenant).entities[entity.key] = outcome.entity
            change = Change(
                "entityUpdate", outcome.entity, outcome.touched, outcome.changed, outcome.only_metadata, forced
            )
            self._on_change(tenant, change)
        return outcome

    def delete(self, tenant: str, entity: Entity) -> None:
        """Forget an entity."""
        kept = self.tenant(tenant)
        del kept.entities[entity.key]
        kept.by_id[entity.key.id].discard(entity.key)
        if not kept.by_id[entity.key.id]:
            del kept.by_id[entity.key.id]
        names = frozenset(entity.attributes)
        self._on_change(tenant, Change("entityDelete", entity, names, names))


def _first(item: Given, how: How) -> Attribute:
    value = apply_operator(None, item.value)
    return Attribute(item.type or derived_type(value), value, item.metadata, how.now, how.now)

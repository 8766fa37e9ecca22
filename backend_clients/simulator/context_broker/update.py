"""What an update makes of an entity: pure, one function per action."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from datetime import datetime

from backend_clients.simulator.context_broker.attribute import Attribute, Given, derived_type
from backend_clients.simulator.context_broker.entity import Entity, check_one_location
from backend_clients.simulator.context_broker.json_text import stored
from backend_clients.simulator.context_broker.operators import apply_operator
from backend_clients.simulator.context_broker.refusal import Refusal, no_attribute, unprocessable


@dataclass(frozen=True, slots=True)
class Outcome:
    """An entity after an update.

    Args:
        entity: as it is now.
        touched: attributes the request wrote.
        changed: those of them whose value, type or metadata is another now, and those taken away.
        only_metadata: those of the changed whose metadata alone changed.
        refused: attributes that could not be written, in order.
        complaint: what is wrong with the refused ones.
    """

    entity: Entity
    touched: frozenset[str]
    changed: frozenset[str]
    only_metadata: frozenset[str] = frozenset()
    refused: tuple[str, ...] = ()
    complaint: str = ""

    def problem(self) -> Refusal | None:
        """Return how the request is refused although what could be applied is applied; ``None`` if all was."""
        if not self.refused:
            return None
        text = f"{self.complaint}: {self.entity.key.id} - [ {', '.join(self.refused)} ]"
        return unprocessable(text, is_partial=bool(self.touched))


@dataclass(frozen=True, slots=True)
class How:
    """Circumstances of an update."""

    now: datetime
    override_metadata: bool = False


Action = Callable[[Entity, Mapping[str, Given], How], Outcome]


def append(entity: Entity, given: Mapping[str, Given], how: How) -> Outcome:
    """Write every attribute, new or not."""
    return _write(entity, given, how)


def append_strict(entity: Entity, given: Mapping[str, Given], how: How) -> Outcome:
    """Write new attributes; those that exist are refused."""
    there = tuple(name for name in given if name in entity.attributes)
    new = {name: item for name, item in given.items() if name not in there}
    done = _write(entity, new, how)
    return replace(done, refused=there, complaint="one or more of the attributes in the request already exist")


def update(entity: Entity, given: Mapping[str, Given], how: How) -> Outcome:
    """Write attributes that exist; others are refused."""
    missing = tuple(name for name in given if name not in entity.attributes)
    known = {name: item for name, item in given.items() if name not in missing}
    return replace(_write(entity, known, how), refused=missing, complaint="do not exist")


def replace_all(entity: Entity, given: Mapping[str, Given], how: How) -> Outcome:
    """Keep only the attributes given."""
    gone = entity.attributes.keys() - given.keys()
    kept = {name: item for name, item in entity.attributes.items() if name in given}
    done = _write(replace(entity, attributes=kept), given, replace(how, override_metadata=True))
    return replace(done, touched=done.touched | gone, changed=done.changed | gone)


def delete(entity: Entity, given: Mapping[str, Given], how: How) -> Outcome:
    """Take the attributes away; what is not there is a 404."""
    if not given.keys() <= entity.attributes.keys():
        raise no_attribute()
    left = {name: item for name, item in entity.attributes.items() if name not in given}
    gone = frozenset(given)
    return Outcome(replace(entity, attributes=left, modified=how.now), gone, gone)


def _write(entity: Entity, given: Mapping[str, Given], how: How) -> Outcome:
    attributes = dict(entity.attributes)
    changed, only_metadata = set(), set()
    for name, item in given.items():
        before = attributes.get(name)
        after = _written(before, item, how)
        attributes[name] = after
        if before is None or not before.same_content(after):
            changed.add(name)
            if before is not None and (before.type, before.value) == (after.type, after.value):
                only_metadata.add(name)
    check_one_location(attributes)
    modified = how.now if given else entity.modified
    now = replace(entity, attributes=attributes, modified=modified)
    return Outcome(now, frozenset(given), frozenset(changed), frozenset(only_metadata))


def _written(before: Attribute | None, item: Given, how: How) -> Attribute:
    value = stored(apply_operator(before.value if before else None, item.value))
    kind = item.type or (before.type if before else derived_type(value))
    if before is None:
        return Attribute(kind, value, item.metadata, how.now, how.now)
    metadata = item.metadata if how.override_metadata else {**before.metadata, **item.metadata}
    after = Attribute(kind, value, metadata, before.created, how.now, before.value)
    return replace(after, modified=before.modified, previous=before.previous) if before.same_content(after) else after

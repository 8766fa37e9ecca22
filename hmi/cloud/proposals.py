"""What the cloud wants changed on the map: listed until a person takes it or refuses it, never done by itself."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import datetime

from hmi.fiware.map_change import KIND_OF, feature_id_of, is_as_told, mark_of, proposed
from hmi.fiware.urn import KeyValues, Urns
from hmi.mapping.errors import BadFeature
from hmi.mapping.feature import MapFeature
from hmi.mapping.jobs import compare
from hmi.mapping.merging import is_within

MOST = 200  # proposals listed; a cloud that changes a thousand fields at once is looked at by somebody
Wish = tuple[MapFeature | None, str]
_MODEL_OF = {kind: model for model, kind in KIND_OF.items()}


@dataclass(frozen=True, slots=True)
class Proposal:
    """One feature that the cloud wants to be another.

    Args:
        id: of the feature.
        what: ``added``, ``changed`` or ``removed``.
        text: what is different, in a sentence.
        before, after: our feature and theirs; ``None`` is absent.
        problem: why it cannot be taken as it is, empty if it can.
        mark: of what the entity said.
    """

    id: str
    entity_id: str
    kind: str
    name: str
    what: str
    text: str
    before: MapFeature | None
    after: MapFeature | None
    at: datetime
    problem: str = ""
    mark: str = ""


class ProposalBook:
    """The proposals of one farm; on the event loop, in memory: they are read from the cloud again after a restart."""

    def __init__(self, urns: Urns) -> None:
        self._urns = urns
        self._open: dict[str, Proposal] = {}
        self._refused: dict[str, Wish] = {}
        self._fulfilled: dict[str, str] = {}  # mark by feature: on our map, though with changes of our own beside it
        self._left_out: dict[str, str] = {}  # id of the entity by that of the feature
        self._refused_marks: dict[str, str] = {}  # of what the entity said when it was refused
        self._withheld: frozenset[str] = frozenset()  # entities of the map that were not told when it was

    @property
    def left_out(self) -> int:
        """How many changes of the cloud found no room in the list; they are written over no more than the others."""
        return len(self._left_out)

    def all(self) -> list[Proposal]:
        """Return the proposals, the oldest first."""
        return list(self._open.values())

    def get(self, proposal_id: str) -> Proposal | None:
        """Return one, ``None`` if there is none any more."""
        return self._open.get(proposal_id)

    def look(
        self,
        entities: Iterable[KeyValues],
        features: Mapping[str, MapFeature],
        now: datetime,
        names: dict[str, str] | None = None,
    ) -> bool:
        """Take what the cloud has now of some map entities; return whether a proposal came, went or changed."""
        before = dict(self._open)
        for entity in entities:
            if entity["type"] not in KIND_OF:
                continue
            feature_id = feature_id_of(entity, self._urns) or str(entity["id"])[-64:]
            mark, is_told = mark_of(entity), is_as_told(entity)
            if is_told or self._fulfilled.get(feature_id) != mark:
                self._fulfilled.pop(feature_id, None)  # who wants the same once more is heard again
            is_done = is_told or feature_id in self._fulfilled
            found = None if is_done else self._proposal(entity, feature_id, features, now, names or {})
            self._put(feature_id, found and replace(found, mark=mark))
        return before != self._open

    def hold(self, entities: Iterable[KeyValues]) -> None:
        """Leave what was changed in the cloud as it is until it can be looked at."""
        for entity in entities:
            feature_id = feature_id_of(entity, self._urns) or str(entity["id"])[-64:]
            is_known = feature_id in self._open or is_as_told(entity)
            is_refused = self._refused_marks.get(feature_id) == mark_of(entity)  # it says what a person refused
            if entity["type"] in KIND_OF and not is_known and not is_refused:
                self._left_out[feature_id] = str(entity["id"])

    def gone(self, entity_id: str, model: str, features: Mapping[str, MapFeature], now: datetime) -> bool:
        """Take that an entity was deleted in the cloud by somebody else; return whether that is a proposal."""
        feature_id = self._urns.name_of(model, entity_id)
        feature = features.get(feature_id or "")
        if feature is None or feature_id is None or _MODEL_OF.get(feature.kind) != model:
            return False
        self._put(feature_id, Proposal(feature_id, entity_id, feature.kind, feature.title, "removed",
                                       "Deleted in the cloud", feature, None, now))  # fmt: skip
        return True

    def keep(self, entity_ids: Collection[str]) -> bool:
        """Forget what the cloud wants of entities it has no more; return whether a proposal went.

        Args:
            entity_ids: all that are there.
        """
        gone = [key for key, one in self._open.items() if one.what != "removed" and one.entity_id not in entity_ids]
        for key in gone:
            del self._open[key]
        self._left_out = {key: entity for key, entity in self._left_out.items() if entity in entity_ids}
        return bool(gone)

    def vanished(self, entity_id: str) -> bool:
        """Forget what the cloud wants of one entity that is gone; return whether a proposal went."""
        return self.keep(self._held() - {entity_id})

    def clear(self) -> bool:
        """Forget everything: the broker is another one; return whether a proposal went."""
        had_any = bool(self._open)
        for kept in (self._open, self._refused, self._left_out, self._fulfilled, self._refused_marks):
            kept.clear()
        return had_any

    def is_ours_no_more(self, entity: KeyValues, features: Mapping[str, MapFeature]) -> bool:
        """Say whether an entity is of a feature of this farm that is not on the map now."""
        feature_id = self._urns.name_of(entity["type"], str(entity["id"]))
        return feature_id is not None and feature_id not in features

    def drop(self, proposal_id: str) -> None:
        """Forget one, since a person refused it: it does not come back before it is written over with what we have."""
        one = self._open.pop(proposal_id, None)
        if one is not None:
            self._refused[proposal_id] = one.after, one.problem
            self._refused_marks[proposal_id] = one.mark

    def published(self, features: Mapping[str, MapFeature]) -> bool:
        """Take a map that was published: what it fulfils is done; return whether any was."""
        done = [
            one
            for one in self._open.values()
            if not one.problem and is_within(features.get(one.id), one.before, one.after)
        ]
        for one in done:
            del self._open[one.id]
            self._fulfilled[one.id] = one.mark
        return bool(done)

    def held_back(self, entities: Collection[KeyValues]) -> list[KeyValues]:
        """Return the entities that may be written: the cloud's change is not written over while it is open."""
        held = self._held()
        self._withheld = frozenset(entity["id"] for entity in entities if entity["id"] in held)
        return [entity for entity in entities if entity["id"] not in held]

    @property
    def has_let_go(self) -> bool:
        """Whether the map was told without an entity that may be written now."""
        return not self._withheld <= self._held()

    def _held(self) -> set[str]:
        return {one.entity_id for one in self._open.values()} | set(self._left_out.values())

    def _put(self, feature_id: str, found: Proposal | None) -> None:
        known = self._open.get(feature_id)
        self._left_out.pop(feature_id, None)
        if found is None:
            self._refused.pop(feature_id, None)
            self._refused_marks.pop(feature_id, None)
            self._open.pop(feature_id, None)
        elif self._refused.get(feature_id) == (found.after, found.problem):
            return
        elif known is None and len(self._open) >= MOST:
            self._left_out[feature_id] = found.entity_id
        elif known is None or (known.after, known.problem) != (found.after, found.problem):
            self._open[feature_id] = found
        else:
            # as our map is now: what was published since is no difference to it
            self._open[feature_id] = replace(found, at=known.at)

    def _proposal(
        self, entity: KeyValues, feature_id: str, features: Mapping[str, MapFeature], now: datetime,
        names: dict[str, str],
    ) -> Proposal | None:  # fmt: skip
        kind, ours = KIND_OF[entity["type"]], features.get(feature_id)
        name = ours.title if ours is not None else str(entity.get("name") or feature_id)[:80]
        what = "added" if ours is None else "changed"
        try:
            theirs = proposed(entity, ours, self._urns, names)
        except BadFeature as error:
            return Proposal(feature_id, entity["id"], kind, name, what, "", ours, None, now, problem=error.text)
        if theirs is None:
            return None
        found = compare([ours] if ours is not None else [], [theirs])
        text = "; ".join(one.text for one in found)[:300] or "Changed"
        return Proposal(feature_id, entity["id"], kind, name, what, text, ours, theirs, now)

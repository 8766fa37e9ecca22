"""Which notifications are news: delivery is unordered and repeated, so the time at the source decides."""

from __future__ import annotations

import hashlib
import json
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from enum import Enum

from backend_clients.ngsi.entity import BUILT_IN, Entity
from backend_clients.ngsi.errors import Unreadable
from backend_clients.ngsi.identifier import EntityRef

MOST = 20_000  # entities remembered; the one not heard of for longest is forgotten first
SKEW = timedelta(seconds=5)  # a source may be ahead of us by so much


class Verdict(Enum):
    """What an entity in a notification is."""

    NEW = "new"
    REPEAT = "repeat"  # known already
    OLD = "old"  # overtaken by what is known
    UNCLEAR = "unclear"  # no order can be told: read the entity from the broker
    GONE = "gone"  # the entity was deleted


@dataclass(slots=True)
class Counts:
    """How many entities of each verdict came; what a screen shows of losses and doubles."""

    by_verdict: dict[Verdict, int] = field(default_factory=lambda: dict.fromkeys(Verdict, 0))


@dataclass(frozen=True, slots=True)
class _Known:
    at: datetime
    digest: bytes
    is_gone: bool = False


class Intake:
    """Judges entities as they come; calls in any order end with the newest known.

    Args:
        source_times: attributes that say when the source spoke, the first one found counts.
        most: entities remembered.
        skew: how far in the future a source time may lie; beyond it is unclear and never blocks what follows.
    """

    def __init__(
        self, source_times: Sequence[str] = ("dateModified",), *, most: int = MOST, skew: timedelta = SKEW
    ) -> None:
        self._source_times, self._most, self._skew = tuple(source_times), most, skew
        self._known: OrderedDict[EntityRef, _Known] = OrderedDict()
        self.counts = Counts()

    def judge(self, entity: Entity, now: datetime) -> Verdict:
        """Say what an entity is, and remember it if it is news. ``now`` is our wall clock, aware."""
        verdict = self._judged(entity, now)
        self.counts.by_verdict[verdict] += 1
        return verdict

    def source_time(self, entity: Entity) -> datetime | None:
        """Return when the source spoke, ``None`` if the entity does not say."""
        for name in self._source_times:
            attribute = entity.attributes.get(name)
            if attribute is not None:
                try:
                    return attribute.moment()
                except Unreadable:
                    return None
        return None

    def _judged(self, entity: Entity, now: datetime) -> Verdict:
        at = self.source_time(entity)
        if at is None or at > now + self._skew:
            return Verdict.UNCLEAR
        is_gone = entity.value("alterationType") == "entityDelete"
        news, known = _Known(at, _digest(entity), is_gone), self._known.get(entity.ref)
        if known is not None and at < known.at:
            return Verdict.OLD
        if known is not None and at == known.at and not (is_gone and not known.is_gone):
            return Verdict.REPEAT if news == known else Verdict.OLD if known.is_gone else Verdict.UNCLEAR
        self._remember(entity.ref, news)
        return Verdict.GONE if is_gone else Verdict.NEW

    def _remember(self, ref: EntityRef, news: _Known) -> None:
        self._known[ref] = news
        self._known.move_to_end(ref)
        while len(self._known) > self._most:
            self._known.popitem(last=False)


def _digest(entity: Entity) -> bytes:
    content = {name: item.model_dump() for name, item in entity.attributes.items() if name not in BUILT_IN}
    text = json.dumps(content, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=16).digest()

"""Looking before and after: what an operation would do, what was walked, what changed about a feature."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hmi.commands.map_book import MapParts, parsed
from hmi.domain.role import Permission
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import as_geojson
from hmi.mapping.history import Entry, Published, attribute_history
from hmi.mapping.jobs import Position, apply, effect_of, outline
from hmi.security.session_info import SessionInfo
from hmi.store.errors import NotFound

if TYPE_CHECKING:
    from hmi.mapping.effect import Effect
    from hmi.mapping.operations import Outcome
    from hmi.mapping.walk import Walked


@dataclass(frozen=True, slots=True)
class Trial:
    """An operation that was not done; ``refused`` says why it could not be, and has no outcome then."""

    outcome: Outcome | None
    effect: Effect | None
    refused: OperationRefused | None = None

    def as_json(self) -> dict[str, Any]:
        """Return it with each feature as it would become."""
        if self.outcome is None or self.effect is None:
            said = self.refused and {"code": self.refused.code, "text": self.refused.text}
            return {"label": "", "changes": [], "effect": None, "refused": said}
        after = [
            {"id": one.id, "after": None if one.after is None else as_geojson(one.after)}
            for one in self.outcome.changes
        ]
        return {"label": self.outcome.label, "changes": after, "effect": self.effect.as_json(), "refused": None}


class MapReview:
    """Answers that change nothing.

    Raises (every method): ``NotSignedIn``, ``NotAllowed``, ``StoreError`` and what it names itself.
    """

    def __init__(self, parts: MapParts) -> None:
        self._parts = parts

    async def trial(self, session: SessionInfo, op: str, ids: Sequence[str], args: Mapping[str, Any]) -> Trial:
        """Return what an operation would do to the draft, or why it does not fit; raises ``NotFound``."""
        self._parts.authorize(session, Permission.EDIT_MAP)
        draft = await self._parts.database.run(self._parts.maps.draft, session.farm_id)
        if draft is None:
            raise NotFound("there is no draft of this map")
        try:
            outcome = await asyncio.to_thread(lambda: apply(op, parsed(draft.features), ids, args))
        except OperationRefused as error:
            return Trial(None, None, error)
        return Trial(outcome, await asyncio.to_thread(effect_of, outcome))

    async def outline(
        self, session: SessionInfo, points: Sequence[Position], *, is_closed: bool, tolerance_m: float
    ) -> Walked:
        """Return the outline or line of positions; raises ``BadWalk``."""
        self._parts.authorize(session, Permission.EDIT_MAP)
        return await asyncio.to_thread(lambda: outline(points, is_closed, tolerance_m))

    async def history(self, session: SessionInfo, feature_id: str) -> list[Entry]:
        """Return what changed about a feature, newest first; raises ``NotFound`` where no version has it."""
        self._parts.authorize(session, Permission.WATCH)
        found = await self._parts.database.run(self._parts.maps.versions_of, session.farm_id, feature_id)
        versions = [
            Published(one.number, one.by, one.published_at, one.note, raw and raw["properties"]) for one, raw in found
        ]
        if not any(one.properties for one in versions):
            raise NotFound("no published map has this feature")
        return attribute_history(versions)

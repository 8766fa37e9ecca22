"""Changes of the map that the cloud asks for: a person takes them into a draft, or refuses them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from hmi.commands.audit_line import audit_line
from hmi.commands.map_book import MapBook
from hmi.commands.ports import AuditSink
from hmi.domain.map_log import FeatureChange
from hmi.domain.role import Permission
from hmi.mapping.errors import BadFeature
from hmi.mapping.feature import MapFeature, as_geojson, parse_feature
from hmi.mapping.merging import is_within, merged
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.errors import NotFound
from hmi.store.maps import MapDraft


class Proposed(Protocol):
    """What the service needs of a proposal."""

    @property
    def id(self) -> str:
        """Of the feature."""
        ...

    @property
    def name(self) -> str:
        """Name of the feature."""
        ...

    @property
    def before(self) -> MapFeature | None:
        """The feature as it was on our map when that was asked for, ``None`` if there was none."""
        ...

    @property
    def after(self) -> MapFeature | None:
        """The feature as the cloud wants it, ``None`` to remove it."""
        ...

    @property
    def problem(self) -> str:
        """Why it cannot be taken, empty if it can."""
        ...


class ProposalSource(Protocol):
    """Where proposals come from."""

    def get(self, proposal_id: str) -> Proposed | None:
        """Return one, ``None`` if there is none any more."""
        ...

    def all(self) -> Sequence[Proposed]:
        """Return those that are open."""
        ...

    def drop(self, proposal_id: str) -> None:
        """Forget one."""
        ...


class MapProposals:
    """Takes and refuses. Nothing of the cloud is in the map, or in a draft, before a person took it.

    Args:
        on_refused: called after one was refused, so that the cloud is told what we have.
    """

    def __init__(
        self,
        source: ProposalSource,
        book: MapBook,
        authorize: Authorize,
        audit: AuditSink,
        on_refused: Callable[[], None],
    ) -> None:
        self._source, self._book, self._authorize = source, book, authorize
        self._audit, self._on_refused = audit, on_refused

    async def in_draft(self, session: SessionInfo) -> dict[str, str]:
        """Return who has which proposals in the draft now, by proposal: taken, and not taken back since."""
        opened = [one for one in self._source.all() if not one.problem]
        draft = await self._book.draft(session) if opened else None
        if draft is None:
            return {}
        found = await asyncio.to_thread(_fulfilled, opened, draft.features)
        return dict.fromkeys(found, draft.editor_name)

    async def take(
        self, session: SessionInfo, proposal_id: str, ref: str
    ) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        """Put one into the draft as one step that can be undone; what else the draft changed of the feature stays.

        The same ``ref`` again changes nothing.

        Raises:
            NotFound: there is no such proposal any more, or no draft.
            BadFeature: it cannot be on a map, or the draft changed the same of the feature.
            MapLocked, ChangedMeanwhile: see ``MapBook.change``.
        """
        self._authorize(session, Permission.EDIT_MAP)
        if (made := await self._book.made(session, ref)) is not None:
            return made
        one = self._needed(proposal_id)
        if one.problem:
            raise BadFeature("not_takeable", one.problem, proposal_id)
        draft = await self._book.draft(session)
        before = draft.features.get(proposal_id) if draft is not None else None
        after = one.after if draft is None else merged(_parsed(before), one.before, one.after)
        change = FeatureChange(proposal_id, before, None if after is None else as_geojson(after))
        done = await self._book.change(session, ref, f"From the cloud: {one.name}"[:200], [change])
        self._note(session, "taken", proposal_id, one.name)
        return done

    async def refuse(self, session: SessionInfo, proposal_id: str) -> None:
        """Refuse one; the cloud gets what we have. Raises ``NotFound``."""
        self._authorize(session, Permission.EDIT_MAP)
        one = self._needed(proposal_id)
        self._source.drop(proposal_id)
        self._note(session, "refused", proposal_id, one.name)
        self._on_refused()

    def _needed(self, proposal_id: str) -> Proposed:
        one = self._source.get(proposal_id)
        if one is None:
            raise NotFound("this proposal is not there any more")
        return one

    def _note(self, session: SessionInfo, outcome: str, proposal_id: str, name: str) -> None:
        text = f"{name}: change from the cloud {outcome}."
        self._audit.append(audit_line(session, "map", outcome, text, ref=proposal_id))


def _fulfilled(opened: Sequence[Proposed], features: Mapping[str, dict[str, Any]]) -> list[str]:
    return [one.id for one in opened if is_within(_parsed(features.get(one.id)), one.before, one.after)]


def _parsed(raw: Mapping[str, Any] | None) -> MapFeature | None:
    return None if raw is None else parse_feature(raw)

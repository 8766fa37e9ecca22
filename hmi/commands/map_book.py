"""The farm's map for screens and programs: read it, edit its draft, check, publish, go back.

Rights are asked at each step; what geometry needs runs in a thread, off the event loop.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.ports import AuditSink, LaneEvent
from hmi.domain.ids import new_id
from hmi.domain.map_log import FeatureChange, MapFeatures, Transaction
from hmi.domain.role import Permission
from hmi.mapping.attributes import HEIGHT
from hmi.mapping.errors import BadFeature
from hmi.mapping.feature import MapFeature, as_geojson, check_given, parse_feature
from hmi.mapping.jobs import apply, check, compare, shrinking
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.maps import MapDraft, Maps, MapVersion

if TYPE_CHECKING:
    from hmi.mapping.checks import Finding
    from hmi.mapping.diff import Difference

BLOCKS = 2  # findings of this level keep a map from being published
NO_RIGHT_TO_TAKE = "Taking the draft from somebody needs the supervisor role."


@dataclass(frozen=True, slots=True)
class MapParts:
    """What the book is wired to; ``width_of`` tells the width of a robot's machine in metres, as far as it is known."""

    maps: Maps
    database: Database
    authorize: Authorize
    audit: AuditSink
    clock: Clock
    on_event: LaneEvent
    width_of: Callable[[str], float | None] = lambda _robot_id: None


@dataclass(frozen=True, slots=True)
class Compared:
    """What a draft changes of the version it began with, and what others published since, if anything."""

    base_version: int
    newest_version: int
    differences: Sequence[Difference]
    meanwhile: Sequence[Difference]


class MapBlocked(Exception):
    """The draft has findings that keep it from being published."""

    def __init__(self, findings: Sequence[Finding]) -> None:
        super().__init__(f"{len(findings)} findings")
        self.findings = tuple(findings)


class MapShrinks(Exception):
    """The draft would leave much less than is published; ``text`` has the numbers."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.text = text


class MapBook:
    """Answers everything about the map.

    Raises (every method): ``NotSignedIn``, ``NotAllowed``, ``StoreError`` and what it names itself.
    """

    def __init__(self, parts: MapParts) -> None:
        self._parts = parts
        self._maps, self._run = parts.maps, parts.database.run

    async def published(self, session: SessionInfo) -> tuple[MapVersion, MapFeatures]:
        """Return the newest version with its features."""
        self._parts.authorize(session, Permission.WATCH)
        version = await self._run(self._maps.published, session.farm_id)
        return version, await self._run(self._maps.features_of, session.farm_id, version.number)

    async def versions(self, session: SessionInfo) -> list[MapVersion]:
        """Return all versions, newest first."""
        self._parts.authorize(session, Permission.WATCH)
        return await self._run(self._maps.versions, session.farm_id)

    async def draft(self, session: SessionInfo) -> MapDraft | None:
        """Return the draft, if there is one."""
        self._parts.authorize(session, Permission.WATCH)
        return await self._run(self._maps.draft, session.farm_id)

    async def open(self, session: SessionInfo, *, is_taking: bool) -> MapDraft:
        """Begin or go on with the draft; taking it from somebody is for supervisors. Raises ``MapLocked``."""
        self._parts.authorize(session, Permission.EDIT_MAP)
        if is_taking:
            self._parts.authorize(session, Permission.TAKE_LEASE)
        draft = await self._run(
            self._maps.open, session.farm_id, session.user_id, session.user_name, is_taking=is_taking
        )
        self._told("draft")
        return draft

    async def change(
        self, session: SessionInfo, ref: str, label: str, changes: Sequence[FeatureChange]
    ) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        """Make a transaction of the editor's; return it as it was stored.

        Raises:
            BadFeature: a feature is not one; nothing is changed.
            NotFound, MapLocked, ChangedMeanwhile: see ``Maps.append``.
        """
        self._parts.authorize(session, Permission.EDIT_MAP)
        draft = await self._needed(session)
        clean = await asyncio.to_thread(_clean, changes, draft.features)
        return await self._append(session, ref, label, clean)

    async def made(self, session: SessionInfo, ref: str) -> tuple[MapDraft, tuple[FeatureChange, ...]] | None:
        """Return the draft and what a transaction changed that it has already: asked again, nothing is done twice."""
        draft = await self.draft(session)
        known = await self._run(self._maps.changes_of, session.farm_id, ref)
        return None if draft is None or known is None else (draft, known)

    async def operate(
        self, session: SessionInfo, ref: str, op: str, ids: Sequence[str], args: Mapping[str, Any]
    ) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        """Let an operation of ``hmi.mapping`` change the draft; raises ``OperationRefused`` and as ``change``."""
        self._parts.authorize(session, Permission.EDIT_MAP)
        if (made := await self.made(session, ref)) is not None:
            return made
        draft = await self._needed(session)
        outcome = await asyncio.to_thread(lambda: apply(op, parsed(draft.features), ids, args))
        changes = [FeatureChange(one.id, draft.features.get(one.id), _json(one.after)) for one in outcome.changes]
        return await self._append(session, ref, outcome.label, changes)

    async def undo(self, session: SessionInfo, ref: str | None = None) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        """Take the newest transaction back, which is ``ref`` if one is named; raises as ``change``."""
        self._parts.authorize(session, Permission.EDIT_MAP)
        return await self._run(self._maps.undo, session.farm_id, session.user_id, ref)

    async def redo(self, session: SessionInfo, ref: str | None = None) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        """Make again what was taken back, which is ``ref`` if one is named; raises as ``change``."""
        self._parts.authorize(session, Permission.EDIT_MAP)
        return await self._run(self._maps.redo, session.farm_id, session.user_id, ref)

    async def findings(self, session: SessionInfo, robot_id: str | None = None) -> list[Finding]:
        """Check the draft, or what is published when there is none.

        Args:
            robot_id: whose width parcels are checked for; without one, no parcel is too narrow.
        """
        self._parts.authorize(session, Permission.WATCH, robot_id)
        width_m = None if robot_id is None else self._parts.width_of(robot_id)
        draft = await self.draft(session)
        features = draft.features if draft is not None else (await self.published(session))[1]
        return await asyncio.to_thread(lambda: check(parsed(features).values(), width_m))

    async def differences(self, session: SessionInfo) -> Compared:
        """Return what the draft changes, and against which version; raises ``NotFound``."""
        self._parts.authorize(session, Permission.WATCH)
        draft = await self._needed(session)
        newest = (await self._run(self._maps.published, session.farm_id)).number
        base = await self._run(self._maps.features_of, session.farm_id, draft.base_version)
        found = await asyncio.to_thread(lambda: compare(parsed(base).values(), parsed(draft.features).values()))
        if newest == draft.base_version:
            return Compared(newest, newest, found, ())
        now = await self._run(self._maps.features_of, session.farm_id, newest)
        meanwhile = await asyncio.to_thread(lambda: compare(parsed(base).values(), parsed(now).values()))
        return Compared(draft.base_version, newest, found, meanwhile)

    async def publish(
        self, session: SessionInfo, note: str, *, is_shrinking_ok: bool, ref: str | None = None
    ) -> MapVersion:
        """Make the draft what everybody sees. Missions that run keep the map they were planned on.

        Args:
            ref: the newest transaction that the editor saw: nothing goes out that was not on the screen.

        Raises:
            MapBlocked: findings of level 2 are open.
            MapShrinks: it would be empty or much smaller, and ``is_shrinking_ok`` is not said.
            NotFound, MapLocked, MapOutdated, ChangedMeanwhile: see ``Maps.publish``.
        """
        self._parts.authorize(session, Permission.EDIT_MAP)
        draft = await self._needed(session)
        blocking = [one for one in await self.findings(session) if one.level == BLOCKS]
        if blocking:
            raise MapBlocked(blocking)
        base = await self._run(self._maps.features_of, session.farm_id, draft.base_version)
        if not is_shrinking_ok:
            lost = await asyncio.to_thread(lambda: shrinking(parsed(base).values(), parsed(draft.features).values()))
            if lost:
                raise MapShrinks(lost)
        version = await self._run(self._maps.publish, session.farm_id, session.user_id, session.user_name, note, ref)
        self._audit(session, "published", f"Map version {version.number} published.", {"note": note})
        self._told("published", version=version.number)
        return version

    async def discard(self, session: SessionInfo) -> None:
        """Throw the draft away; raises as ``Maps.discard``."""
        self._parts.authorize(session, Permission.EDIT_MAP)
        await self._run(self._maps.discard, session.farm_id, session.user_id)
        self._audit(session, "discarded", "Map draft discarded.", {})
        self._told("draft")

    async def restore(self, session: SessionInfo, number: int) -> MapDraft:
        """Make the draft equal to version ``number``, as one transaction; raises as ``open`` and ``NotFound``."""
        draft = await self.open(session, is_taking=False)
        wanted = await self._run(self._maps.features_of, session.farm_id, number)
        ids = [*dict.fromkeys([*draft.features, *wanted])]
        changes = [FeatureChange(i, draft.features.get(i), wanted.get(i)) for i in ids]
        changed = [one for one in changes if one.before != one.after]
        if not changed:
            return draft
        stored, _ = await self._append(session, new_id(), f"Back to version {number}", changed)
        return stored

    async def _append(
        self, session: SessionInfo, ref: str, label: str, changes: Sequence[FeatureChange]
    ) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        one = Transaction(ref, label, session.user_name, self._parts.clock.utc(), tuple(changes))
        return await self._run(self._maps.append, session.farm_id, session.user_id, one)

    async def _needed(self, session: SessionInfo) -> MapDraft:
        draft = await self._run(self._maps.draft, session.farm_id)
        if draft is None:
            raise NotFound("there is no draft of this map")
        return draft

    def _told(self, what: str, **more: Any) -> None:
        self._parts.on_event({"kind": "map", "what": what, **more})

    def _audit(self, session: SessionInfo, outcome: str, text: str, data: dict[str, Any]) -> None:
        self._parts.audit.append(audit_line(session, "map", outcome, text, data=data))


def _clean(changes: Iterable[FeatureChange], there: MapFeatures) -> list[FeatureChange]:
    """Return the changes with every new feature checked and in the one form in which maps are kept."""
    return [FeatureChange(one.id, _seen(one.before, there.get(one.id)), _checked(one)) for one in changes]


def _seen(before: dict[str, Any] | None, there: dict[str, Any] | None) -> dict[str, Any] | None:
    """Return what is there if that is what the editor saw, though perhaps written differently."""
    return there if _as_kept(before) == _as_kept(there) else before


def _as_kept(before: dict[str, Any] | None) -> dict[str, Any] | None:
    """Return a feature in the one form, so that two can be compared."""
    try:
        return None if before is None else as_geojson(parse_feature(before))
    except BadFeature:
        return before


def _checked(change: FeatureChange) -> dict[str, Any] | None:
    if change.after is None:
        return None
    feature = parse_feature(change.after)
    if feature.id != change.id:
        raise BadFeature("wrong_id", f"The feature is called {feature.id}, the change {change.id}.", change.id)
    properties = (change.before or {}).get("properties")
    had = properties if isinstance(properties, dict) else {}
    check_given(feature, had.get("name"), had.get(HEIGHT))
    return as_geojson(feature)


def parsed(features: Mapping[str, dict[str, Any]]) -> dict[str, MapFeature]:
    """Return features as the map's operations take them, by id."""
    return {key: parse_feature(raw) for key, raw in features.items()}


def _json(feature: MapFeature | None) -> dict[str, Any] | None:
    return None if feature is None else as_geojson(feature)

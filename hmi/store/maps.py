"""The farm's map over time: what is published, one draft beside it, and every version before.

Features are GeoJSON objects by id. Blocking; call through ``Database.run``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from hmi.clock import Clock
from hmi.domain.map_log import (
    ChangedMeanwhile,
    FeatureChange,
    MapFeatures,
    Transaction,
    applied,
    next_redo,
    next_undo,
    taken_back,
)
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.features import Feature, feature_collection
from hmi.store.map_tables import MapChangeRow, MapDraftRow, MapVersionRow
from hmi.store.tables import FeatureRow

LOCK = timedelta(minutes=30)  # a tablet that was left behind must not keep a season's map closed
FIRST_NOTE = "First map."
SYSTEM = "Headland"
TOLD = 50  # newest steps of which the log says what they changed
TITLES = 4_096  # steps of which that is remembered: shapes of thousands of corners are read once, not at each step


@dataclass(frozen=True, slots=True)
class MapVersion:
    """One published map without its features; number 0 is a farm that has none yet."""

    number: int
    by: str
    note: str
    published_at: datetime | None
    size: int


@dataclass(frozen=True, slots=True)
class MapDraft:
    """A draft as it is now.

    Args:
        left_s: how much longer the lock holds, seconds; 0 once it ran out.
        log: oldest first; its changes tell what was changed, not how: without shapes, and the newest alone have any.
    """

    farm_id: str
    base_version: int
    features: MapFeatures
    editor_id: str
    editor_name: str
    locked_until: datetime
    left_s: float
    saved_at: datetime
    log: tuple[Transaction, ...]


class MapLocked(Exception):
    """Somebody else edits the draft."""

    def __init__(self, by: str, until: datetime) -> None:
        super().__init__(f"locked by {by} until {until.isoformat()}")
        self.by, self.until = by, until


class MapOutdated(Exception):
    """Somebody published since the draft was begun; ``number`` is the version now."""

    def __init__(self, number: int) -> None:
        super().__init__(f"version {number} was published meanwhile")
        self.number = number


class Maps:
    """Published maps and drafts of every farm."""

    def __init__(self, database: Database, clock: Clock) -> None:
        self._database = database
        self._clock = clock
        self._titles: dict[str, tuple[FeatureChange, ...]] = {}  # by farm and ref; a step never changes

    def published(self, farm_id: str) -> MapVersion:
        """Return the newest version; a map that came without versions becomes the first."""
        self._begin(farm_id)
        with self._database.read() as session:
            return _version(_latest(session, farm_id))

    def versions(self, farm_id: str) -> list[MapVersion]:
        """Return all versions, newest first."""
        self._begin(farm_id)
        with self._database.read() as session:
            query = select(MapVersionRow).filter_by(farm_id=farm_id).order_by(MapVersionRow.number.desc())
            return [_version(row) for row in session.scalars(query)]

    def features_of(self, farm_id: str, number: int) -> MapFeatures:
        """Return the features of one version; raises ``NotFound``."""
        self._begin(farm_id)
        with self._database.read() as session:
            if number == 0 and _latest(session, farm_id) is None:
                return {}
            row = session.get(MapVersionRow, (farm_id, number))
            if row is None:
                raise NotFound(f"there is no map version {number}")
            return dict(row.features)

    def versions_of(self, farm_id: str, feature_id: str) -> list[tuple[MapVersion, dict[str, Any] | None]]:
        """Return one feature in every version, oldest first, ``None`` where it is not; sizes are not counted."""
        self._begin(farm_id)
        row = MapVersionRow
        query = select(row.number, row.by, row.note, row.published_at, row.features[feature_id])
        with self._database.read() as session:
            found = session.execute(query.where(row.farm_id == farm_id).order_by(row.number)).all()
        return [(MapVersion(number, by, note, at, 0), raw) for number, by, note, at, raw in found]

    def draft(self, farm_id: str) -> MapDraft | None:
        """Return the farm's draft, if there is one."""
        with self._database.read() as session:
            row = session.get(MapDraftRow, farm_id)
            return None if row is None else self._draft(session, row)

    def changes_of(self, farm_id: str, ref: str) -> tuple[FeatureChange, ...] | None:
        """Return what a transaction on the draft changed, whole; ``None`` where there is no such."""
        with self._database.read() as session:
            return _changes(session, farm_id, ref)

    def open(self, farm_id: str, editor_id: str, editor_name: str, *, is_taking: bool = False) -> MapDraft:
        """Begin a draft or go on with the one there is, and hold its lock.

        Raises:
            MapLocked: somebody else holds it and ``is_taking`` is not said.
        """
        now = self._clock.utc()
        with self._database.write() as session:
            row = session.get(MapDraftRow, farm_id)
            if row is None:
                newest = self._newest(session, farm_id)
                row = MapDraftRow(farm_id=farm_id, base_version=newest.number if newest else 0, saved_at=now)
                row.features = dict(newest.features) if newest else {}
                session.add(row)
            elif not is_taking:
                _check_lock(row, editor_id, now)
            row.editor_id, row.editor_name, row.locked_until = editor_id, editor_name, now + LOCK
            session.flush()
            return self._draft(session, row)

    def append(
        self, farm_id: str, editor_id: str, transaction: Transaction
    ) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        """Make one transaction; return the draft and what is stored under its ``ref``, which changes nothing again.

        Raises:
            NotFound: there is no draft.
            MapLocked: somebody else edits it.
            ChangedMeanwhile: the draft does not hold what the editor saw.
        """
        with self._database.write() as session:
            row = self._held(session, farm_id, editor_id)
            known = _changes(session, farm_id, transaction.ref)
            if known is None:
                row.features = applied(row.features, transaction.changes)
                session.execute(delete(MapChangeRow).filter_by(farm_id=farm_id, is_undone=True))
                session.add(_change_row(farm_id, transaction))
                self._saved(row)
            session.flush()
            return self._draft(session, row), transaction.changes if known is None else known

    def undo(self, farm_id: str, editor_id: str, ref: str | None = None) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        """Take the newest transaction back; nothing changes when there is none.

        Args:
            ref: the transaction that is meant; once it is taken back, the same again changes nothing.

        Raises:
            NotFound, MapLocked: as ``append``.
            ChangedMeanwhile: ``ref`` is not the newest.
        """
        return self._walk(farm_id, editor_id, ref, is_back=True)

    def redo(self, farm_id: str, editor_id: str, ref: str | None = None) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        """Make the transaction again that was taken back last; ``ref`` and errors as in ``undo``."""
        return self._walk(farm_id, editor_id, ref, is_back=False)

    def discard(self, farm_id: str, editor_id: str) -> None:
        """Throw the draft away; raises as ``append``."""
        with self._database.write() as session:
            self._held(session, farm_id, editor_id)
            self._end(session, farm_id)

    def publish(self, farm_id: str, editor_id: str, by: str, note: str, ref: str | None = None) -> MapVersion:
        """Make the draft the newest version and what every screen shows, and end it.

        Args:
            ref: the newest transaction that the editor saw.

        Raises:
            NotFound, MapLocked: as ``append``.
            ChangedMeanwhile: ``ref`` is not the newest.
            MapOutdated: somebody published since the draft was begun.
        """
        now = self._clock.utc()
        with self._database.write() as session:
            row = self._held(session, farm_id, editor_id)
            newest = self._newest(session, farm_id)
            number = newest.number if newest else 0
            if number != row.base_version:
                raise MapOutdated(number)
            if ref is not None:
                _check_newest(self._log(session, farm_id), ref)
            features = dict(row.features)
            version = MapVersionRow(
                farm_id=farm_id, number=number + 1, by=by, note=note, published_at=now, features=features
            )
            session.add(version)
            session.execute(delete(FeatureRow).filter_by(farm_id=farm_id))
            session.add_all(_feature_row(farm_id, number + 1, one, now) for one in features.values())
            self._end(session, farm_id)
            session.flush()
            return _version(version)

    def _walk(
        self, farm_id: str, editor_id: str, ref: str | None, *, is_back: bool
    ) -> tuple[MapDraft, tuple[FeatureChange, ...]]:
        with self._database.write() as session:
            row = self._held(session, farm_id, editor_id)
            step = _meant(self._log(session, farm_id), ref, is_back=is_back)
            changes: tuple[FeatureChange, ...] = ()
            if step is not None:
                made = _changes(session, farm_id, step.ref) or ()
                changes = taken_back(made) if is_back else made
            if step is not None and step.is_undone is not is_back:
                row.features = applied(row.features, changes)
                change = session.scalars(select(MapChangeRow).filter_by(farm_id=farm_id, ref=step.ref)).one()
                change.is_undone = is_back
                self._saved(row)
            session.flush()
            return self._draft(session, row), changes

    def _draft(self, session: Session, row: MapDraftRow) -> MapDraft:
        return MapDraft(
            row.farm_id,
            row.base_version,
            dict(row.features),
            row.editor_id,
            row.editor_name,
            row.locked_until,
            max((row.locked_until - self._clock.utc()).total_seconds(), 0.0),
            row.saved_at,
            self._log(session, row.farm_id),
        )

    def _log(self, session: Session, farm_id: str) -> tuple[Transaction, ...]:
        row = MapChangeRow
        query = select(row.ref, row.label, row.by, row.at, row.is_undone).filter_by(farm_id=farm_id).order_by(row.id)
        rows = session.execute(query).all()
        told = {one.ref: self._titles_of(session, farm_id, one.ref) for one in rows[-TOLD:]}
        return tuple(Transaction(r.ref, r.label, r.by, r.at, told.get(r.ref, ()), r.is_undone) for r in rows)

    def _titles_of(self, session: Session, farm_id: str, ref: str) -> tuple[FeatureChange, ...]:
        key = f"{farm_id} {ref}"
        found = self._titles.get(key)
        if found is None:
            found = tuple(map(_titled, _changes(session, farm_id, ref) or ()))
            if len(self._titles) >= TITLES:
                self._titles.clear()
            self._titles[key] = found
        return found

    def _end(self, session: Session, farm_id: str) -> None:
        session.execute(delete(MapChangeRow).filter_by(farm_id=farm_id))
        session.execute(delete(MapDraftRow).filter_by(farm_id=farm_id))
        self._titles.clear()

    def _held(self, session: Session, farm_id: str, editor_id: str) -> MapDraftRow:
        row = session.get(MapDraftRow, farm_id)
        if row is None:
            raise NotFound("there is no draft of this map")
        _check_lock(row, editor_id, self._clock.utc())
        if row.editor_id != editor_id:  # its lock ran out, but nobody opened it: not taken by the way
            raise MapLocked(row.editor_name, row.locked_until)
        return row

    def _saved(self, row: MapDraftRow) -> None:
        now = self._clock.utc()
        row.saved_at, row.locked_until = now, now + LOCK

    def _begin(self, farm_id: str) -> None:
        """Make a map that came without versions the first one; looking comes first, for it takes no lock."""
        with self._database.read() as session:
            if _latest(session, farm_id) is not None:
                return
        with self._database.write() as session:
            self._newest(session, farm_id)

    def _newest(self, session: Session, farm_id: str) -> MapVersionRow | None:
        newest = _latest(session, farm_id)
        if newest is not None:
            return newest
        rows = list(session.scalars(select(FeatureRow).filter_by(farm_id=farm_id).order_by(FeatureRow.id)))
        if not rows:
            return None
        parts = [Feature(r.id, farm_id, r.kind, r.name, dict(r.geometry), dict(r.properties or {})) for r in rows]
        features = {one["id"]: one for one in feature_collection(parts)["features"]}
        first = MapVersionRow(
            farm_id=farm_id, number=1, by=SYSTEM, note=FIRST_NOTE, published_at=self._clock.utc(), features=features
        )
        session.add(first)
        session.flush()
        return first


def _latest(session: Session, farm_id: str) -> MapVersionRow | None:
    query = select(MapVersionRow).filter_by(farm_id=farm_id).order_by(MapVersionRow.number.desc()).limit(1)
    return session.scalar(query)


def _check_lock(row: MapDraftRow, editor_id: str, now: datetime) -> None:
    if row.editor_id != editor_id and row.locked_until > now:
        raise MapLocked(row.editor_name, row.locked_until)


def _check_newest(log: Sequence[Transaction], ref: str) -> None:
    newest = next_undo(log)
    if newest is None or newest.ref != ref:
        raise ChangedMeanwhile(())


def _meant(log: Sequence[Transaction], ref: str | None, *, is_back: bool) -> Transaction | None:
    """Return what a walk along the log is about: what is next, or what was walked over when that was asked before."""
    following = next_undo(log) if is_back else next_redo(log)
    if ref is None or (following is not None and following.ref == ref):
        return following
    before = next((one for one in log if one.ref == ref), None)
    if before is None or before.is_undone is not is_back:
        raise ChangedMeanwhile(())
    return before


def _version(row: MapVersionRow | None) -> MapVersion:
    if row is None:
        return MapVersion(0, "", "", None, 0)
    return MapVersion(row.number, row.by, row.note, row.published_at, len(row.features))


def _changes(session: Session, farm_id: str, ref: str) -> tuple[FeatureChange, ...] | None:
    raw = session.scalar(select(MapChangeRow.changes).filter_by(farm_id=farm_id, ref=ref))
    return None if raw is None else tuple(_change(one) for one in raw)


def _titled(change: FeatureChange) -> FeatureChange:
    """Return a change with the names of the feature alone."""
    return FeatureChange(change.id, _title(change.before), _title(change.after))


def _title(raw: dict[str, Any] | None) -> dict[str, Any] | None:
    return None if raw is None else {"properties": {"name": raw.get("properties", {}).get("name", "")}}


def _change(raw: dict[str, Any]) -> FeatureChange:
    return FeatureChange(raw["id"], raw["before"], raw["after"])


def _change_row(farm_id: str, one: Transaction) -> MapChangeRow:
    changes = [{"id": c.id, "before": c.before, "after": c.after} for c in one.changes]
    return MapChangeRow(
        farm_id=farm_id, ref=one.ref, label=one.label, by=one.by, at=one.at, changes=changes, is_undone=False
    )


def _feature_row(farm_id: str, number: int, raw: dict[str, Any], now: datetime) -> FeatureRow:
    own = {key: value for key, value in raw["properties"].items() if key not in ("id", "kind", "name")}
    return FeatureRow(
        id=raw["id"],
        farm_id=farm_id,
        kind=raw["properties"]["kind"],
        name=(raw["properties"].get("name") or "")[:80],  # as wide as its column; the version has all of it
        properties=own,
        geometry=raw["geometry"],
        map_version=number,
        created_at=now,
    )

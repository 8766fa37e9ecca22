"""The queues of one farm's robots, in memory and on disk."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from datetime import date, datetime, time, timedelta
from typing import Any

from sqlalchemy import or_, select

from hmi.clock import Clock
from hmi.domain.queue.blackout import Blackout
from hmi.domain.queue.entry import Conditions, Entry, EntryState
from hmi.domain.queue.repeat import Repeat, RepeatKind
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.queue_tables import QueueBlackoutRow, QueueEntryRow, QueueFreezeRow, QueueRevisionRow

KEPT = timedelta(hours=36)  # what ended is shown for today and last night
MAX_STOP_IDS = 64


@dataclass(frozen=True, slots=True)
class Freeze:
    """Whether the whole queue stands still after STOP ALL, since when and by whom."""

    is_frozen: bool
    by: str
    at: datetime
    stop_ids: tuple[str, ...] = ()
    released_by: str = ""
    released_at: datetime | None = None
    reason: str = ""


class QueueStore:
    """Entries, revisions, blackout windows and the freeze.

    Reading answers from memory and may be done on the event loop; everything that writes blocks and goes through
    ``Database.run``.
    """

    def __init__(self, database: Database, farm_id: str, clock: Clock) -> None:
        self._database, self._farm_id, self._clock = database, farm_id, clock
        self._entries: dict[str, Entry] = {}
        self._revisions: dict[str, int] = {}
        self._blackouts: dict[str, Blackout] = {}
        self._freeze: Freeze | None = None
        self._changing = threading.Lock()

    def load(self) -> None:
        """Read everything that matters now into memory; at start."""
        since = self._clock.utc() - KEPT
        with self._changing, self._database.read() as session:
            rows = select(QueueEntryRow).filter_by(farm_id=self._farm_id)
            rows = rows.where(or_(QueueEntryRow.state == EntryState.OPEN.value, QueueEntryRow.ended_at >= since))
            self._entries = {row.id: _entry(row) for row in session.scalars(rows)}
            numbers = session.scalars(select(QueueRevisionRow).filter_by(farm_id=self._farm_id))
            self._revisions = {row.robot_id: row.number for row in numbers}
            windows = session.scalars(select(QueueBlackoutRow).filter_by(farm_id=self._farm_id))
            self._blackouts = {row.id: _blackout(row) for row in windows}
            freeze = session.get(QueueFreezeRow, self._farm_id)
            self._freeze = None if freeze is None else _freeze(freeze)

    def entries(self, robot_id: str | None = None) -> list[Entry]:
        """Return the open entries in order, of one robot or of all."""
        found = [one for one in self._entries.values() if one.is_open and robot_id in (None, one.robot_id)]
        return sorted(found, key=lambda one: (one.robot_id, one.position, one.added_at, one.id))

    def ended(self) -> list[Entry]:
        """Return what ended lately, oldest first."""
        since = self._clock.utc() - KEPT
        found = [one for one in self._entries.values() if one.ended_at is not None and one.ended_at >= since]
        return sorted(found, key=lambda one: (one.ended_at or since, one.id))

    def get(self, entry_id: str) -> Entry:
        """Return an open entry; raises ``NotFound``."""
        entry = self._entries.get(entry_id)
        if entry is None or not entry.is_open:
            raise NotFound(f"there is no entry {entry_id!r} in the queue")
        return entry

    def robot_of(self, mission_id: str) -> str | None:
        """Return the robot in whose queue a mission stands, ``None`` if it stands in none."""
        found = (one.robot_id for one in tuple(self._entries.values()) if one.mission_id == mission_id and one.is_open)
        return next(found, None)

    def revision(self, robot_id: str) -> int:
        """Return how often people changed a robot's queue."""
        return self._revisions.get(robot_id, 0)

    def blackouts(self) -> list[Blackout]:
        """Return the windows by name."""
        return sorted(self._blackouts.values(), key=lambda one: (one.name, one.id))

    def freeze(self) -> Freeze | None:
        """Return the last freeze, released or not."""
        return self._freeze

    def write(
        self,
        *,
        added: Iterable[Entry] = (),
        amended: Mapping[str, Mapping[str, Any]] | None = None,
        changed: Iterable[str] = (),
    ) -> list[Entry]:
        """Write in one transaction, and return the entries as they are now.

        Args:
            added: new entries.
            amended: fields of open entries to be replaced; other fields keep what somebody else wrote meanwhile.
            changed: robots whose queue a person changed, which gives it a new revision; what the queue does itself
                changes none.

        Raises:
            NotFound: an entry to be amended is not open any more; nothing is written.
        """
        with self._changing:
            kept = [*(replace(self.get(key), **fields) for key, fields in (amended or {}).items()), *added]
            numbers = {robot: self.revision(robot) + 1 for robot in changed}
            with self._database.write() as session:
                for entry in kept:
                    session.merge(_row(entry))
                for robot, number in numbers.items():
                    session.merge(QueueRevisionRow(farm_id=self._farm_id, robot_id=robot, number=number))
            self._entries = {**self._entries, **{one.id: one for one in kept}}
            self._revisions = {**self._revisions, **numbers}
        return kept

    def put_blackout(self, window: Blackout) -> None:
        """Write a window; every queue it is about changes."""
        with self._changing:
            with self._database.write() as session:
                session.merge(_window_row(window))
            self._blackouts = {**self._blackouts, window.id: window}

    def remove_blackout(self, window_id: str) -> Blackout:
        """Delete a window and return it; raises ``NotFound``."""
        with self._changing:
            window = self._blackouts.get(window_id)
            with self._database.write() as session:
                row = session.get(QueueBlackoutRow, window_id)
                if window is None or row is None or row.farm_id != self._farm_id:
                    raise NotFound(f"there is no window {window_id!r}")
                session.delete(row)
            self._blackouts = {key: one for key, one in self._blackouts.items() if key != window_id}
            return window

    def remember_freeze(self, freeze: Freeze) -> None:
        """Note the freeze in memory at once; ``write_freeze`` writes it."""
        self._freeze = replace(freeze, stop_ids=freeze.stop_ids[-MAX_STOP_IDS:])

    def write_freeze(self) -> None:
        """Write what memory says now, so that two writers cannot overtake each other."""
        with self._changing, self._database.write() as session:
            freeze = self._freeze
            if freeze is None:
                return
            session.merge(
                QueueFreezeRow(farm_id=self._farm_id, **{**asdict(freeze), "stop_ids": list(freeze.stop_ids)})
            )


def _row(entry: Entry) -> QueueEntryRow:
    same = {name: getattr(entry, name) for name in _SAME}
    return QueueEntryRow(
        state=entry.state.value,
        repeat=None if entry.repeat is None else repeat_fields(entry.repeat),
        conditions=asdict(entry.conditions),
        place=None if entry.place is None else list(entry.place),
        why=entry.why[:400],
        **same,
    )


def _entry(row: QueueEntryRow) -> Entry:
    return Entry(
        state=EntryState(row.state),
        repeat=None if row.repeat is None else repeat_of(row.repeat),
        conditions=Conditions(**row.conditions),
        place=None if row.place is None else (row.place[0], row.place[1]),
        why=row.why,
        **{name: getattr(row, name) for name in _SAME},
    )


_SAME = (
    "id", "farm_id", "robot_id", "mission_id", "position", "is_unattended", "earliest", "window_s", "added_by",
    "added_at", "started_at", "ended_at",
)  # fmt: skip


def repeat_fields(rule: Repeat) -> dict[str, Any]:
    """Return a rule as plain values."""
    until = None if rule.until is None else rule.until.isoformat()
    at = None if rule.at is None else rule.at.isoformat()
    return {"kind": rule.kind.value, "days": sorted(rule.days), "every_days": rule.every_days, "until": until, "at": at}


def repeat_of(fields: dict[str, Any]) -> Repeat:
    """Return the rule of plain values; raises ``ValueError`` for one that is none."""
    until, at = fields.get("until"), fields.get("at")
    last = None if until is None else date.fromisoformat(until)
    meant = None if at is None else time.fromisoformat(at)
    days = frozenset(fields.get("days", ()))
    return Repeat(RepeatKind(fields["kind"]), days, fields.get("every_days", 1), last, meant)


def _window_row(one: Blackout) -> QueueBlackoutRow:
    return QueueBlackoutRow(
        id=one.id,
        farm_id=one.farm_id,
        name=one.name,
        days=sorted(one.days),
        from_min=one.from_min,
        to_min=one.to_min,
        robots=list(one.robots),
    )


def _blackout(row: QueueBlackoutRow) -> Blackout:
    return Blackout(
        row.id, row.farm_id, row.name, frozenset(row.days), row.from_min, row.to_min, tuple(row.robots)
    )  # fmt: skip


def _freeze(row: QueueFreezeRow) -> Freeze:
    return Freeze(
        row.is_frozen, row.by, row.at, tuple(row.stop_ids), row.released_by, row.released_at, row.reason
    )  # fmt: skip

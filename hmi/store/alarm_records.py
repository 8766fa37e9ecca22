"""Keeps alarms over a restart, and the journal of every step in their lives.

``take`` costs microseconds and never waits; a thread writes in batches. What the database cannot take waits in a
bounded queue, then is dropped and counted; the state of every alarm is written again after such a loss.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import delete, insert, select

from hmi.domain.alarm.alarm import Alarm, AlarmKey, OutOfService, Phase, Shelf
from hmi.domain.alarm.live_alarm import LiveAlarm, Step, What
from hmi.domain.alarm.priority import Priority
from hmi.store.alarm_tables import AlarmJournalRow, AlarmRow
from hmi.store.batch_writer import BatchWriter, WriterHealth
from hmi.store.database import Database

CAPACITY = 20_000
LINGER_S = 0.2
MAX_TEXT = 400
NameOf = Callable[[LiveAlarm], tuple[str, str]]
"""A live alarm to the name of its source and its title."""


@dataclass(frozen=True, slots=True)
class _Item:
    alarm_id: str
    row: dict[str, Any] | None
    line: dict[str, Any] | None


class AlarmRecords:
    """Writes what happens to alarms of one farm; blocking parts are for ``Database.run`` or its own thread.

    Args:
        name_of: what people call source and alarm.
    """

    def __init__(self, database: Database, farm_id: str, name_of: NameOf, *, linger_s: float = LINGER_S) -> None:
        self._database, self._farm_id, self._name_of = database, farm_id, name_of
        self._writer: BatchWriter[_Item] = BatchWriter(
            "alarms", self._write, capacity=CAPACITY, batch_size=2000, linger_s=linger_s
        )
        self._dropped = 0

    def start(self) -> None:
        """Start writing."""
        self._writer.start()

    def close(self, timeout_s: float = 2.0) -> bool:
        """Write what waits and stop; blocks."""
        return self._writer.close(timeout_s)

    def flush(self, timeout_s: float = 5.0) -> bool:
        """Wait until what was taken so far is written; blocks."""
        return self._writer.flush(timeout_s)

    def health(self) -> WriterHealth:
        """Return queue, losses and the newest error."""
        return self._writer.health()

    def take(self, step: Step) -> None:
        """Note a step; on the event loop, does not wait."""
        live = step.live
        self._writer.put(_Item(live.id, self._row(live), self._line(step)))

    def mend(self, live: Sequence[LiveAlarm]) -> None:
        """Write the state of all alarms again if some of it was lost; call it once in a while."""
        dropped = self._writer.health().dropped
        if dropped > self._dropped:
            self._dropped = dropped
            for one in live:
                self._writer.put(_Item(one.id, self._row(one), None))

    def load(self) -> list[tuple[Alarm, datetime | None, datetime | None]]:
        """Return the alarms of before the restart, with since when each waits and when it escalated; blocks."""
        with self._database.read() as session:
            rows = session.scalars(select(AlarmRow).filter_by(farm_id=self._farm_id))
            return [(_alarm(row), row.unanswered_at, row.escalated_at) for row in rows]

    def _row(self, live: LiveAlarm) -> dict[str, Any] | None:
        alarm = live.alarm
        if alarm.phase is Phase.NORMAL and alarm.shelf is None and alarm.out_of_service is None:
            return None
        return {
            "farm_id": self._farm_id,
            "id": live.id,
            "code": alarm.key.code,
            "source": alarm.key.source,
            "detail": alarm.key.detail,
            "phase": alarm.phase.value,
            "text": alarm.text[:MAX_TEXT],
            "advice": alarm.advice[:MAX_TEXT],
            "priority": None if alarm.priority is None else int(alarm.priority),
            "raised_at": alarm.raised_at,
            "returned_at": alarm.returned_at,
            "seen_by": alarm.seen_by,
            "seen_at": alarm.seen_at,
            "shelf": _shelf(alarm.shelf),
            "out_of_service": _out(alarm.out_of_service),
            "occurrences": alarm.occurrences,
            "escalated_at": live.escalated_at,
            "unanswered_at": live.unanswered_at,
        }

    def _line(self, step: Step) -> dict[str, Any]:
        live, alarm = step.live, step.live.alarm
        name, title = self._name_of(live)
        is_begun = step.what is What.RAISED and step.rose_from is None and alarm.raised_at is not None
        waited = step.at - step.unanswered_at if step.unanswered_at is not None else None
        return {
            "farm_id": self._farm_id,
            "at": alarm.raised_at if is_begun else step.at,
            "alarm_id": live.id,
            "code": alarm.key.code,
            "source": alarm.key.source,
            "name": name[:80],
            "title": title[:80],
            "what": step.what.value,
            "priority": int(live.priority),
            "is_shown": alarm.is_annunciated or alarm.phase is Phase.NORMAL,
            "by": step.by[:80],
            "device": step.device[:80],
            "text": (step.text or alarm.text)[:MAX_TEXT],
            "waited_s": round(waited.total_seconds()) if waited and step.what is What.ACKNOWLEDGED else None,
        }

    def _write(self, items: Sequence[_Item]) -> None:
        newest = {item.alarm_id: item.row for item in items}
        rows = [row for row in newest.values() if row is not None]
        lines = [item.line for item in items if item.line is not None]
        with self._database.connect_writing() as connection:
            gone = delete(AlarmRow).where(AlarmRow.farm_id == self._farm_id, AlarmRow.id.in_(list(newest)))
            connection.execute(gone)
            if rows:
                connection.execute(insert(AlarmRow), rows)
            if lines:
                connection.execute(insert(AlarmJournalRow), lines)


def _alarm(row: AlarmRow) -> Alarm:
    return Alarm(
        key=AlarmKey(row.code, row.source, row.detail),
        phase=Phase(row.phase),
        text=row.text,
        raised_at=row.raised_at,
        returned_at=row.returned_at,
        seen_by=row.seen_by,
        seen_at=row.seen_at,
        shelf=None if row.shelf is None else _read_shelf(row.shelf),
        out_of_service=None if row.out_of_service is None else _read_out(row.out_of_service, row.priority),
        occurrences=row.occurrences,
        priority=None if row.priority is None else Priority(row.priority),
        advice=row.advice,
    )


def _shelf(shelf: Shelf | None) -> dict[str, str] | None:
    if shelf is None:
        return None
    return {"by": shelf.by, "reason": shelf.reason, "at": shelf.at.isoformat(), "until": shelf.until.isoformat()}


def _out(out: OutOfService | None) -> dict[str, Any] | None:
    if out is None:
        return None
    return {"by": out.by, "reason": out.reason, "at": out.at.isoformat(), "holds_critical": out.holds_critical}


def _read_shelf(value: dict[str, str]) -> Shelf:
    at, until = datetime.fromisoformat(value["at"]), datetime.fromisoformat(value["until"])
    return Shelf(value["by"], value["reason"], at, until)


def _read_out(value: dict[str, Any], priority: int | None) -> OutOfService:
    # older rows do not say it; of priority 1 only an admin could take one out
    holds_critical = value.get("holds_critical", priority == Priority.CRITICAL)
    return OutOfService(value["by"], value["reason"], datetime.fromisoformat(value["at"]), holds_critical)

"""What happened to alarms: searched, counted, exported. Blocking; call through ``Database.run``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta

from sqlalchemy import ColumnElement, Select, func, or_, select

from hmi.domain.alarm.flood import Flood
from hmi.domain.alarm.journal import Figures, Line
from hmi.domain.alarm.live_alarm import What
from hmi.store.alarm_tables import AlarmJournalRow
from hmi.store.database import Database

PAGE = 1000
TEN_MIN = timedelta(minutes=10)


@dataclass(frozen=True, slots=True)
class Search:
    """What to look for; what is not given does not matter. ``text`` is looked for in name, title, words, person."""

    start: datetime | None = None
    end: datetime | None = None
    text: str = ""
    priority: int | None = None
    source: str | None = None


class AlarmJournal:
    """The journal of one farm."""

    def __init__(self, database: Database, farm_id: str) -> None:
        self._database, self._farm_id = database, farm_id

    def page(self, search: Search, limit: int, before: int | None = None) -> list[Line]:
        """Return lines, newest first, written before one of a page before."""
        query = self._query(search).order_by(AlarmJournalRow.id.desc()).limit(limit)
        if before is not None:
            query = query.where(AlarmJournalRow.id < before)
        with self._database.read() as session:
            return [_line(row) for row in session.scalars(query)]

    def export(self, search: Search) -> Iterator[list[Line]]:
        """Return all lines in pages, newest first; no more than one page is held at a time."""
        before: int | None = None
        while page := self.page(search, PAGE, before):
            yield page
            if len(page) < PAGE:
                return
            before = page[-1].id

    def around(self, source: str, start: datetime, end: datetime) -> list[Line]:
        """Return what happened to the alarms of a source, oldest first."""
        query = self._query(Search(start, end, source=source)).order_by(AlarmJournalRow.at, AlarmJournalRow.id)
        with self._database.read() as session:
            return [_line(row) for row in session.scalars(query.limit(PAGE))]

    def raised_before(self, alarm_id: str, since: datetime, until: datetime) -> int:
        """Return how often an alarm was raised from ``since``, before ``until``."""
        row = AlarmJournalRow
        query = select(func.count()).where(
            row.farm_id == self._farm_id,
            row.alarm_id == alarm_id,
            row.what == What.RAISED.value,
            row.at >= since,
            row.at < until,
        )
        with self._database.read() as session:
            return int(session.execute(query).scalar_one())

    def last_raised(self) -> datetime | None:
        """Return when an alarm was raised last."""
        query = self._raised(None).order_by(AlarmJournalRow.at.desc()).limit(1)
        with self._database.read() as session:
            return session.execute(query.with_only_columns(AlarmJournalRow.at)).scalar()

    def figures(self, now: datetime, *, bins: int = 48, span: timedelta = timedelta(days=7)) -> Figures:
        """Return the figures of the last bins of ten minutes, and of a span no longer than the journal is old."""
        since, first = now - span, now - bins * TEN_MIN
        row = AlarmJournalRow
        with self._database.read() as session:
            began = session.execute(select(func.min(row.at)).where(row.farm_id == self._farm_id)).scalar()
            times = list(session.scalars(self._raised(since).with_only_columns(row.at).order_by(row.at)))
            mix = session.execute(
                self._raised(since).with_only_columns(row.priority, func.count()).group_by(row.priority)
            ).all()
            top = session.execute(
                self._raised(since)
                .with_only_columns(row.code, func.count())
                .group_by(row.code)
                .order_by(func.count().desc(), row.code)
                .limit(10)
            ).all()
            answers = select(row.waited_s).where(
                row.farm_id == self._farm_id, row.at >= since, row.waited_s.is_not(None)
            )
            waited = [int(one) for one in session.scalars(answers.limit(20_000)) if one is not None]
        counted = [0] * bins
        for at in times:
            if first <= at <= now:
                counted[min(int((at - first) / TEN_MIN), bins - 1)] += 1
        return Figures(
            [(first + number * TEN_MIN, count) for number, count in enumerate(counted)],
            counted[-1],
            waited,
            {int(level): int(count) for level, count in mix},
            [(str(code), int(count)) for code, count in top],
            len(times),
            _flood_s([at.timestamp() for at in times], now.timestamp()),
            max(TEN_MIN, span if began is None else min(span, now - began)).total_seconds(),
        )

    def _raised(self, since: datetime | None) -> Select[AlarmJournalRow]:
        row = AlarmJournalRow
        query = select(row).where(row.farm_id == self._farm_id, row.what == What.RAISED.value, row.is_shown)
        return query if since is None else query.where(row.at >= since)

    def _query(self, search: Search) -> Select[AlarmJournalRow]:
        row = AlarmJournalRow
        wanted: list[ColumnElement[bool]] = [row.farm_id == self._farm_id]
        if search.start is not None:
            wanted.append(row.at >= search.start)
        if search.end is not None:
            wanted.append(row.at <= search.end)
        if search.priority is not None:
            wanted.append(row.priority == search.priority)
        if search.source is not None:
            wanted.append(row.source == search.source)
        for word in search.text.split()[:8]:
            columns = (row.name, row.title, row.text, row.by, row.alarm_id)
            wanted.append(or_(*(column.icontains(word, autoescape=True) for column in columns)))
        return select(row).where(*wanted)


def _flood_s(times: list[float], now_s: float) -> float:
    """Return how long there was a flood, played through from raised times."""
    flood, total_s, since_s = Flood(), 0.0, None
    marks = sorted([(at, True) for at in times] + [(at + 600.0, False) for at in times if at + 600.0 < now_s])
    for at, is_raised in marks:
        is_on = flood.raised(at) if is_raised else flood.pass_time(at)
        if is_on and since_s is None:
            since_s = at
        elif not is_on and since_s is not None:
            total_s, since_s = total_s + at - since_s, None
    return total_s + (now_s - since_s if since_s is not None else 0.0)


def _line(row: AlarmJournalRow) -> Line:
    return Line(*(getattr(row, name) for name in Line._fields))

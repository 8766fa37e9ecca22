"""What is known around an alarm, what happened to alarms in the past, and how well they are dealt with."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query
from starlette.responses import StreamingResponse

from hmi.api.access import Watcher
from hmi.api.errors import ApiError
from hmi.clock import Clock
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.live_alarm import LiveAlarm
from hmi.presenters import alarm_journal as shown
from hmi.presenters.alarm_sequence import sequence
from hmi.presenters.alarms import entry, words
from hmi.presenters.diagnosis import diagnose
from hmi.presenters.scene import Scene
from hmi.store.alarm_journal import AlarmJournal, Search
from hmi.store.alarms import AlarmStore
from hmi.store.audit import Audit
from hmi.store.database import Database
from hmi.store.history import History

BEFORE, AFTER = timedelta(seconds=60), timedelta(seconds=120)
SEEN_SPAN = timedelta(days=30)
AlarmId = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9._-]{0,180}\z")]
Most = Annotated[int, Query(ge=1, le=1000)]
When = Annotated[datetime | None, Query(description="ISO 8601 with zone")]
Words = Annotated[str, Query(max_length=100)]
Level = Annotated[int | None, Query(ge=1, le=4)]
Source = Annotated[str | None, Query(max_length=64)]


@dataclass(frozen=True, slots=True)
class AlarmRecordRoutes:
    """What the routes need.

    Args:
        scene_of: what a guided check of a source may look at.
        contact_of: whom to call about a source, ``None`` if nobody is named.
        responsible_for: who answers for a source in this shift, empty if nobody does.
        per_operator_hour: alarms per hour of a person who is there to answer; ``None`` while too little is known.
    """

    store: AlarmStore
    journal: AlarmJournal
    history: History
    audit: Audit
    database: Database
    clock: Clock
    name_of: Callable[[str], str]
    scene_of: Callable[[str], Scene]
    contact_of: Callable[[str], dict[str, str] | None]
    responsible_for: Callable[[str], str]
    per_operator_hour: Callable[[], float | None]


def alarm_record_routes(parts: AlarmRecordRoutes) -> APIRouter:
    """Return the routes of journal, statistics, and of one alarm with what is known around it."""
    router = APIRouter(tags=["alarms"])
    _add_journal(router, parts)

    @router.get("/alarms/statistics", summary="Figures of alarms against their targets")
    async def statistics(_session: Watcher) -> dict[str, Any]:
        now = parts.clock.utc()
        found = await parts.database.run(parts.journal.figures, now)
        return shown.figures(found, parts.store.all(), now, parts.per_operator_hour(), catalogue())

    @router.get("/alarms/{alarm_id}", summary="One alarm: what to do, and what happened around it")
    async def one(alarm_id: AlarmId, session: Watcher) -> dict[str, Any]:
        live = parts.store.get(alarm_id)
        source, raised = live.alarm.key.source, live.alarm.raised_at or parts.clock.utc()
        happened = await parts.database.run(_happened, parts, session.farm_id, live, raised)
        before = await parts.database.run(parts.journal.raised_before, alarm_id, raised - SEEN_SPAN, raised)
        said = words(live.type, live.alarm.advice)
        return {
            "alarm": {"id": live.id, **entry(live, parts.name_of(source))},
            "type": {**said, "has_diagnosis": bool(live.type.diagnosis)},
            "sequence": happened,
            "seen_before": before,
            "contact": parts.contact_of(source),
            "responsible": parts.responsible_for(source),
        }

    @router.post("/alarms/{alarm_id}/diagnose", summary="Look at live values and say what they tell")
    async def check(alarm_id: AlarmId, _session: Watcher) -> dict[str, Any]:
        live = parts.store.get(alarm_id)
        if not live.type.diagnosis:
            raise ApiError(409, "no_diagnosis", "There is no guided check for this alarm.")
        return diagnose(live.type.diagnosis, parts.scene_of(live.alarm.key.source))

    return router


def _add_journal(router: APIRouter, parts: AlarmRecordRoutes) -> None:
    @router.get("/alarms/journal", summary="What happened to alarms, newest first")
    async def journal(
        _session: Watcher, start: Annotated[datetime | None, Query(alias="from")] = None,
        end: Annotated[datetime | None, Query(alias="to")] = None, q: Words = "", priority: Level = None,
        robot: Source = None, limit: Most = 200, before: int | None = None,
    ) -> dict[str, Any]:  # fmt: skip
        search = _search(start, end, q, priority, robot)
        found = await parts.database.run(parts.journal.page, search, limit, before)
        last = await parts.database.run(parts.journal.last_raised)
        return {
            "lines": [shown.line(one) for one in found],
            "next_before": found[-1].id if len(found) == limit else None,
            "last_raised": None if last is None else round(last.timestamp() * 1000),
        }

    @router.get("/alarms/journal.csv", summary="The same as a table")
    async def table(
        _session: Watcher, start: Annotated[datetime | None, Query(alias="from")] = None,
        end: Annotated[datetime | None, Query(alias="to")] = None, q: Words = "", priority: Level = None,
        robot: Source = None,
    ) -> StreamingResponse:  # fmt: skip
        search = _search(start, end, q, priority, robot)
        name = f"alarms-{parts.clock.utc():%Y-%m-%d}.csv"
        headers = {"Content-Disposition": f'attachment; filename="{name}"', "Cache-Control": "no-store"}
        return StreamingResponse(_pages(parts.journal, search), media_type="text/csv; charset=utf-8", headers=headers)


def _pages(journal: AlarmJournal, search: Search) -> Iterator[str]:
    yield "\ufeff" + shown.table([], has_head=True)  # the mark tells spreadsheets that it is UTF-8
    for page in journal.export(search):
        yield shown.table(page, has_head=False)


def _happened(parts: AlarmRecordRoutes, farm_id: str, live: LiveAlarm, raised: datetime) -> list[dict[str, Any]]:
    """Collect what was written around the moment; blocks."""
    source, start, end = live.alarm.key.source, raised - BEFORE, raised + AFTER
    lines = parts.journal.around(source, start, end)
    events = parts.history.events(source, start=start, end=end, limit=100)
    deeds = parts.audit.recent(farm_id, 100, robot_id=source)
    return sequence(lines, events, [one for one in deeds if start <= one.at <= end], live.first or live.id)


def _search(
    start: datetime | None, end: datetime | None, text: str, priority: int | None, source: str | None
) -> Search:
    return Search(_aware(start, "from"), _aware(end, "to"), text, priority, source)


def _aware(time: datetime | None, field: str) -> datetime | None:
    if time is None:
        return None
    if time.tzinfo is None:
        raise ApiError(422, "invalid", f"{field} needs a time zone, for example Z at its end.", field)
    try:
        return time.astimezone(UTC)
    except OverflowError as error:
        raise ApiError(422, "invalid", f"{field} is out of range.", field) from error

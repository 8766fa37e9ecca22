"""The queue of missions per robot: see it, change it, arm it, release it."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path
from pydantic import Field, field_validator

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body, Id, Name, Reason, Tick
from hmi.api.errors import ApiError
from hmi.api.orders import RobotId
from hmi.api.queue_view import QueueView
from hmi.commands.queue_arming import QueueArming
from hmi.commands.queue_book import EntryOrder, QueueBook
from hmi.commands.queue_freeze import QueueFreeze
from hmi.commands.queue_handover import QueueHandover
from hmi.commands.weather import WeatherBoard
from hmi.domain.ids import new_id
from hmi.domain.queue.arming import MAX_S, MIN_S
from hmi.domain.queue.blackout import Blackout
from hmi.domain.queue.entry import MAX_WINDOW_S, WINDOW_S, Conditions
from hmi.domain.queue.repeat import MAX_EVERY_DAYS
from hmi.presenters.queue import blackout_row, entry_row, repeat_of, weather_row

EntryId = Annotated[str, Path(max_length=64)]
Share = Annotated[float, Field(ge=0, le=1)]
Utc = Annotated[str, Field(max_length=40, description="ISO 8601 with offset")]
Day = Annotated[int, Field(ge=0, le=6, description="0 is Monday")]
Minute = Annotated[int, Field(ge=0, le=1439, description="after midnight on the farm's clock")]
OFFSET_S = 6 * 3600
YEARS = range(2000, 2100)  # a time beyond is a slip, and clocks of some zones cannot even tell it


class RepeatBody(Body):
    """When the job comes again, at the time of day of ``earliest_utc`` on the farm's clock."""

    kind: Literal["daily", "workdays", "weekly", "every_n_days"]
    days: Annotated[list[Day], Field(default_factory=list, max_length=7)]
    every_days: Annotated[int, Field(ge=1, le=MAX_EVERY_DAYS)] = 1
    until: Annotated[str | None, Field(pattern=r"^\d{4}-\d{2}-\d{2}\z")] = None


class ConditionsBody(Body):
    """What must hold before the queue starts the mission; null asks nothing."""

    rain_below_mm_h: Annotated[float | None, Field(gt=0, le=100)] = None
    wind_below_mps: Annotated[float | None, Field(gt=0, le=60)] = None
    needs_daylight: bool = False
    after_sunrise_s: Annotated[int, Field(ge=-OFFSET_S, le=OFFSET_S)] = 0
    before_sunset_s: Annotated[int, Field(ge=-OFFSET_S, le=OFFSET_S)] = 0
    battery_reserve: Share | None = 0.15
    battery_min: Share | None = None
    needs_rtk: bool = True
    needs_treatment_weather: bool = False


class EntryBody(Body):
    """When and how an entry starts; a change replaces all of it."""

    is_unattended: bool = False
    earliest_utc: Utc | None = None
    window_s: Annotated[int, Field(ge=60, le=MAX_WINDOW_S)] = WINDOW_S
    repeat: RepeatBody | None = None
    conditions: ConditionsBody = ConditionsBody()


class NewEntryBody(EntryBody):
    """A mission to be put last into a queue; its own robot's if none is named."""

    mission_id: Id
    robot_id: Id | None = None


class MoveBody(Body):
    """Before which entry; null is last."""

    before: Id | None


class BlackoutBody(Body):
    """A window in which nothing starts by itself; an end at or before the beginning is on the next day."""

    name: Name
    days: Annotated[list[Day], Field(min_length=1, max_length=7)]
    from_min: Minute
    to_min: Minute
    robots: Annotated[list[Id], Field(default_factory=list, max_length=200)]


class ArmedRobot(Body):
    """A queue as the person saw it."""

    robot_id: Id
    revision: Annotated[int, Field(ge=0)]


class ArmBody(Body):
    """Which queues, and for how long."""

    robots: Annotated[list[ArmedRobot], Field(min_length=1, max_length=50)]
    duration_s: Annotated[int, Field(ge=MIN_S, le=MAX_S)]
    tick: Tick


class DisarmBody(Body):
    """Which queues; all that are armed if none is named."""

    robots: Annotated[list[Id], Field(default_factory=list, max_length=200)]


class ReleaseBody(Body):
    """Why the queue may go on."""

    reason: Reason
    tick: Tick


class TakeOffBody(Body):
    """The mission that the robot holds, as the person saw it."""

    mission_id: Id


class WeatherBody(Body):
    """What a station measured; what it has no sensor for is left out."""

    station: Name
    rain_mm_h: Annotated[float | None, Field(ge=0, le=500)] = None
    wind_mps: Annotated[float | None, Field(ge=0, le=120)] = None
    utc: Utc | None = None

    @field_validator("utc")
    @classmethod
    def _is_time(cls, value: str | None) -> str | None:
        if value is not None:
            _utc(value)
        return value


@dataclass(frozen=True, slots=True)
class QueueRoutes:
    """What the routes need."""

    book: QueueBook
    arming: QueueArming
    freeze: QueueFreeze
    handover: QueueHandover
    view: QueueView
    weather: WeatherBoard


def queue_routes(parts: QueueRoutes) -> APIRouter:
    """Return the routes of the queue and of the weather."""
    router = APIRouter(tags=["queue"])
    _add_entries(router, parts)
    _add_blackouts(router, parts)
    _add_arming(router, parts)

    @router.post("/weather", summary="Report what a weather station measured")
    async def weather(body: WeatherBody, session: SignedIn) -> dict[str, Any]:
        at = None if body.utc is None else _utc(body.utc)
        report = parts.weather.report(
            session, station=body.station, rain_mm_h=body.rain_mm_h, wind_mps=body.wind_mps, at=at
        )
        return weather_row(report) or {}

    return router


def _add_entries(router: APIRouter, parts: QueueRoutes) -> None:
    @router.get("/queue", summary="Queues, what each entry waits for, armings, windows, weather")
    async def queue(session: Watcher) -> dict[str, Any]:
        return parts.view.whole(session)

    @router.post("/queue/entries", status_code=201, summary="Put a mission last into a robot's queue")
    async def add(body: NewEntryBody, session: SignedIn) -> dict[str, Any]:
        return entry_row(await parts.book.add(session, body.mission_id, body.robot_id, _order(body)))

    @router.patch("/queue/entries/{entry_id}", summary="Replace when and how an entry starts")
    async def change(entry_id: EntryId, body: EntryBody, session: SignedIn) -> dict[str, Any]:
        return entry_row(await parts.book.change(session, entry_id, _order(body)))

    @router.post("/queue/entries/{entry_id}/move", summary="Move an entry before another one")
    async def move(entry_id: EntryId, body: MoveBody, session: SignedIn) -> dict[str, Any]:
        moved = await parts.book.move(session, entry_id, body.before)
        return {"entries": [one.id for one in moved]}

    @router.delete("/queue/entries/{entry_id}", status_code=204, summary="Take an entry out")
    async def remove(entry_id: EntryId, session: SignedIn) -> None:
        await parts.book.remove(session, entry_id)


def _add_blackouts(router: APIRouter, parts: QueueRoutes) -> None:
    async def put(session: Any, window_id: str, body: BlackoutBody) -> dict[str, Any]:
        given = (body.name, frozenset(body.days), body.from_min, body.to_min, tuple(body.robots))
        window = Blackout(window_id, session.farm_id, *given)
        return blackout_row(await parts.book.put_blackout(session, window))

    @router.post("/queue/blackouts", status_code=201, summary="Add a window in which nothing starts by itself")
    async def add(body: BlackoutBody, session: SignedIn) -> dict[str, Any]:
        return await put(session, f"b-{new_id()[:12]}", body)

    @router.put("/queue/blackouts/{entry_id}", summary="Replace a window")
    async def change(entry_id: EntryId, body: BlackoutBody, session: SignedIn) -> dict[str, Any]:
        parts.view.blackout(session, entry_id)
        return await put(session, entry_id, body)

    @router.delete("/queue/blackouts/{entry_id}", status_code=204, summary="Delete a window")
    async def remove(entry_id: EntryId, session: SignedIn) -> None:
        await parts.book.remove_blackout(session, entry_id)


def _add_arming(router: APIRouter, parts: QueueRoutes) -> None:
    @router.post("/queue/arm", summary="Let these queues start missions by themselves, until a time")
    async def arm(body: ArmBody, session: SignedIn) -> dict[str, Any]:
        wanted = {one.robot_id: one.revision for one in body.robots}
        made = await parts.arming.arm(session, wanted, float(body.duration_s), body.tick)
        text = f"Armed until {parts.view.clock(made[0].until)}."
        return {"outcome": "accepted", "code": "ok", "text": text, "until_utc": _text(made[0].until)}

    @router.post("/queue/disarm", status_code=204, summary="Disarm queues")
    async def disarm(body: DisarmBody, session: SignedIn) -> None:
        named = body.robots or [one.robot_id for one in parts.arming.book.live()]
        parts.arming.disarm(session, named)

    @router.post("/queue/robots/{robot_id}/take-off", summary="Let the queue replace a mission nobody started")
    async def take_off(robot_id: RobotId, body: TakeOffBody, session: SignedIn) -> dict[str, Any]:
        text = await parts.handover.take_off(session, robot_id, body.mission_id)
        return {"outcome": "accepted", "code": "ok", "text": text}

    @router.post("/queue/release", summary="Let the queue go on after STOP ALL; it is not armed by it")
    async def release(body: ReleaseBody, session: SignedIn) -> dict[str, Any]:
        parts.freeze.release(session, body.reason, body.tick)
        return {"outcome": "accepted", "code": "ok", "text": "Released. Nothing is armed."}


def _order(body: EntryBody) -> EntryOrder:
    try:
        repeat = None if body.repeat is None else repeat_of(body.repeat.model_dump())
    except ValueError as error:
        raise ApiError(422, "invalid", f"{error}", "repeat") from error
    return EntryOrder(
        is_unattended=body.is_unattended,
        earliest=None if body.earliest_utc is None else _utc(body.earliest_utc, "earliest_utc"),
        window_s=body.window_s,
        repeat=repeat,
        conditions=Conditions(**body.conditions.model_dump()),
    )


def _utc(text: str, field: str = "utc") -> datetime:
    try:
        found = datetime.fromisoformat(text)
    except ValueError as error:
        raise ApiError(422, "invalid", "This is no time. Use 2026-05-20T07:30:00+02:00.", field) from error
    if found.year not in YEARS:
        raise ApiError(422, "invalid", f"The year {found.year} is far away. Is it a slip?", field)
    if found.tzinfo is None:
        raise ApiError(422, "invalid", "Say the offset from UTC, e.g. +02:00 or Z.", field)
    return found.astimezone(UTC)


def _text(at: datetime) -> str:
    return at.isoformat(timespec="milliseconds")


__all__ = ["QueueRoutes", "queue_routes"]

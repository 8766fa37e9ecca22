"""The chart of a robot's supervisor, and how long it was in which state."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Annotated, Any

from fastapi import APIRouter, Query, Response

from hmi.api.access import Watcher
from hmi.api.errors import ApiError, not_found
from hmi.api.orders import RobotId
from hmi.clock import Clock
from hmi.domain.event import RobotEvent
from hmi.domain.robot import Robot
from hmi.domain.role import Permission
from hmi.domain.state_chart import Chart
from hmi.domain.state_share import add_up
from hmi.domain.state_times import Interval, Mark, intervals, mark_of
from hmi.presenters import state_chart, state_times
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.state_times import SILENCE_S, StateRecords

MOST_MINUTES = 7 * 24 * 60
MOST_SPAN = timedelta(minutes=MOST_MINUTES)
RECENT = timedelta(seconds=5)  # a span that ends so lately reaches now: what is active counts on
EVENTS_A_CHANGE = 8  # a change of an outer state leaves and enters what is in it
When = Annotated[datetime | None, Query(description="ISO 8601 with zone")]
Minutes = Annotated[int | None, Query(ge=1, le=MOST_MINUTES)]
MissionId = Annotated[str | None, Query(max_length=64)]


@dataclass(frozen=True, slots=True)
class StateRoutes:
    """What the routes need."""

    robot_of: Callable[[str], Robot | None]
    records: StateRecords
    database: Database
    clock: Clock
    authorize: Authorize


@dataclass(frozen=True, slots=True)
class _Found:
    stays: list[Interval]
    chart: Chart | None
    start: datetime
    end: datetime


def state_chart_routes(parts: StateRoutes) -> APIRouter:
    """Return the routes."""
    router = APIRouter(tags=["supervisor"])

    @router.get("/robots/{robot_id}/chart", summary="States and transitions of its supervisor")
    async def chart(robot_id: RobotId, session: Watcher) -> dict[str, Any]:
        declared = _chart(_robot(parts, session, robot_id))
        if declared is None:
            raise ApiError(404, "no_chart", "This robot sends no chart.")
        return state_chart.chart(declared)

    @router.get("/robots/{robot_id}/state-times", summary="Stays in states, and what they add up to")
    async def times(
        robot_id: RobotId, session: Watcher, start: Annotated[When, Query(alias="from")] = None,
        end: Annotated[When, Query(alias="to")] = None, mission: MissionId = None, minutes: Minutes = None,
    ) -> dict[str, Any]:  # fmt: skip
        found = await _find(parts, session, robot_id, (start, end, mission, minutes))
        sums = add_up(found.stays, found.chart, found.start, found.end)
        now = parts.clock.utc(), parts.clock.mono_s()
        return state_times.state_times(found.stays, sums, found.chart, (found.start, found.end), now)

    @router.get("/robots/{robot_id}/state-times.csv", summary="Stays in states as a table")
    async def times_csv(
        robot_id: RobotId, session: Watcher, start: Annotated[When, Query(alias="from")] = None,
        end: Annotated[When, Query(alias="to")] = None, mission: MissionId = None, minutes: Minutes = None,
    ) -> Response:  # fmt: skip
        found = await _find(parts, session, robot_id, (start, end, mission, minutes))
        name = f"state-times-{robot_id}-{found.start:%Y%m%d-%H%M}.csv"
        inside = [one for one in found.stays if one.seconds(found.start, found.end) > 0]
        headers = {"content-disposition": f'attachment; filename="{name}"'}
        return Response(state_times.table(inside), media_type="text/csv; charset=utf-8", headers=headers)

    @router.get("/robots/{robot_id}/transitions", summary="The newest changes of state, newest first")
    async def transitions(
        robot_id: RobotId, session: Watcher, limit: Annotated[int, Query(ge=1, le=500)] = 50
    ) -> dict[str, Any]:
        declared = _chart(_robot(parts, session, robot_id))

        def read() -> list[dict[str, Any]]:
            events = parts.records.newest(robot_id, limit * EVENTS_A_CHANGE)
            return state_times.transitions(intervals(_marks(events), declared), declared, limit)

        return {"transitions": await parts.database.run(read)}

    return router


def _robot(parts: StateRoutes, session: SessionInfo, robot_id: str) -> Robot:
    parts.authorize(session, Permission.WATCH, robot_id)
    robot = parts.robot_of(robot_id)
    if robot is None:
        raise not_found(f"There is no robot {robot_id}.")
    return robot


def _chart(robot: Robot) -> Chart | None:
    return robot.factsheet.chart if robot.factsheet else None


async def _find(
    parts: StateRoutes,
    session: SessionInfo,
    robot_id: str,
    wish: tuple[datetime | None, datetime | None, str | None, int | None],
) -> _Found:
    robot = _robot(parts, session, robot_id)
    now, now_s = parts.clock.utc(), parts.clock.mono_s()
    start, end = await _span(parts, robot, wish, now)
    active, heard = None, None
    if robot.state is not None:
        heard = now - timedelta(seconds=max(0.0, now_s - robot.state.stamp.source_s))
        if end >= now - RECENT:
            active = {one.id: now - timedelta(seconds=max(0.0, now_s - one.since_s)) for one in robot.state.active}
            end = min(end, heard)  # after that nothing is known

    def read() -> list[Interval]:
        marks = _marks(parts.records.events(robot_id, start, end))
        last = heard or (marks[-1].at if marks else None)
        stays = intervals(marks, _chart(robot), active, last)
        guessed = [one for one in stays if one.is_guessed and one.seconds(start, end) > SILENCE_S]
        if not guessed:
            return stays
        # a robot that was switched off told no end: what it told after it came back is not when the stay ended
        silences = parts.records.silences(robot_id, min(one.start for one in guessed), end)
        return intervals(marks, _chart(robot), active, last, silences)

    # a day of events takes a while: not on the event loop
    return _Found(await parts.database.run(read), _chart(robot), start, max(start, end))


def _marks(events: Iterable[RobotEvent]) -> list[Mark]:
    return [mark for event in events if (mark := mark_of(event)) is not None]


async def _span(
    parts: StateRoutes,
    robot: Robot,
    wish: tuple[datetime | None, datetime | None, str | None, int | None],
    now: datetime,
) -> tuple[datetime, datetime]:
    start, end, mission, minutes = wish
    if mission is not None:
        span = await parts.database.run(parts.records.mission_span, robot.id, mission)
        if span is None:
            raise not_found("No change of state of this robot is on record for this mission.")
        order = robot.state.order if robot.state else None
        is_running = order is not None and order.mission_id == mission and order.status in ("running", "paused")
        return span.start, now if is_running else span.end
    if (start is None) != (end is None):
        raise ApiError(422, "invalid", "Give from and to together, or minutes, or a mission.", "from")
    if start is None or end is None:
        return now - timedelta(minutes=minutes or 10), now
    if start.tzinfo is None or end.tzinfo is None:
        raise ApiError(422, "invalid", "Times need a zone, for example Z at their end.", "from")
    if not timedelta(0) < end - start <= MOST_SPAN:
        raise ApiError(422, "invalid", "The start must lie before the end, by a week at most.", "from")
    return start.astimezone(UTC), end.astimezone(UTC)

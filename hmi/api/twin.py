"""The 3D twin over REST: replay of postures, a robot's own model, and how the media process does."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Annotated, Any, Protocol, TypeVar

from fastapi import APIRouter, Query, Request
from starlette.requests import ClientDisconnect

from hmi.api.access import SignedIn, Watcher
from hmi.api.errors import ApiError, not_found
from hmi.api.orders import RobotId
from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.ports import AuditSink
from hmi.domain.event import RobotEvent
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.history import History, PosturePoint
from hmi.store.robots import Robots

T = TypeVar("T")
MOST_REPLAY = timedelta(hours=1)
MOST_UPLOAD_BYTES = 40 * 1024 * 1024
EVENT_KINDS = ("alarm_raised", "treatment", "mission", "safety")
AWAY = "The 3D twin is not running. It comes back by itself; try again in a moment."


class ModelKeeper(Protocol):
    """Keeps robots' own models; each raises ``ModelsAway`` or ``ModelRefused``."""

    async def describe(self, robot_id: str) -> dict[str, Any]:
        """Return what is known of a robot's own model."""
        ...

    async def take(self, robot_id: str, chunks: AsyncIterator[bytes]) -> dict[str, Any]:
        """Read a zip and keep its model."""
        ...

    async def remove(self, robot_id: str) -> bool:
        """Drop a robot's own model."""
        ...

    async def status(self) -> dict[str, Any] | None:
        """Return how the media process does, ``None`` if it does not answer."""
        ...


class ModelsAway(Exception):
    """Whoever keeps the models does not answer."""


class ModelRefused(Exception):
    """A model cannot be used; ``text`` says why, for a person."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text


@dataclass(frozen=True, slots=True)
class TwinRoutes:
    """What the routes need."""

    models: ModelKeeper
    history: History
    registry: Robots
    database: Database
    authorize: Authorize
    audit: AuditSink
    clock: Clock


def twin_routes(parts: TwinRoutes) -> APIRouter:
    """Return the routes of the twin."""
    router = APIRouter(tags=["twin"])
    _add_replay(router, parts)
    _add_model(router, parts)

    @router.get("/twin/status", summary="Whether 3D is running, and for how many")
    async def status(session: Watcher) -> dict[str, Any]:
        found = await parts.models.status()
        if found is None:
            return {"state": "down", "pictures": 0}
        return {"state": "ok", "pictures": found["pictures"], "robots": found["robots"]}

    return router


def _add_replay(router: APIRouter, parts: TwinRoutes) -> None:
    @router.get("/robots/{robot_id}/replay", summary="Where a robot was and how its joints stood, for at most an hour")
    async def replay(
        robot_id: RobotId,
        session: SignedIn,
        start: Annotated[datetime | None, Query(alias="from", description="ISO 8601 with zone")] = None,
        end: Annotated[datetime | None, Query(alias="to", description="ISO 8601 with zone")] = None,
        minutes: Annotated[int | None, Query(ge=1, le=60, description="the last ones, by the console's clock")] = None,
    ) -> dict[str, Any]:
        parts.authorize(session, Permission.REPLAY, robot_id)
        _known(parts, robot_id)
        since, until = _span(start, end) if minutes is None else _last(minutes, parts.clock.utc())
        points = await parts.database.run(parts.history.postures, robot_id, since, until)
        events = await parts.database.run(
            parts.history.events, robot_id, start=since, end=until, kinds=EVENT_KINDS, limit=500
        )
        marks = [_mark(one) for one in reversed(events)]
        return {"robot_id": robot_id, **_columns(points), "events": marks}


def _add_model(router: APIRouter, parts: TwinRoutes) -> None:
    @router.get("/robots/{robot_id}/model", summary="The robot's own 3D model, if an admin gave it one")
    async def model(robot_id: RobotId, session: Watcher) -> dict[str, Any]:
        parts.authorize(session, Permission.WATCH, robot_id)
        _known(parts, robot_id)
        return await _asked(parts.models.describe(robot_id))

    @router.post("/robots/{robot_id}/model", summary="Upload a zip of one URDF and its meshes; the body is the file")
    async def upload(robot_id: RobotId, request: Request, session: SignedIn) -> dict[str, Any]:
        parts.authorize(session, Permission.MANAGE_ROBOTS, robot_id)
        _known(parts, robot_id)
        told = request.headers.get("content-length", "")
        if told.isdigit() and int(told) > MOST_UPLOAD_BYTES:
            raise ApiError(413, "too_large", f"The upload is over {MOST_UPLOAD_BYTES // 2**20} MB.")
        try:
            found = await _asked(parts.models.take(robot_id, request.stream()))
        except ClientDisconnect as error:
            raise ApiError(400, "cancelled", "The upload was given up.") from error
        _note(parts, session, robot_id, "taken", f"{found['name']}, {found['faces']} triangles")
        return {"kept": True, **found}

    @router.delete("/robots/{robot_id}/model", summary="Remove the robot's own 3D model")
    async def remove(robot_id: RobotId, session: SignedIn) -> dict[str, Any]:
        parts.authorize(session, Permission.MANAGE_ROBOTS, robot_id)
        _known(parts, robot_id)
        if await _asked(parts.models.remove(robot_id)):
            _note(parts, session, robot_id, "removed", f"{robot_id} has no model of its own now")
        return {"kept": False}


async def _asked(question: Awaitable[T]) -> T:
    try:
        return await question
    except ModelsAway as error:
        raise ApiError(503, "twin_away", AWAY) from error
    except ModelRefused as error:
        raise ApiError(422, error.code, error.text) from error


def _note(parts: TwinRoutes, session: SessionInfo, robot_id: str, outcome: str, text: str) -> None:
    parts.audit.append(audit_line(session, "robot_model", outcome, text, ref=robot_id, robot_id=robot_id))


def _known(parts: TwinRoutes, robot_id: str) -> None:
    if parts.registry.get(robot_id) is None:
        raise not_found(f"There is no robot {robot_id}.")


def _last(minutes: int, now: datetime) -> tuple[datetime, datetime]:
    return now - timedelta(minutes=minutes), now


def _span(start: datetime | None, end: datetime | None) -> tuple[datetime, datetime]:
    if start is None or end is None:
        raise ApiError(422, "invalid", "Give from and to, or minutes.", "from")
    if start.tzinfo is None or end.tzinfo is None:
        raise ApiError(422, "invalid", "from and to need a time zone, for example Z at the end.", "from")
    if not timedelta(0) < end - start <= MOST_REPLAY:
        raise ApiError(422, "invalid", "from must lie before to, by an hour at most.", "from")
    return start.astimezone(UTC), end.astimezone(UTC)


def _columns(points: list[PosturePoint]) -> dict[str, Any]:
    names = sorted({name for point in points for name in point.joints or {}})
    return {
        "t": [_ms(point.at) for point in points],
        "lat": [point.lat_deg for point in points],
        "lon": [point.lon_deg for point in points],
        "theta": [point.theta_rad for point in points],
        "height": [point.height_m for point in points],
        "joints": {name: [(point.joints or {}).get(name) for point in points] for name in names},
    }


def _mark(event: RobotEvent) -> dict[str, Any]:
    mark = {"t": _ms(event.at_utc), "name": event.name, "kind": event.kind}
    target = event.data.get("target")
    return {**mark, "target": target} if isinstance(target, str) else mark


def _ms(at: datetime) -> int:
    return round(at.timestamp() * 1000)

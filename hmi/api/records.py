"""What was recorded: the audit, events of robots, values over time."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Annotated, Any

from fastapi import APIRouter, Query

from hmi.api.access import Auditor, Watcher
from hmi.api.errors import ApiError, not_found
from hmi.api.orders import RobotId
from hmi.clock import Clock
from hmi.domain.event import RobotEvent
from hmi.store.audit import Audit
from hmi.store.database import Database
from hmi.store.history import FIELDS, History
from hmi.store.robots import Robots

DEFAULT_SPAN = timedelta(hours=1)
MAX_SPAN = timedelta(days=366)
EVENT_KINDS = frozenset(
    {"state_entered", "state_left", "alarm_raised", "alarm_cleared", "treatment", "mission", "safety", "mode"}
)
Most = Annotated[int, Query(ge=1, le=1000)]
When = Annotated[datetime | None, Query(description="ISO 8601 with zone")]
Short = Annotated[str | None, Query(max_length=64)]


@dataclass(frozen=True, slots=True)
class RecordRoutes:
    """What the routes of records need."""

    audit: Audit
    history: History
    registry: Robots
    database: Database
    clock: Clock


def record_routes(parts: RecordRoutes) -> APIRouter:
    """Return the routes of records."""
    router = APIRouter(tags=["records"])

    @router.get("/audit", summary="Who did what, newest first")
    async def audit(
        session: Auditor, limit: Most = 100, before: int | None = None, robot: Short = None, kind: Short = None,
        ref: Short = None,
    ) -> dict[str, Any]:  # fmt: skip
        entries = await parts.database.run(
            parts.audit.recent, session.farm_id, limit, before_seq=before, robot_id=robot, kind=kind, ref=ref
        )
        rows = [
            {
                "seq": e.seq,
                "utc": _utc(e.at),
                "actor": e.actor,
                "device": e.device,
                "kind": e.kind,
                "robot_id": e.robot_id,
                "ref": e.ref,
                "outcome": e.outcome,
                "text": e.text,
                "data": e.data,
                "hash": e.hash,
            }
            for e in entries
        ]
        return {"entries": rows, "next_before": entries[-1].seq if len(entries) == limit else None}

    @router.get("/audit/verify", summary="Check the whole chain")
    async def verify(
        session: Auditor, head: Annotated[str | None, Query(pattern="^[0-9a-f]{64}$")] = None
    ) -> dict[str, Any]:
        verdict = await parts.database.run(parts.audit.verify, session.farm_id, head)
        return {
            "is_whole": verdict.first_broken_seq is None,
            "rows": verdict.rows,
            "first_broken_seq": verdict.first_broken_seq,
            "text": verdict.text,
            "head": verdict.head,
        }

    @router.get("/events", summary="Events of robots, newest first")
    async def events(
        session: Watcher, robot: Short = None, kind: Annotated[list[str] | None, Query(max_length=8)] = None,
        start: When = None, end: When = None, limit: Most = 200,
    ) -> dict[str, Any]:  # fmt: skip
        kinds = tuple(kind or ())
        if unknown := set(kinds) - EVENT_KINDS:
            raise ApiError(422, "invalid", f"There is no kind {min(unknown)}.", "kind")
        found = await parts.database.run(
            parts.history.events, robot, start=_aware(start, "start"), end=_aware(end, "end"), kinds=kinds, limit=limit
        )
        return {"events": [_event(e) for e in found]}

    @router.get("/history/{robot_id}", summary="Mean, lowest and highest of values over time")
    async def history(
        robot_id: RobotId, session: Watcher, field: Annotated[list[str] | None, Query(max_length=8)] = None,
        start: When = None, end: When = None, points: Annotated[int, Query(ge=1, le=5000)] = 500,
    ) -> dict[str, Any]:  # fmt: skip
        fields = tuple(dict.fromkeys(field or ("speed_mps", "soc")))
        if unknown := set(fields) - FIELDS:
            raise ApiError(422, "invalid", f"There is no history of {min(unknown)}.", "field")
        since, until = _span(parts, robot_id, start, end)
        found = await parts.database.run(parts.history.history, robot_id, fields, since, until, points)
        rows = [{"utc": _utc(p.at), "mean": p.mean, "low": p.low, "high": p.high, "count": p.count} for p in found]
        return {
            "robot_id": robot_id,
            "fields": fields,
            "start_utc": _utc(since),
            "end_utc": _utc(until),
            "points": rows,
        }

    @router.get("/history/{robot_id}/track", summary="Where a robot was")
    async def track(
        robot_id: RobotId, session: Watcher, start: When = None, end: When = None,
        points: Annotated[int, Query(ge=1, le=5000)] = 1000,
    ) -> dict[str, Any]:  # fmt: skip
        since, until = _span(parts, robot_id, start, end)
        found = await parts.database.run(parts.history.track, robot_id, since, until, points)
        rows = [
            {
                "utc": _utc(p.at),
                "lat_deg": p.lat_deg,
                "lon_deg": p.lon_deg,
                "theta_rad": p.theta_rad,
                "speed_mps": p.speed_mps,
                "mode": p.mode,
                "mission_id": p.mission_id,
            }
            for p in found
        ]
        return {"robot_id": robot_id, "start_utc": _utc(since), "end_utc": _utc(until), "points": rows}

    return router


def _span(
    parts: RecordRoutes, robot_id: str, start: datetime | None, end: datetime | None
) -> tuple[datetime, datetime]:
    if parts.registry.get(robot_id) is None:
        raise not_found(f"There is no robot {robot_id}.")
    until = _aware(end, "end") or parts.clock.utc()
    since = _aware(start, "start") or until - DEFAULT_SPAN
    if not timedelta(0) < until - since <= MAX_SPAN:
        raise ApiError(422, "invalid", "The start must lie before the end, by a year at most.", "start")
    return since, until


def _aware(time: datetime | None, field: str) -> datetime | None:
    if time is None:
        return None
    if time.tzinfo is None:
        raise ApiError(422, "invalid", f"{field} needs a time zone, for example Z at its end.", field)
    try:
        return time.astimezone(UTC)
    except OverflowError as error:
        raise ApiError(422, "invalid", f"{field} is out of range.", field) from error


def _utc(time: datetime) -> str:
    return time.isoformat(timespec="milliseconds")


def _event(event: RobotEvent) -> dict[str, Any]:
    return {
        "id": event.event_id,
        "robot_id": event.robot_id,
        "kind": event.kind,
        "name": event.name,
        "text": event.text,
        "data": event.data,
        "utc": _utc(event.at_utc),
        "mission_id": event.mission_id,
    }

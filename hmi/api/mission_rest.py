"""Going on with a mission, and the checklist before a start."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any, Literal

from fastapi import APIRouter
from pydantic import AfterValidator, Field

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body, Id, Tick
from hmi.api.errors import not_found
from hmi.api.missions import MissionId, row, translated
from hmi.api.orders import RobotId, raise_if_forbidden
from hmi.commands.checklist_desk import ChecklistDesk
from hmi.commands.mission_rest import MissionRests, RestOrder, RestView
from hmi.commands.mission_send import MissionSent
from hmi.commands.rest_words import drawn_on, forgotten_words
from hmi.domain.mission_rest import OBSTACLE, DrawnArea
from hmi.planning.jobs import mission_geojson
from hmi.store.checklists import Checklist
from hmi.store.errors import NotFound


def _on_earth(place: list[float]) -> list[float]:
    if not (-180 <= place[0] <= 180 and -90 <= place[1] <= 90):
        raise ValueError("longitude and latitude, in degrees")
    return place


LonLat = Annotated[list[float], Field(min_length=2, max_length=2), AfterValidator(_on_earth)]


class DrawnBody(Body):
    """Ground drawn on the map: corners of its outline, longitude and latitude."""

    kind: Literal["leave_out", "obstacle"]
    outline: Annotated[list[LonLat], Field(min_length=3, max_length=500)]
    clearance_m: Annotated[float, Field(ge=0, le=20, description="kept around an obstacle")] = 0.0


class RestBody(Body):
    """What the rest shall be: ``change`` of what is under way, ``later`` from where the robot stands."""

    kind: Literal["change", "later"]
    leave_out: Annotated[list[int], Field(max_length=20_000, description="numbers of pieces")] = Field(default=[])
    areas: Annotated[list[DrawnBody] | None, Field(max_length=20, description="null keeps those drawn before")] = None
    is_reversed: bool = False
    row_speed_mps: Annotated[float | None, Field(gt=0, le=5)] = None
    end: Literal["as_planned", "stay", "home"] = "as_planned"
    home_id: Id | None = None


class SendBody(Body):
    """A rest that was shown: its hash, and the newest tick the screen had."""

    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}\z")]
    tick: Tick


class FreshBody(Body):
    """The newest tick the screen had when the person decided."""

    tick: Tick


class TickedBody(Body):
    """The lines that were ticked."""

    ticked: Annotated[list[Id], Field(max_length=50)]


def rest_routes(rests: MissionRests, checklists: ChecklistDesk) -> APIRouter:
    """Return the routes of going on, and of checklists."""
    router = APIRouter(tags=["missions"])

    @router.get("/missions/{mission_id}/rest", summary="How far a mission is and what is left")
    async def rest(mission_id: MissionId, session: Watcher) -> dict[str, Any]:
        return _view(await translated(lambda: rests.left(session, mission_id)))

    @router.post("/missions/{mission_id}/rest/preview", summary="Plan the rest anew without sending it")
    async def preview(mission_id: MissionId, body: RestBody, session: SignedIn) -> dict[str, Any]:
        planned = await translated(lambda: rests.preview(session, mission_id, _order(body)))
        shape = await asyncio.to_thread(
            mission_geojson, planned.document, {"treatment": planned.statistics.get("treatment")}
        )
        return {"sha256": planned.sha256, **planned.difference, "geometry": shape}

    @router.post("/missions/{mission_id}/rest", summary="Send a rest that was shown")
    async def send(mission_id: MissionId, body: SendBody, session: SignedIn) -> dict[str, Any]:
        return _sent(await translated(lambda: rests.send(session, mission_id, body.sha256, body.tick)))

    @router.post("/missions/{mission_id}/fresh", summary="Send the whole mission again; forgets what was done")
    async def fresh(mission_id: MissionId, body: FreshBody, session: SignedIn) -> dict[str, Any]:
        return _sent(await translated(lambda: rests.fresh(session, mission_id, body.tick)))

    @router.get("/robots/{robot_id}/checklist", summary="What a person looks at before a start")
    async def checklist(robot_id: RobotId, session: Watcher) -> dict[str, Any]:
        try:
            view = checklists.view(session, robot_id)
        except NotFound as error:
            raise not_found(f"There is no robot {robot_id}.") from error
        return {
            "items": [{"id": one.id, "text": one.text} for one in view.items],
            "is_required": view.is_required,
            "valid_hours": view.valid_hours,
            "record": _record(view.record),
        }

    @router.post("/robots/{robot_id}/checklist", status_code=201, summary="Record that the list was ticked")
    async def tick(robot_id: RobotId, body: TickedBody, session: SignedIn) -> dict[str, Any]:
        record = await translated(lambda: checklists.tick(session, robot_id, body.ticked))
        return {"record": _record(record)}

    return router


def _order(body: RestBody) -> RestOrder:
    given = body.model_dump(exclude={"leave_out", "areas"})
    areas = None if body.areas is None else tuple(_drawn(one) for one in body.areas)
    return RestOrder(**given, leave_out=tuple(body.leave_out), areas=areas)


def _drawn(body: DrawnBody) -> DrawnArea:
    outline = body.outline[:-1] if body.outline[0] == body.outline[-1] else body.outline
    return DrawnArea(
        body.kind, tuple((lon, lat) for lon, lat in outline), body.clearance_m if body.kind == OBSTACLE else 0.0
    )


def _view(view: RestView) -> dict[str, Any]:
    progress = view.progress
    return {
        **row(view.mission),
        "progress": None if progress is None else progress.as_json(),
        "is_live": view.is_live,
        "forgets": forgotten_words(view.mission, progress),
        "areas": [one.as_json() for one in drawn_on(view.mission)],
        "pieces": [
            {
                "number": one.number,
                "name": one.name,
                "kind": one.kind,
                "row": one.row,
                "lap": one.lap,
                "length_m": round(one.length_m, 1),
                "is_present": one.is_present,
            }
            for one in view.pieces
        ],
    }


def _sent(sent: MissionSent) -> dict[str, Any]:
    raise_if_forbidden(sent.code, sent.text)
    return {"outcome": sent.outcome.value, "code": sent.code, "text": sent.text, "sha256": sent.sha256}


def _record(record: Checklist | None) -> dict[str, Any] | None:
    if record is None:
        return None
    at, until = (one.isoformat(timespec="milliseconds") for one in (record.at, record.valid_until))
    return {"id": record.id, "by": record.user_name, "utc": at, "valid_until_utc": until}

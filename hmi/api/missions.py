"""Stored missions, the farm's map, and the geometry of what a robot drives."""

from __future__ import annotations

import asyncio
import hashlib
import math
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any

import msgspec
from fastapi import APIRouter, Path, Request, Response
from pydantic import Field
from starlette.responses import StreamingResponse

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body, Id, Name
from hmi.api.candidates import candidate_stream
from hmi.api.errors import ApiError, not_found
from hmi.api.orders import RobotId
from hmi.api.plan_body import PlanBody, order_of
from hmi.commands.mission_book import MissionBook
from hmi.commands.ports import FleetReader
from hmi.commands.row_direction import FOLLOWED, lines_of
from hmi.domain.mission_document import Document, mission_sha256
from hmi.domain.mission_plan import MissionError, MissionRefused, PlanRefused
from hmi.domain.planned_machine import MACHINE
from hmi.planning.jobs import mission_geojson
from hmi.presenters.mission_battery import battery_row
from hmi.store.features import Feature, feature_collection
from hmi.store.missions import Mission, MissionLogEntry

GEOJSON = "application/geo+json"
KEPT = 16  # encoded geometries: a map asks again at each reload, a plan of half a metre takes 50 ms to make
AREA_KINDS = ("treatment", "slow")  # ground that may get a dose of its own
AREAS = ("treatment", "drawn_areas")  # shapes among a mission's figures: they go out with its geometry
MissionId = Annotated[str, Path(max_length=64)]


class ChangeBody(Body):
    """What can be changed of a mission; what is left out stays."""

    name: Name | None = None
    is_supervised: bool | None = None
    robot_id: Id | None = None


class CopyBody(Body):
    """The name of the copy; one is made up if it is left out."""

    name: Annotated[str, Field(max_length=80)] = ""


class _Encoded:
    """Geometries as they go out, the newest few, by their tag."""

    def __init__(self) -> None:
        self._kept: OrderedDict[str, bytes] = OrderedDict()

    async def of(self, tag: str, sha256: str, document: Document, statistics: Mapping[str, Any]) -> bytes:
        if tag not in self._kept:
            self._kept[tag] = await asyncio.to_thread(_encode, document, sha256, statistics)
            while len(self._kept) > KEPT:
                self._kept.popitem(last=False)
        self._kept.move_to_end(tag)
        return self._kept[tag]


def mission_routes(book: MissionBook, fleet: FleetReader) -> APIRouter:
    """Return the routes of missions and of the map."""
    router = APIRouter(tags=["missions"])
    encoded = _Encoded()
    _add_reading(router, book, encoded)
    _add_battery(router, book, fleet)
    _add_planning(router, book)
    _add_changing(router, book)
    _add_maps(router, book, fleet, encoded)
    return router


def _add_reading(router: APIRouter, book: MissionBook, encoded: _Encoded) -> None:
    @router.get("/missions", summary="Stored missions, the one that changed last first")
    async def missions(session: Watcher) -> dict[str, Any]:
        return {"missions": [row(one) for one in book.list(session)]}

    @router.get("/missions/{mission_id}", summary="One mission with its numbers and its log")
    async def mission(mission_id: MissionId, session: Watcher) -> dict[str, Any]:
        found = _one(book, session, mission_id)
        entries = await book.log(session, mission_id)
        wish = {} if found.wish is None else {"wish": found.wish}
        return {**row(found), **wish, "log": [_entry(one) for one in entries]}

    @router.get("/missions/{mission_id}/document", summary="What goes to the robot")
    async def document(mission_id: MissionId, session: Watcher) -> Document:
        _one(book, session, mission_id)
        found: Document = await translated(lambda: book.document(session, mission_id))
        return found

    @router.get("/missions/{mission_id}/map.geojson", summary="Geometry of one mission", response_class=Response)
    async def geometry(mission_id: MissionId, request: Request, session: Watcher) -> Response:
        found = _one(book, session, mission_id)
        tag = _tag(found.sha256, found)
        if found.sha256 and _is_known(request, tag):
            return Response(status_code=304)
        document = await translated(lambda: book.document(session, mission_id))
        body = await encoded.of(tag, found.sha256, document, found.statistics)
        return _geojson(body, tag)


def _add_battery(router: APIRouter, book: MissionBook, fleet: FleetReader) -> None:
    @router.get("/missions/{mission_id}/battery", summary="What a mission takes of the battery of a robot")
    async def battery(mission_id: MissionId, robot: Id, session: Watcher) -> dict[str, Any]:
        mission, found = _one(book, session, mission_id), fleet.robot(robot)
        if found is None or found.farm_id != session.farm_id:
            raise not_found(f"There is no robot {robot}.")
        machine = book.machine_of(mission) or {}
        before = fleet.robot(machine.get("robot_id", ""))
        figures = {**mission.statistics, **({MACHINE: machine} if machine else {})}
        return battery_row(figures, found, "" if before is None else before.name)


def _add_planning(router: APIRouter, book: MissionBook) -> None:
    @router.post("/missions/plan", status_code=201, summary="Plan a field and store the mission")
    async def plan(body: PlanBody, session: SignedIn) -> dict[str, Any]:
        with_errors = translated(lambda: book.plan(session, order_of(body), body.draft_id, body.draft_revision))
        return row(await with_errors)

    @router.post("/missions/preview", summary="Plan a field without storing: numbers and geometry")
    async def preview(body: PlanBody, session: SignedIn) -> dict[str, Any]:
        planned = await translated(lambda: book.preview(session, order_of(body)))
        shape = await asyncio.to_thread(mission_geojson, planned.document)
        return {"statistics": planned.statistics, "name": planned.document["name"], "geometry": shape}

    @router.post("/missions/candidates", summary="Plan a field in every pattern without storing: one line of JSON each")
    async def candidates(body: PlanBody, session: SignedIn) -> StreamingResponse:
        return candidate_stream(await translated(lambda: book.candidates(session, order_of(body))))


def _add_changing(router: APIRouter, book: MissionBook) -> None:
    @router.post("/missions/{mission_id}/copy", status_code=201, summary="Copy a mission; the copy has not run")
    async def copy(mission_id: MissionId, body: CopyBody, session: SignedIn) -> dict[str, Any]:
        return row(await translated(lambda: book.copy(session, mission_id, " ".join(body.name.split()))))

    @router.patch("/missions/{mission_id}", summary="Rename a mission no robot holds, or change who drives it and how")
    async def change(mission_id: MissionId, body: ChangeBody, session: SignedIn) -> dict[str, Any]:
        if body.name is None and body.is_supervised is None and body.robot_id is None:
            raise ApiError(422, "invalid", "Say what to change: name, is_supervised or robot_id.", "name")
        changed: Mission | None = None
        if body.is_supervised is not None or body.robot_id is not None:
            attended, robot_id = body.is_supervised, body.robot_id
            changed = await translated(
                lambda: book.change(session, mission_id, is_supervised=attended, robot_id=robot_id)
            )
        name = body.name
        if name is not None:
            changed = await translated(lambda: book.rename(session, mission_id, name))
        assert changed is not None
        return row(changed)

    @router.delete("/missions/{mission_id}", status_code=204, summary="Delete a mission that never ran")
    async def delete(mission_id: MissionId, session: SignedIn) -> None:
        await translated(lambda: book.delete(session, mission_id))


def _add_maps(router: APIRouter, book: MissionBook, fleet: FleetReader, encoded: _Encoded) -> None:
    @router.get("/features", summary="The farm's map as GeoJSON", response_class=Response)
    async def features(request: Request, session: Watcher) -> Response:
        found = await book.features(session)
        body = await asyncio.to_thread(lambda: msgspec.json.encode(feature_collection(found)))
        tag = hashlib.sha256(body).hexdigest()
        return Response(status_code=304) if _is_known(request, tag) else _geojson(body, tag)

    @router.get("/fields", summary="Fields a mission can be planned on")
    async def fields(session: Watcher) -> dict[str, Any]:
        found = await book.features(session, ("parcel",))
        homes = await book.features(session, ("home",))
        areas = await book.features(session, AREA_KINDS)
        lines = await book.features(session, ("rows",))
        return {
            "fields": [{**_field(one), "lines": _lines(one, lines)} for one in found],
            "homes": [_field(one) for one in homes],
            "areas": [{**_field(one), "kind": one.kind} for one in areas if "Polygon" in one.geometry["type"]],
        }

    @router.get("/robots/{robot_id}/mission.geojson", summary="What the robot drives", response_class=Response)
    async def on_robot(robot_id: RobotId, request: Request, session: Watcher) -> Response:
        robot = fleet.robot(robot_id)
        if robot is None or robot.farm_id != session.farm_id:
            raise not_found(f"There is no robot {robot_id}.")
        order = robot.state.order if robot.state is not None else None
        known = {one.id: one for one in book.list(session)}
        mission = known.get(order.mission_id) if order is not None else None
        if order is None or mission is None:
            raise not_found(f"{robot.name} has no mission of this farm.")
        tag = _tag(order.sha256, mission)
        if _is_known(request, tag):
            return Response(status_code=304)
        document = {**await book.document(session, mission.id), "robot": robot_id}
        if mission_sha256(document) != order.sha256:
            document = await book.document_read_back(session, mission.id, order.sha256) or document
        if mission_sha256(document) != order.sha256:
            raise not_found(f"{robot.name} has another version of {mission.name} than is stored here.")
        return _geojson(await encoded.of(tag, order.sha256, document, mission.statistics), tag)


async def translated(work: Callable[[], Any]) -> Any:
    """Await the book's answer; its refusals become errors of the request."""
    try:
        return await work()
    except PlanRefused as error:
        status = 503 if error.code in ("busy", "planner_failed") else 422
        raise ApiError(status, error.code, error.text, error.field or None) from error
    except MissionRefused as error:
        raise ApiError(409, error.code, error.text, error.field or None) from error
    except MissionError as error:
        raise ApiError(422, error.code, error.text, error.field or None) from error


def _one(book: MissionBook, session: Any, mission_id: str) -> Mission:
    for mission in book.list(session):
        if mission.id == mission_id:
            return mission
    raise not_found("There is no such mission.")


def row(mission: Mission) -> dict[str, Any]:
    """Return a mission as the interface shows it; numbers SI, the row direction as a bearing too."""
    angle = mission.statistics.get("angle_rad")
    bearing = None if angle is None else round((90 - math.degrees(angle)) % 180, 2)
    return {
        "id": mission.id,
        "name": mission.name,
        "field_id": mission.field_id,
        "field_name": mission.field_name,
        "robot_id": mission.robot_id,
        "status": mission.status.value,
        "is_supervised": mission.is_supervised,
        "revision": mission.revision,
        "map_version": mission.map_version,
        "progress": mission.progress,
        "is_pending": bool(mission.pending_sha256),
        "sha256": mission.sha256,
        "statistics": {key: value for key, value in mission.statistics.items() if key not in AREAS},
        "row_bearing_deg": bearing,
        "created_by": mission.created_by,
        "created_utc": mission.created_at.isoformat(timespec="milliseconds"),
        "updated_utc": mission.updated_at.isoformat(timespec="milliseconds"),
    }


def _entry(entry: MissionLogEntry) -> dict[str, Any]:
    utc = entry.at.isoformat(timespec="milliseconds")
    return {"utc": utc, "status": entry.status.value, "by": entry.by, "why": entry.why, "data": entry.data}


def _lines(field: Feature, features: Sequence[Feature]) -> dict[str, int]:
    """Return how many lines a field has that rows can follow, by what they are."""
    counts = {kind: sum(1 for _ in lines_of(field, features, kind)) for kind in FOLLOWED}
    return {kind.value: count for kind, count in counts.items() if count}


def _field(feature: Feature) -> dict[str, Any]:
    return {"id": feature.id, "name": feature.title, "properties": feature.properties, "geometry": feature.geometry}


def _encode(document: Document, sha256: str, statistics: Mapping[str, Any]) -> bytes:
    return msgspec.json.encode({**mission_geojson(document, statistics), "sha256": sha256})


def _tag(sha256: str, mission: Mission) -> str:
    """Return what tells one picture of a mission from the next: its path and the areas on it."""
    areas = {key: mission.statistics[key] for key in AREAS if mission.statistics.get(key)}
    if not areas:
        return sha256
    return hashlib.sha256(sha256.encode() + msgspec.json.encode(areas, order="sorted")).hexdigest()


def _geojson(body: bytes, tag: str) -> Response:
    return Response(body, media_type=GEOJSON, headers={"ETag": f'"{tag}"', "Cache-Control": "private, no-cache"})


def _is_known(request: Request, tag: str) -> bool:
    return f'"{tag}"' in request.headers.get("if-none-match", "")

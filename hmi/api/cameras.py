"""Cameras over REST: which there are, WebRTC by WHEP, a still, restart, lamp and zoom."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Protocol

from fastapi import APIRouter, Header, Path, Query, Request
from pydantic import Field, model_validator
from starlette.responses import Response

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body
from hmi.api.errors import ApiError
from hmi.api.orders import RobotId
from hmi.commands.audit_line import audit_line
from hmi.commands.ports import AuditSink
from hmi.domain.camera import FIELD_ROBOT, CameraSetting, ControlFailed
from hmi.domain.ids import ID_PATTERN
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize, is_allowed
from hmi.security.session_info import SessionInfo

CameraId = Annotated[str, Path(pattern=ID_PATTERN.removesuffix("$") + r"\z")]
SessionId = Annotated[str, Path(pattern=r"^[A-Za-z0-9_-]{8,64}\z")]
WatcherToken = Annotated[str, Header(alias="X-Headland-Watcher", max_length=64)]
Stamp = Callable[[SessionInfo, bytes], Awaitable[bytes]]
PICTURE_HEADERS = ("x-headland-captured", "x-headland-dated", "x-headland-seq")
CONTROL_STATUS = {"no_address": 409, "no_answer": 504, "unknown_camera": 404}


class CameraControlBody(Body):
    """Exactly one of them."""

    lamp: bool | None = None
    zoom: Annotated[float, Field(ge=1, le=100)] | None = None
    trigger: bool | None = None

    @model_validator(mode="after")
    def _one(self) -> CameraControlBody:
        if sum(one is not None for one in (self.lamp, self.zoom, self.trigger)) != 1 or self.trigger is False:
            raise ValueError("say one of lamp, zoom and trigger: true")
        return self


@dataclass(frozen=True, slots=True)
class CameraAnswer:
    """What the camera process says to a request."""

    status: int
    body: bytes
    media_type: str
    headers: Mapping[str, str]


class CameraAsk(Protocol):
    """The console's cameras; each raises ``CamerasAway``."""

    async def all(self) -> list[dict[str, Any]]:
        """Return every camera as the protocol has it."""
        ...

    async def ask(
        self,
        session: SessionInfo,
        method: str,
        path: str,
        body: bytes | None = None,
        watcher: str = "",
    ) -> CameraAnswer:
        """Send a request about a camera or session."""
        ...

    async def control(self, robot_id: str, camera: str, order: dict[str, Any]) -> None:
        """Tell a robot's camera; raises ``ControlFailed``."""
        ...

    async def setting(self, robot_id: str, camera: str) -> CameraSetting:
        """Return how a robot says its camera is set; raises ``ControlFailed``."""
        ...


class CamerasAway(Exception):
    """The camera process does not answer."""


@dataclass(frozen=True, slots=True)
class CameraRoutes:
    """What the routes need.

    Args:
        holds: whether this session controls this robot.
        obstacle: why this robot's cameras take no orders, empty if they do.
        stamp: burns who looks into a picture that leaves; ``None`` where nobody wants that.
    """

    cameras: CameraAsk
    authorize: Authorize
    holds: Callable[[str, str], bool]
    obstacle: Callable[[str], str]
    audit: AuditSink
    stamp: Stamp | None = None


def camera_routes(parts: CameraRoutes) -> APIRouter:
    """Return the routes of cameras."""
    router = APIRouter(prefix="/cameras", tags=["cameras"])
    _add_watching(router, parts)
    _add_acting(router, parts)
    return router


def _add_watching(router: APIRouter, parts: CameraRoutes) -> None:
    @router.get("", summary="Cameras with how they do")
    async def cameras(session: Watcher, robot: Annotated[str, Query(max_length=64)] = "") -> dict[str, Any]:
        """Return those this person may watch; ``503 cameras_down`` while the camera process is not up."""
        found = await _away_is_503(parts.cameras.all())
        mine = [one for one in found if not is_allowed(parts.authorize, session, Permission.WATCH, one["robot"])]
        return {"cameras": [one for one in mine if robot in ("", one["robot"])]}

    @router.post("/{robot_id}/{camera}/whep", summary="WebRTC by WHEP: an SDP offer in, an SDP answer out")
    async def whep(
        robot_id: RobotId, camera: CameraId, request: Request, session: SignedIn, watcher: WatcherToken = ""
    ) -> Response:
        """Answer an offer for the page whose socket has this token; errors as in docs/protocols/cameras.md."""
        parts.authorize(session, Permission.WATCH, robot_id)
        if request.headers.get("content-type", "").partition(";")[0].strip() != "application/sdp":
            raise ApiError(415, "invalid", "Send the offer as application/sdp.")
        path = f"/cameras/{robot_id}/{camera}/whep"
        return await _passed_on(parts, session, "POST", path, await request.body(), watcher)

    @router.delete("/sessions/{session_id}", status_code=204, summary="End a WebRTC stream")
    async def end(
        session_id: Annotated[str, Path(pattern=r"^[A-Za-z0-9_-]{8,64}\z")],
        session: SignedIn,
        watcher: WatcherToken = "",
    ) -> Response:
        """End a stream of the page it was opened by; ``404`` for any other."""
        return await _passed_on(parts, session, "DELETE", f"/sessions/{session_id}", None, watcher)

    @router.get("/{robot_id}/{camera}/still", summary="Newest picture as JPEG")
    async def still(
        robot_id: RobotId,
        camera: CameraId,
        session: SignedIn,
        fresh_s: Annotated[float | None, Query(ge=0.1, le=3600, description="at most this old, s")] = None,
    ) -> Response:
        """Return a JPEG and when it was taken (ms, monotonic clock); ``404 no_picture`` says why there is none."""
        parts.authorize(session, Permission.WATCH, robot_id)
        query = "" if fresh_s is None else f"?fresh_s={fresh_s}"
        answer = await _passed_on(parts, session, "GET", f"/cameras/{robot_id}/{camera}/still{query}")
        if parts.stamp is None or answer.status_code != 200:
            return answer
        kept = {name: answer.headers[name] for name in (*PICTURE_HEADERS, "cache-control") if name in answer.headers}
        return Response(await parts.stamp(session, bytes(answer.body)), 200, kept, "image/jpeg")

    @router.get("/{robot_id}/{camera}/control", summary="How its robot says a camera is set; null is not known")
    async def setting(robot_id: RobotId, camera: CameraId, session: SignedIn) -> dict[str, Any]:
        """Return lamp and zoom (times) as the robot tells them; ``504 no_answer`` if it says nothing."""
        parts.authorize(session, Permission.WATCH, robot_id)
        try:
            found = await parts.cameras.setting(robot_id, camera)
        except ControlFailed as failed:
            raise _not_done(failed) from failed
        return {"lamp": found.lamp, "zoom": found.zoom}


def _add_acting(router: APIRouter, parts: CameraRoutes) -> None:
    @router.post("/{robot_id}/{camera}/restart", status_code=202, summary="Open the source of a camera anew")
    async def restart(robot_id: RobotId, camera: CameraId, session: SignedIn) -> Response:
        """Let go of what is open and open it again, now; it is no failure and is not counted."""
        parts.authorize(session, Permission.RESTART_CAMERA, None if robot_id == FIELD_ROBOT else robot_id)
        answer = await _passed_on(parts, session, "POST", f"/cameras/{robot_id}/{camera}/restart")
        if answer.status_code == 202:
            _note(parts, session, robot_id, "restarted", f"opened camera {camera} anew")
        return answer

    @router.post("/{robot_id}/{camera}/control", status_code=204, summary="Lamp, zoom or trigger of a robot's camera")
    async def control(robot_id: RobotId, camera: CameraId, body: CameraControlBody, session: SignedIn) -> Response:
        """Pass one order on for who controls the robot; ``409`` without control, while off, or as the robot says."""
        parts.authorize(session, Permission.LEASE, robot_id)
        if not parts.holds(session.session_id, robot_id):
            raise ApiError(409, "no_lease", "Take control of the robot first.")
        if why := parts.obstacle(robot_id):
            raise ApiError(409, "function_off", why)
        order = body.model_dump(exclude_none=True)
        try:
            await parts.cameras.control(robot_id, camera, order)
        except ControlFailed as failed:
            raise _not_done(failed) from failed
        what = ", ".join(f"{key} {value}" for key, value in order.items())
        _note(parts, session, robot_id, "done", f"camera {camera}: {what}")
        return Response(status_code=204)


def _not_done(failed: ControlFailed) -> ApiError:
    return ApiError(CONTROL_STATUS.get(failed.code, 409), failed.code, failed.text)


async def _passed_on(
    parts: CameraRoutes,
    session: SessionInfo,
    method: str,
    path: str,
    body: bytes | None = None,
    watcher: str = "",
) -> Response:
    answer = await _away_is_503(parts.cameras.ask(session, method, path, body, watcher))
    headers = {**answer.headers, "cache-control": "no-store"}
    return Response(answer.body, answer.status, headers, answer.media_type or None)


async def _away_is_503(asked: Any) -> Any:
    try:
        return await asked
    except CamerasAway as away:
        text = "The camera process is not running. It comes back by itself; try again in a moment."
        raise ApiError(503, "cameras_down", text) from away


def _note(parts: CameraRoutes, session: SessionInfo, robot_id: str, outcome: str, text: str) -> None:
    known_as = None if robot_id == FIELD_ROBOT else robot_id
    parts.audit.append(audit_line(session, "camera", outcome, text, ref=robot_id, robot_id=known_as))

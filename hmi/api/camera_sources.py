"""Where cameras' pictures come from, and the frames that field cameras send; see docs/cameras.md."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Request
from pydantic import Field
from starlette.responses import JSONResponse

from hmi.api.access import SignedIn, bearer
from hmi.api.body import Body, Line, Name, Secret
from hmi.api.errors import ApiError, answer
from hmi.api.pictures import CameraId, CameraRobot
from hmi.commands.camera_source_book import CameraSourceBook, SourceWish
from hmi.commands.field_frames import FieldFrames, FrameRefused
from hmi.domain.camera import SourceKind
from hmi.domain.camera_source import FIELD, URL_CHARS, SourceRefused
from hmi.domain.picture_header import BadPicture
from hmi.security.session_info import SessionInfo
from hmi.store.camera_sources import StoredSource

STATUS = {"bad_token": 401, "too_often": 429}
FieldCamera = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}\z")]


class SourceBody(Body):
    """Where a camera's pictures come from.

    The password is never shown; left out it stays as it is, as long as it goes to the same host, and an empty one
    removes it. ``new_token`` makes an upload a new token; the old one ends.
    """

    kind: Literal["rtsp", "whep", "mjpeg", "snapshot", "upload"]
    url: Annotated[str, Field(max_length=URL_CHARS)] = ""
    user: Annotated[Line, Field(max_length=80)] = ""
    password: Secret | None = None
    label: Name | None = None
    period_s: Annotated[float, Field(ge=0.5, le=86_400)] | None = None
    keep_every_s: Annotated[float, Field(ge=0, le=86_400)] | None = None
    new_token: bool = False


def camera_source_routes(book: CameraSourceBook) -> APIRouter:
    """Return the routes of sources."""
    router = APIRouter(tags=["cameras"])

    @router.get("/cameras/sources", summary="Every camera whose pictures do not come from its robot")
    async def every(session: SignedIn) -> dict[str, Any]:
        """Return them by robot and camera; passwords are never among it."""
        return {"sources": [source_json(one, book) for one in book.all(session)]}

    @router.get("/cameras/{robot}/{camera}/source", summary="Where its pictures come from; no password is shown")
    async def get(robot: CameraRobot, camera: CameraId, session: SignedIn) -> dict[str, Any]:
        """Return what is set, or that it is its robot; ``404`` for a field camera that is not there."""
        one = book.get(session, robot, camera)
        return source_json(one, book) if one is not None else _robot_json(robot, camera, book)

    @router.put("/cameras/{robot}/{camera}/source", summary="Set it; an upload's token is shown this once")
    async def put(robot: CameraRobot, camera: CameraId, body: SourceBody, session: SignedIn) -> dict[str, Any]:
        """Set it from now on; an address that is not used is refused in words, and nothing changes."""
        made, token = await _put(book, session, robot, camera, body)
        shown = source_json(made, book)
        return {**shown, "token": token} if token else shown

    @router.delete("/cameras/{robot}/{camera}/source", status_code=204, summary="From the robot again")
    async def remove(robot: CameraRobot, camera: CameraId, session: SignedIn) -> None:
        """Take pictures from the robot again, or forget a field camera; ``404`` if nothing was set."""
        await book.remove(session, robot, camera)

    @router.post("/cameras/{robot}/{camera}/source/test", summary="Ask for one picture; says what is in the way")
    async def test(robot: CameraRobot, camera: CameraId, session: SignedIn) -> dict[str, Any]:
        """Return whether a picture came, in a sentence, and after how many ms; takes up to 12 s."""
        told = await book.test(session, robot, camera)
        size = {"width_px": told.width_px, "height_px": told.height_px} if told.width_px else {}
        return {"ok": told.is_ok, "text": told.text, "ms": round(told.took_s * 1000), **size}

    return router


def field_frame_routes(frames: FieldFrames) -> APIRouter:
    """Return the route that field cameras send to."""
    router = APIRouter(tags=["cameras"])

    @router.post(
        "/cameras/field/{name}/frame",
        status_code=204,
        response_model=None,
        summary="Send a frame, JPEG or PNG, with the camera's token as Bearer; X-Age-Ms tells how old it is",
    )
    async def frame(name: FieldCamera, request: Request) -> JSONResponse | None:
        """Take a frame of the camera that shows its token; ``401``, ``422``, and ``429`` with when to try again."""
        try:
            one = frames.admit(name, bearer(request))
            await frames.take(one, await request.body(), _age_s(request))
            return None
        except FrameRefused as error:
            return _refused(error)
        except BadPicture as error:
            raise ApiError(422, error.code, error.text) from error

    return router


def source_json(one: StoredSource, book: CameraSourceBook) -> dict[str, Any]:
    """Return one source as an admin may see it."""
    sent = one.kind is SourceKind.UPLOAD
    known = book.source_of(one.robot_id, one.camera)
    return {
        "robot": one.robot_id,
        "camera": one.camera,
        "kind": one.kind.value,
        "label": one.label,
        "url": one.url,
        "user": one.user_name,
        "has_password": bool(one.sealed),
        "is_password_lost": bool(one.sealed) and (known is None or not known.password),
        "has_token": bool(one.token_sha256),
        "upload": f"/api/v1/cameras/{one.robot_id}/{one.camera}/frame" if sent else None,
        "period_s": one.period_s,
        "keep_every_s": one.keep_every_s,
        "width_px": one.width_px or None,
        "height_px": one.height_px or None,
        "changed_by": one.changed_by,
        "changed_utc": one.changed_at.isoformat(timespec="milliseconds"),
        "allowed": _allowed(one.robot_id, book),
    }


def _robot_json(robot: str, camera: str, book: CameraSourceBook) -> dict[str, Any]:
    if robot == FIELD:
        raise ApiError(404, "unknown_camera", "There is no field camera of this name.")
    return {"robot": robot, "camera": camera, "kind": "robot", "has_password": False, "allowed": _allowed(robot, book)}


def _allowed(robot: str, book: CameraSourceBook) -> dict[str, Any]:
    reach = book.reach(robot)
    return {
        "networks": [str(one) for one in reach.networks],
        "hosts": sorted(reach.hosts),
        "this_machine": reach.is_loopback_allowed,
    }


async def _put(
    book: CameraSourceBook, session: SessionInfo, robot: str, camera: str, body: SourceBody
) -> tuple[StoredSource, str]:
    wish = SourceWish(
        SourceKind(body.kind), body.url.strip(), body.user.strip(), body.password, body.label, body.period_s,
        body.keep_every_s, is_new_token=body.new_token,
    )  # fmt: skip
    try:
        return await book.put(session, robot, camera, wish)
    except SourceRefused as error:
        field = "kind" if error.code in ("kind", "too_many") else "url"
        raise ApiError(422, error.code, error.text, field) from error


def _age_s(request: Request) -> float | None:
    try:
        age_s = float(request.headers.get("x-age-ms", "")) / 1000.0
    except ValueError:
        return None
    return age_s if math.isfinite(age_s) and age_s >= 0 else None


def _refused(error: FrameRefused) -> JSONResponse:
    headers = {"Retry-After": str(max(1, math.ceil(error.retry_after_s)))} if error.retry_after_s else None
    return answer(STATUS[error.code], error.code, error.text, headers=headers)

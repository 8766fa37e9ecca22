"""The control port of the camera process: loopback, secret in every request, spoken to by the console only."""

from __future__ import annotations

import os
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp

from hmi.cameras.camera import Camera
from hmi.cameras.clip import ClipFailed, write_clip
from hmi.cameras.door import CAPTURED_HEADER, DATED_HEADER, SECRET_HEADER, SEQ_HEADER, VIEWER_HEADER, WATCHER_HEADER
from hmi.cameras.hub import Hub
from hmi.cameras.jpeg_header import MAX_BYTES, BadPicture
from hmi.cameras.page_socket import PageSockets
from hmi.cameras.picture_wire import Piece
from hmi.cameras.ring import Rings, Span
from hmi.cameras.whep import MAX_OFFER_BYTES, WhepDesk, WhepRefused
from hmi.clock import Clock
from hmi.domain.camera import Recording, Source
from hmi.side_server import SecretDoor

Handler = Callable[[Request], Awaitable[Response]]
CameraHandler = Callable[[Request, Camera], Awaitable[Response]]


@dataclass(frozen=True, slots=True)
class CameraParts:
    """What the control port speaks for."""

    hub: Hub
    pages: PageSockets
    whep: WhepDesk
    rings: Rings
    clock: Clock
    data: Path


class SourceList(msgspec.Struct, frozen=True):
    """Body of ``PUT /sources``."""

    sources: list[Source]


class RecordingList(msgspec.Struct, frozen=True):
    """Body of ``PUT /recording``."""

    cameras: list[Recording]


class ClipWish(msgspec.Struct, frozen=True):
    """Body of ``POST /clips``."""

    robot: str
    camera: str
    path: str
    from_m: float = msgspec.field(name="from")
    to_m: float = msgspec.field(name="to")


def control_app(parts: CameraParts, secret: str) -> ASGIApp:
    """Return the application; without the secret it answers nothing but 403."""
    one = "/cameras/{robot}/{camera}"
    routes = [
        WebSocketRoute("/live", parts.pages.serve),
        Route("/status", _status(parts)),
        Route("/sources", _put_sources(parts), methods=["PUT"]),
        Route("/cameras", _list(parts)),
        Route(f"{one}/still", _on_camera(parts, _still(parts))),
        Route(f"{one}/whep", _on_camera(parts, _whep(parts)), methods=["POST"]),
        Route(f"{one}/restart", _on_camera(parts, _restart), methods=["POST"]),
        Route(f"{one}/frame", _on_camera(parts, _frame(parts)), methods=["POST"]),
        Route(f"{one}/kept", _kept(parts)),
        Route("/recording", _put_recording(parts), methods=["PUT"]),
        Route("/clips", _clip(parts), methods=["POST"]),
        Route("/sessions/{id}", _end_session(parts), methods=["DELETE"]),
    ]
    return SecretDoor(Starlette(routes=routes), SECRET_HEADER, secret)


def refused(status: int, code: str, text: str) -> Response:
    """Return an error in the one shape."""
    return JSONResponse({"code": code, "text": text, "field": None}, status)


def encoded(value: Any, status: int = 200) -> Response:
    """Return a value as JSON."""
    return Response(msgspec.json.encode(value), status, media_type="application/json")


def picture(piece: Piece | None, reason: str = "") -> Response:
    """Return a JPEG with when it was taken, or when it came where its camera tells no time.

    ``reason`` says why there may be none.
    """
    if piece is None:
        text = f"No picture came: {reason.removesuffix('.')}." if reason else "This camera has not sent a picture yet."
        return refused(404, "no_picture", text)
    headers = {
        CAPTURED_HEADER: f"{piece.captured_ms:.1f}",
        DATED_HEADER: "1" if piece.is_dated else "0",
        SEQ_HEADER: str(piece.seq),
    }
    return Response(piece.data, media_type="image/jpeg", headers=headers)


def _on_camera(parts: CameraParts, handler: CameraHandler) -> Handler:
    async def handle(request: Request) -> Response:
        """Find the camera that is asked for; ``404`` if there is none."""
        camera = parts.hub.get(request.path_params["robot"], request.path_params["camera"])
        if camera is None:
            return refused(404, "unknown_camera", "There is no such camera.")
        return await handler(request, camera)

    return handle


def _status(parts: CameraParts) -> Handler:
    async def status(_request: Request) -> Response:
        """Count what is open; workers by camera with their process id."""
        cameras = parts.hub.cameras.values()
        return encoded({
            "pid": os.getpid(),
            "cameras": len(cameras),
            "workers": {one.source.name: one.worker_pid for one in cameras if one.worker_pid is not None},
            "sessions": len(parts.whep.sessions),
            "watchers": len(parts.pages.pages),
            "rings": len(parts.rings),
        })  # fmt: skip

    return status


def _put_sources(parts: CameraParts) -> Handler:
    async def put(request: Request) -> Response:
        """Take the whole list of sources, and let go of everything that is no longer in it; ``422`` for no list."""
        try:
            body = msgspec.json.decode(await request.body(), type=SourceList)
        except msgspec.MsgspecError as error:
            return refused(422, "invalid", str(error))
        for camera in await parts.hub.set_sources(body.sources):
            await parts.whep.end_camera(camera)
            for page in list(parts.pages.pages.values()):
                page.forget(camera)
        parts.rings.match(parts.hub.cameras)
        return Response(status_code=204)

    return put


def _list(parts: CameraParts) -> Handler:
    async def cameras(_request: Request) -> Response:
        """Return every camera as ``Camera`` of the protocol."""
        return encoded({"cameras": parts.hub.describe()})

    return cameras


def _still(parts: CameraParts) -> CameraHandler:
    async def still(request: Request, camera: Camera) -> Response:
        """Return the newest JPEG, or look for one of at most ``fresh_s`` seconds; see ``Hub.still``."""
        try:
            said = request.query_params.get("fresh_s")
            fresh_s = None if said is None else float(said)
        except ValueError:
            return refused(422, "invalid", "fresh_s must be a number.")
        is_full = request.query_params.get("full") == "true"
        return picture(await parts.hub.still(camera, fresh_s, is_full=is_full), camera.reason)

    return still


def _whep(parts: CameraParts) -> CameraHandler:
    async def whep(request: Request, camera: Camera) -> Response:
        """Answer an offer of a page whose socket is open; ``403`` without one, else as ``WhepRefused`` says."""
        page = parts.pages.of(request.headers.get(WATCHER_HEADER, ""), request.headers.get(VIEWER_HEADER, ""))
        if page is None:
            return refused(403, "not_allowed", "Open the socket of the page first.")
        offer = await request.body()
        if len(offer) > MAX_OFFER_BYTES:
            return refused(413, "too_large", "This offer is too long.")
        try:
            session, answer = await parts.whep.open(page, camera, offer.decode("utf-8", "replace"))
        except WhepRefused as no:
            return refused(no.status, no.code, no.text)
        return Response(answer, 201, {"Location": f"/sessions/{session}"}, "application/sdp")

    return whep


def _end_session(parts: CameraParts) -> Handler:
    async def end(request: Request) -> Response:
        """End a stream for the page that has it; one that has ended already is no error."""
        session = parts.whep.sessions.get(request.path_params["id"])
        page = parts.pages.of(request.headers.get(WATCHER_HEADER, ""), request.headers.get(VIEWER_HEADER, ""))
        if page is None or (session is not None and session.page is not page):
            return refused(404, "not_found", "There is no such session.")
        if session is not None:  # else the goodbye of its own connection was quicker
            await session.end()
        return Response(status_code=204)

    return end


async def _restart(_request: Request, camera: Camera) -> Response:
    camera.restart()
    return encoded({}, 202)


def _frame(parts: CameraParts) -> CameraHandler:
    async def frame(request: Request, camera: Camera) -> Response:
        """Take a JPEG that is ``age_ms`` old; ``413`` and ``422`` for what cannot be shown."""
        data = bytearray()
        async for piece in request.stream():
            data += piece
            if len(data) > MAX_BYTES:
                return refused(413, "too_large", f"A picture has at most {MAX_BYTES // 1024 // 1024} MB.")
        try:
            parts.hub.upload(camera, bytes(data), float(request.query_params.get("age_ms", "0")))
        except BadPicture as error:
            return refused(422, "bad_picture", f"This cannot be shown: {error}.")
        except ValueError:
            return refused(422, "invalid", "age_ms must be a number.")
        return Response(status_code=204)

    return frame


def _put_recording(parts: CameraParts) -> Handler:
    async def put(request: Request) -> Response:
        """Take the whole list of cameras that keep their last minute; ``422`` for no list."""
        try:
            body = msgspec.json.decode(await request.body(), type=RecordingList)
        except msgspec.MsgspecError as error:
            return refused(422, "invalid", str(error))
        parts.rings.set(body.cameras, parts.hub.cameras)
        return Response(status_code=204)

    return put


def _kept(parts: CameraParts) -> Handler:
    async def kept(request: Request) -> Response:
        """Return the kept JPEG nearest to ``at`` (ms, monotonic clock); ``404`` if nothing is kept."""
        ring = parts.rings.of(request.path_params["robot"], request.path_params["camera"])
        try:
            at_ms = float(request.query_params["at"])
        except (KeyError, ValueError):
            return refused(422, "invalid", "at must be a number.")
        return picture(None if ring is None else ring.stills.nearest(at_ms))

    return kept


def _clip(parts: CameraParts) -> Handler:
    async def clip(request: Request) -> Response:
        """Write what was kept of a span (ms, monotonic clock) to a file; errors as in docs/protocols/cameras.md."""
        try:
            wish = msgspec.json.decode(await request.body(), type=ClipWish)
        except msgspec.MsgspecError as error:
            return refused(422, "invalid", str(error))
        if parts.hub.get(wish.robot, wish.camera) is None:
            return refused(404, "unknown_camera", "There is no such camera.")
        ring = parts.rings.of(wish.robot, wish.camera)
        span = Span([]) if ring is None else ring.video.between(wish.from_m, wish.to_m)
        if not span.pieces:
            return refused(409, "nothing_kept", "Nothing of this time was kept.")
        try:
            return encoded(await write_clip(span, Path(wish.path), parts.data), 201)
        except ClipFailed as failed:
            return refused(failed.status, failed.code, failed.text)

    return clip

"""The control port of the media process: loopback, secret in every request, spoken to by the console only."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
from collections.abc import Awaitable, Callable
from typing import Any

import msgspec
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from hmi.domain.picture_header import BadPicture
from hmi.media.camera_pictures import MAX_BYTES, small, wanted
from hmi.media.door import CAPTURED_HEADER, RIGHTS_HEADER, SECRET_HEADER, VIEWER_HEADER
from hmi.media.models import ModelShelf
from hmi.media.orders import BadOrder, decode_order
from hmi.media.studio import Studio
from hmi.side_server import SecretDoor
from hmi.twin.errors import ModelError, UnsafeModel
from hmi.twin.farm import Farm, Last, Plan

REPLAY_RIGHT = "replay"
MAX_PLAN_BYTES = 16 * 1024 * 1024
log = logging.getLogger(__name__)


def control_app(studio: Studio, shelf: ModelShelf, secret: str) -> ASGIApp:
    """Return the application; without the secret it answers nothing but 403."""
    routes = [
        WebSocketRoute("/viewer", lambda socket: _serve_viewer(studio, socket)),
        Route("/status", _status(studio)),
        Route("/farm", _put_farm(studio), methods=["PUT"]),
        Route("/plans/{robot}", _put_plan(studio), methods=["PUT"]),
        Route("/last", _put_last(studio), methods=["PUT"]),
        Route("/pictures/{robot}/{camera}", _put_picture(studio), methods=["PUT"]),
        Route("/models/{robot}", _model(shelf), methods=["GET", "PUT", "DELETE"]),
    ]
    return SecretDoor(Starlette(routes=routes), SECRET_HEADER, secret)


async def _serve_viewer(studio: Studio, socket: WebSocket) -> None:
    key, robot_id = socket.headers.get(VIEWER_HEADER, ""), socket.query_params.get("robot", "")
    rights = socket.headers.get(RIGHTS_HEADER, "").split()
    await socket.accept()
    box = studio.enter(key, robot_id, may_replay=REPLAY_RIGHT in rights)
    tasks = [
        asyncio.create_task(_tell(socket, box), name="viewer-tell"),
        asyncio.create_task(_hear(studio, key, socket), name="viewer-hear"),
    ]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        studio.leave(key, box)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _tell(socket: WebSocket, box: asyncio.Queue[dict[str, Any]]) -> None:
    while True:
        await socket.send_text(msgspec.json.encode(await box.get()).decode())


async def _hear(studio: Studio, key: str, socket: WebSocket) -> None:
    with contextlib.suppress(WebSocketDisconnect):
        while True:
            try:
                studio.obey(key, decode_order(await socket.receive_text()))
            except BadOrder as error:  # closed, the page would come back and say it again
                log.debug("an order of a page is ignored: %s", error)


Handler = Callable[[Request], Awaitable[Response]]


def _status(studio: Studio) -> Handler:
    async def status(_request: Request) -> Response:
        return JSONResponse({
            "pid": os.getpid(),
            "viewers": len(studio.viewers),
            "pictures": sum(1 for viewer in studio.viewers.values() if viewer.client is not None),
            "robots": len(studio.world.robots()),
            "messages": studio.intake.messages,
            "wanted": wanted(studio),
        })  # fmt: skip

    return status


def _put_farm(studio: Studio) -> Handler:
    async def put(request: Request) -> Response:
        studio.set_farm(msgspec.json.decode(await request.body(), type=Farm))
        return Response(status_code=204)

    return put


def _put_plan(studio: Studio) -> Handler:
    async def put(request: Request) -> Response:
        studio.set_plan(request.path_params["robot"], msgspec.json.decode(await request.body(), type=Plan))
        return Response(status_code=204)

    return put


def _put_last(studio: Studio) -> Handler:
    async def put(request: Request) -> Response:
        studio.set_last(msgspec.json.decode(await request.body(), type=dict[str, Last]))
        return Response(status_code=204)

    return put


def _put_picture(studio: Studio) -> Handler:
    async def put(request: Request) -> Response:
        try:
            captured_s = float(request.headers.get(CAPTURED_HEADER, ""))
            data = await request.body()
            if len(data) > MAX_BYTES:
                raise BadPicture("too_large", "This picture is larger than 4 MB.")
            pixels = await asyncio.to_thread(small, data)
        except ValueError as error:  # a BadPicture, or no time
            return JSONResponse({"code": "bad_picture", "text": str(error)}, status_code=422)
        site = studio.site(request.path_params["robot"])
        if site is not None:
            site.frusta.picture(request.path_params["camera"], pixels, captured_s)
        return Response(status_code=204)

    return put


def _model(shelf: ModelShelf) -> Handler:
    async def model(request: Request) -> Response:
        robot_id = request.path_params["robot"]
        try:
            if request.method == "PUT":
                return JSONResponse(await shelf.take(robot_id, request.stream()))
            if request.method == "DELETE":
                return JSONResponse({"removed": await shelf.remove(robot_id)})
            return JSONResponse(await shelf.describe(robot_id))
        except ModelError as error:
            code = "unsafe_model" if isinstance(error, UnsafeModel) else "bad_model"
            return JSONResponse({"code": code, "text": str(error)}, status_code=422)

    return model

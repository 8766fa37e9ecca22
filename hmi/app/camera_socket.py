"""The websocket ``/cameras/live`` of a page, passed on to the camera process behind session, Origin and rights."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
from collections.abc import Callable

import msgspec
from starlette.routing import BaseRoute, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from hmi.app.camera_link import CameraLink, CamerasDown
from hmi.app.socket_passage import pass_out
from hmi.domain.role import Permission
from hmi.live.lane import SessionGate
from hmi.security.authorization import Authorize, is_allowed
from hmi.security.session_info import SessionInfo

log = logging.getLogger(__name__)
SIGNED_OUT, REFUSED, AWAY, TOO_MANY = 4401, 4400, 4503, 4429  # close codes
MOST_PAGES = 150
MAX_IN_BYTES = 4096
CHECK_S = 1.0  # a session that ended closes its pictures within this
PATH = "/cameras/live"
BYES = {
    4400: ("bad_frame", "This page sent what is no frame."),
    4408: ("silent", "This page said nothing for a while; what it watched was let go."),
    TOO_MANY: ("full", "Too many pages show cameras on this server."),
}
OriginRule = Callable[[str | None, str | None], bool]
OnLook = Callable[[], contextlib.AbstractAsyncContextManager[None]]


class CameraSockets:
    """The socket's route. ``on_look`` is entered for each page, before the camera process hears of it."""

    def __init__(
        self, link: CameraLink, gate: SessionGate, authorize: Authorize, origins: OriginRule, on_look: OnLook
    ) -> None:
        self._link, self._gate, self._authorize, self._origins = link, gate, authorize, origins
        self._on_look = on_look
        self._open = 0

    def routes(self) -> list[BaseRoute]:
        """Return the route."""
        return [WebSocketRoute(PATH, self._serve, name="cameras-live")]

    async def _serve(self, socket: WebSocket) -> None:
        if not self._origins(socket.headers.get("origin"), socket.headers.get("host")):
            await socket.close(REFUSED)  # before accepting: the browser sees a refused handshake
            return
        session = self._gate.of_headers(socket.scope["headers"])
        if session is None or is_allowed(self._authorize, session, Permission.WATCH, None):
            await _farewell(socket, "signed_out", "Sign in again.", SIGNED_OUT)
            return
        if self._open >= MOST_PAGES:
            await _farewell(socket, "full", "Too many pages show cameras on this server.", TOO_MANY)
            return
        try:
            async with self._on_look():
                inner = await self._link.live(viewer_of(session))
                await socket.accept()
                await self._pass_on(socket, inner, session)
        except CamerasDown as down:
            log.info("the camera process is not there: %s", down)
            await _farewell(socket, "cameras_down", "The camera process is not running.", AWAY)

    async def _pass_on(self, socket: WebSocket, inner: ClientConnection, session: SessionInfo) -> None:
        self._open += 1
        tasks = [
            asyncio.create_task(pass_out(inner, socket), name="cameras-out"),
            asyncio.create_task(self._in(socket, inner, session), name="cameras-in"),
            asyncio.create_task(self._while_signed_in(session), name="cameras-session"),
        ]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            is_signed_out = tasks[2].done()
        finally:
            self._open -= 1
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await inner.close()
        if is_signed_out:
            await _say_bye(socket, "signed_out", "Your session has ended.", SIGNED_OUT)
        elif inner.close_code in BYES:
            await _say_bye(socket, *BYES[inner.close_code], inner.close_code)
        else:
            await _say_bye(socket, "cameras_down", "The camera process is not running.", AWAY)

    async def _in(self, socket: WebSocket, inner: ClientConnection, session: SessionInfo) -> None:
        with contextlib.suppress(ConnectionClosed, WebSocketDisconnect, RuntimeError):
            while True:
                message = await socket.receive()
                text = message.get("text")
                if message["type"] == "websocket.disconnect" or text is None or len(text) > MAX_IN_BYTES:
                    return
                refusal = self._refusal(text, session)
                if refusal is None:
                    await inner.send(text)
                else:
                    await socket.send_text(refusal)

    def _refusal(self, text: str, session: SessionInfo) -> str | None:
        """Return what to answer instead of passing a frame on: rights are judged here, for each camera."""
        try:
            frame = msgspec.json.decode(text)
        except msgspec.DecodeError:
            return _refused(0, "bad_frame", "This is no frame.")
        if not isinstance(frame, dict) or frame.get("k") != "watch":
            return None
        no = is_allowed(self._authorize, session, Permission.WATCH, str(frame.get("robot")))
        return _refused(frame.get("n"), "not_allowed", no) if no else None

    async def _while_signed_in(self, session: SessionInfo) -> None:
        while self._gate.get(session.session_id) is not None:  # noqa: ASYNC110 - looked up in memory, once a second
            await asyncio.sleep(CHECK_S)


def viewer_of(session: SessionInfo) -> str:
    """Return what names a session to the camera process; it opens nothing."""
    return hashlib.sha256(f"cameras {session.session_id}".encode()).hexdigest()[:32]


def _refused(n: object, code: str, text: str) -> str:
    return msgspec.json.encode({"k": "refused", "n": n, "code": code, "text": text}).decode()


async def _farewell(socket: WebSocket, code: str, text: str, close_code: int) -> None:
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):
        await socket.accept()
    await _say_bye(socket, code, text, close_code)


async def _say_bye(socket: WebSocket, code: str, text: str, close_code: int) -> None:
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):  # it left first
        await socket.send_text(msgspec.json.encode({"k": "bye", "code": code, "text": text}).decode())
        await socket.close(close_code)

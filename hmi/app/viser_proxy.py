"""Two websockets of a page, passed on to the media process behind session and Origin checks.

``/viser`` is viser's own: only where the camera is and what was touched goes in. ``/viser/control`` is the page's.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
import re
from collections.abc import Callable

import msgspec
from starlette.routing import WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from hmi.app.media_link import MediaDown, MediaLink
from hmi.app.socket_passage import pass_out
from hmi.domain.ids import is_id
from hmi.domain.role import Permission, may
from hmi.live.lane import SessionGate
from hmi.security.authorization import Authorize, is_allowed
from hmi.security.session_info import SessionInfo

log = logging.getLogger(__name__)
SIGNED_OUT, REFUSED, AWAY, TOO_MANY = 4401, 4400, 4503, 4429  # close codes
MOST_PICTURES = 100
MAX_IN_BYTES = 64 * 1024  # the largest order is a moment with all that a robot may say of its joints
CHECK_S = 1.0  # a session that ended closes its pictures within this
SAID_BY_VIEWERS = frozenset({"ViewerCameraMessage", "ScenePointerMessage"})
_KEY = re.compile(r"[0-9a-f]{16,64}")
OriginRule = Callable[[str | None, str | None], bool]
Passes = Callable[[str | bytes], bool]


class TwinSockets:
    """The sockets' routes. ``on_look(robot_id)`` is told of every page that opens, before its picture."""

    def __init__(
        self,
        link: MediaLink,
        gate: SessionGate,
        authorize: Authorize,
        origins: OriginRule,
        on_look: Callable[[str], contextlib.AbstractAsyncContextManager[None]],
    ) -> None:
        self._link, self._gate, self._authorize, self._origins = link, gate, authorize, origins
        self._on_look = on_look
        self._open = 0

    def routes(self) -> list[WebSocketRoute]:
        """Return the routes."""
        return [WebSocketRoute("/viser", self._picture), WebSocketRoute("/viser/control", self._control)]

    async def _picture(self, socket: WebSocket) -> None:
        session = await self._admit(socket)
        if session is None:
            return
        protocols = [str(one) for one in socket.scope.get("subprotocols", [])]
        try:
            inner = await self._link.viser(_viewer(session, socket), protocols)
        except MediaDown as down:
            await _away(socket, down)
            return
        await socket.accept(subprotocol=inner.subprotocol)
        await self._pass_on(socket, inner, session, _is_look)

    async def _control(self, socket: WebSocket) -> None:
        session = await self._admit(socket)
        if session is None:
            return
        robot_id = socket.query_params.get("robot", "")
        if not is_id(robot_id) or is_allowed(self._authorize, session, Permission.WATCH, robot_id):
            await socket.close(REFUSED)
            return
        rights = "replay" if may(session.role, Permission.REPLAY) else ""
        try:
            async with self._on_look(robot_id):
                inner = await self._link.control(_viewer(session, socket), robot_id, rights)
                await socket.accept()
                await self._pass_on(socket, inner, session, lambda said: isinstance(said, str))
        except MediaDown as down:
            await _away(socket, down)

    async def _admit(self, socket: WebSocket) -> SessionInfo | None:
        """Judge a handshake; before accepting, so that the browser sees it refused."""
        if not self._origins(socket.headers.get("origin"), socket.headers.get("host")):
            await socket.close(REFUSED)
            return None
        session = self._gate.of_headers(socket.scope["headers"])
        if session is None or is_allowed(self._authorize, session, Permission.WATCH, None):
            await socket.close(SIGNED_OUT)
            return None
        if self._open >= MOST_PICTURES or not _KEY.fullmatch(socket.query_params.get("viewer", "")):
            await socket.close(TOO_MANY)
            return None
        return session

    async def _pass_on(self, socket: WebSocket, inner: ClientConnection, session: SessionInfo, passes: Passes) -> None:
        self._open += 1
        tasks = [
            asyncio.create_task(pass_out(inner, socket), name="twin-out"),
            asyncio.create_task(_in(socket, inner, passes), name="twin-in"),
            asyncio.create_task(self._while_signed_in(session), name="twin-session"),
        ]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            code = SIGNED_OUT if tasks[2].done() else AWAY
        finally:
            self._open -= 1
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await inner.close()
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):  # it left first
            await socket.close(code)

    async def _while_signed_in(self, session: SessionInfo) -> None:
        while self._gate.get(session.session_id) is not None:  # noqa: ASYNC110 - looked up in memory, once a second
            await asyncio.sleep(CHECK_S)


async def _in(socket: WebSocket, inner: ClientConnection, passes: Passes) -> None:
    with contextlib.suppress(ConnectionClosed, WebSocketDisconnect, RuntimeError):
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            text, data = message.get("text"), message.get("bytes")
            said = text if text is not None else data or b""
            if len(said) <= MAX_IN_BYTES and passes(said):
                await inner.send(said)


def _is_look(said: str | bytes) -> bool:
    """Say whether a frame to viser only looks; everything else it could do is not for browsers."""
    if isinstance(said, str):
        return False
    try:
        message = msgspec.msgpack.decode(said)
    except msgspec.DecodeError:
        return False
    return isinstance(message, dict) and message.get("type") in SAID_BY_VIEWERS


def _viewer(session: SessionInfo, socket: WebSocket) -> str:
    """Both sockets of a page have one key; another session cannot have the same."""
    own = hashlib.sha256(session.session_id.encode()).hexdigest()[:16]
    return f"{own}-{socket.query_params['viewer']}"


async def _away(socket: WebSocket, down: MediaDown) -> None:
    log.info("the media process is not there: %s", down)
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):
        await socket.accept()
        await socket.close(AWAY)

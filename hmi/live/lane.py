"""The raw websocket of one browser: who may open it, what it may send, and how it ends."""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections.abc import Callable, Collection, Iterable
from typing import Protocol
from urllib.parse import urlsplit

from starlette.routing import WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from hmi.clock import Clock
from hmi.live import frames
from hmi.live.hub import LiveHub
from hmi.live.outbox import Outbox
from hmi.security.session_info import SessionInfo

log = logging.getLogger(__name__)

SIGNED_OUT, REFUSED, TOO_MUCH, OVERRUN = 4401, 4400, 4429, 4408  # close codes
SEND_LIMIT_S = 10.0  # a browser that takes nothing for so long is gone
FRAMES_PER_S, FRAMES_BURST = 40.0, 120.0  # driving sends 10 a second, everything else 2
MAX_LANES = 500
SENT_IN_ONE_GO = 64  # then the others have their turn: a thousand robots may tell something at once
PATH = "/live"


class SessionGate(Protocol):
    """Who is signed in; ``hmi.security.sessions.Sessions`` is one."""

    def of_headers(self, headers: Iterable[tuple[bytes, bytes]]) -> SessionInfo | None:
        """Return whose session cookie these raw headers carry."""
        ...

    def get(self, session_id: str) -> SessionInfo | None:
        """Return a session that is still open."""
        ...


class OriginRule(Protocol):
    """Whether pages of an origin may open a lane."""

    def __call__(self, origin: str | None, host: str | None) -> bool:
        """Judge the ``Origin`` and ``Host`` headers of a handshake."""
        ...


OnClientFrame = Callable[[SessionInfo, str, frames.Here | frames.Drive | frames.Jog], None]
OnLaneEnd = Callable[[str], None]


def same_origin_or(allowed: Collection[str] = ()) -> OriginRule:
    """Allow the console's own pages and the origins named; a missing Origin is refused."""
    named = {o.rstrip("/").lower() for o in allowed}

    def judge(origin: str | None, host: str | None) -> bool:
        if not origin or origin == "null":
            return False
        return origin.lower() in named or (host is not None and urlsplit(origin).netloc.lower() == host.lower())

    return judge


def lane_route(
    hub: LiveHub,
    gate: SessionGate,
    origins: OriginRule,
    on_client_frame: OnClientFrame,
    clock: Clock,
    on_lane_end: OnLaneEnd = lambda _lane_id: None,
) -> WebSocketRoute:
    """Return the route of the live lane.

    Args:
        on_client_frame: called on the loop for each ``here``, ``drive`` and ``jog`` with session and id of the lane it
            came by; it judges tick, lease and rights, and must not block. What it raises is logged.
        on_lane_end: called with the id of a lane when it ended, however it ended.
    """

    async def open_lane(socket: WebSocket) -> None:
        if not origins(socket.headers.get("origin"), socket.headers.get("host")):
            await socket.close(REFUSED)  # before accepting: the browser sees a refused handshake
            return
        await socket.accept()
        session = gate.of_headers(socket.scope["headers"])
        if session is None:
            await _farewell(socket, "signed_out", "Sign in again.", SIGNED_OUT)
        elif hub.lanes >= MAX_LANES:
            await _farewell(socket, "full", "Too many pages are open on this server.", TOO_MUCH)
        else:
            lane = _Lane(socket, session, hub, gate, on_client_frame, clock)
            try:
                await lane.run()
            finally:
                on_lane_end(lane.id)

    return WebSocketRoute(PATH, open_lane, name="live-lane")


class _Lane:
    """One open lane: a reader, a writer, and the box between hub and writer."""

    def __init__(
        self,
        socket: WebSocket,
        session: SessionInfo,
        hub: LiveHub,
        gate: SessionGate,
        on_client_frame: OnClientFrame,
        clock: Clock,
    ) -> None:
        self.id = secrets.token_hex(8)
        self._socket, self._session, self._hub, self._gate = socket, session, hub, gate
        self._on_client_frame, self._clock = on_client_frame, clock
        self._box = Outbox(session.session_id, clock.mono_s)
        self._credit, self._credit_at_s = FRAMES_BURST, clock.mono_s()

    async def run(self) -> None:
        """Serve until the browser leaves, the session ends or the server stops."""
        self._box.event(self._hello())
        self._hub.attach(self._box)
        writer = asyncio.create_task(self._write(), name="lane-write")
        reader = asyncio.create_task(self._read(), name="lane-read")
        try:
            await asyncio.wait({writer, reader}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._hub.detach(self._box)
            for task in (writer, reader):
                task.cancel()
            for result in await asyncio.gather(writer, reader, return_exceptions=True):
                if isinstance(result, Exception) and not isinstance(result, WebSocketDisconnect | TimeoutError):
                    log.warning("a lane ended: %r", result)

    def _hello(self) -> str:
        s = self._session
        return frames.encode(
            {
                "k": "hello",
                "boot": self._hub.boot,
                "m": round(self._clock.mono_s() * 1000, 1),
                "user": {"id": s.user_id, "name": s.user_name, "role": s.role.value},
                "device": {"id": s.device_id, "name": s.device_name},
            }
        )

    async def _write(self) -> None:
        while True:
            await self._box.wait()
            async with asyncio.timeout(SEND_LIMIT_S):
                for number, frame in enumerate(self._box.take(self._hub.snapshot), 1):
                    if isinstance(frame, str):
                        await self._socket.send_text(frame)
                    else:
                        await self._socket.send_bytes(frame)
                    if number % SENT_IN_ONE_GO == 0:
                        await asyncio.sleep(0)
            if self._box.is_ended:
                await self._socket.close(SIGNED_OUT)
                return
            if self._box.is_overrun:
                await self._socket.close(OVERRUN)
                return

    async def _read(self) -> None:
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            if self._gate.get(self._session.session_id) is None:
                self._box.bye("signed_out", "Your session has ended.")  # the writer says it and closes
                continue
            if not self._may_send():
                continue
            try:
                self._handle(frames.decode_client(message.get("text") or message.get("bytes") or b""))
            except frames.BadFrame as error:
                log.info("a lane of %s sent no frame: %s", self._session.user_id, error)
                await self._socket.close(REFUSED)
                return

    def _handle(self, frame: frames.ClientFrame) -> None:
        match frame:
            case frames.Sub():
                self._hub.subscribe(self._box, frame.topics)
            case frames.Ping():
                if frame.m is not None:
                    self._box.seen(frame.m)
                self._box.event(frames.encode({"k": "pong", "n": frame.n, "m": round(self._clock.mono_s() * 1000, 1)}))
            case frames.Here() | frames.Drive() | frames.Jog():
                try:
                    self._on_client_frame(self._session, self.id, frame)
                except Exception:  # a fault in a handler must not cut the operator's live picture
                    log.exception("handling a %s frame failed", type(frame).__name__)

    def _may_send(self) -> bool:
        now_s = self._clock.mono_s()
        self._credit = min(FRAMES_BURST, self._credit + (now_s - self._credit_at_s) * FRAMES_PER_S)
        self._credit_at_s = now_s
        if self._credit < 1:
            return False  # dropped, like everything a lane cannot carry: the next setpoint is newer
        self._credit -= 1
        return True


async def _farewell(socket: WebSocket, code: str, text: str, close_code: int) -> None:
    try:
        await socket.send_text(frames.encode({"k": "bye", "code": code, "text": text}))
        if socket.client_state is WebSocketState.CONNECTED:
            await socket.close(close_code)
    except (WebSocketDisconnect, RuntimeError):  # it left before we could say so
        return

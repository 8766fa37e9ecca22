"""A robot as STOP sees it, over the real wire: MQTT and its own HTTP, with the faults a robot can have."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import socket
import time
from dataclasses import dataclass, field

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import decode_body, encode
from backend_clients.edge.mqtt import MqttLink
from backend_clients.edge.topics import Address, Down, Up, topic

DECEL_MPS2 = 2.0
STEP_S = 0.05


@dataclass
class FakeRobot:
    """Drives at ``speed_mps`` until stopped. Set the flags to make it misbehave.

    ``is_silent``: says and answers nothing. ``is_deaf``: acknowledges nothing, goes on talking.
    ``is_runaway``: acknowledges, latches, and goes on moving. ``ack_after_s``: answers late.
    ``is_mute``: its safety controller says nothing by MQTT while heartbeats go on; ``is_http_mute``: nor by HTTP.
    """

    id: str
    broker_url: str
    speed_mps: float = 0.5
    is_silent: bool = False
    is_deaf: bool = False
    is_runaway: bool = False
    is_mute: bool = False
    is_http_mute: bool = False
    ack_after_s: float = 0.0
    stops_by_mqtt: list[str] = field(default_factory=list)
    stops_by_http: list[str] = field(default_factory=list)
    presses: dict[str, up.Press] = field(default_factory=dict)
    was_reset: set[str] = field(default_factory=set)
    http_url: str = ""
    token: str = "robot-token"

    def __post_init__(self) -> None:
        self.boot = secrets.token_hex(8)
        self._seq = 0
        self._zero_since: float | None = None if self.speed_mps else time.monotonic() - 1
        self._tasks: list[asyncio.Task[None]] = []
        self._server: uvicorn.Server | None = None

    async def start(self) -> FakeRobot:
        """Connect to the broker and serve HTTP."""
        self._loop = asyncio.get_running_loop()
        self._link = MqttLink(
            self.broker_url,
            f"fake-{self.id}-{secrets.token_hex(4)}",
            subscriptions=[(topic(self.id, kind), 1) for kind in (Down.STOP, Down.STOP_RESET, Down.PING)],
            on_message=lambda name, data, _r: self._loop.call_soon_threadsafe(self._received, name, data),
        )
        self._link.start()
        listener = socket.socket()
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        self.http_url = f"http://127.0.0.1:{listener.getsockname()[1]}/{self.id}"
        routes = [
            Route(f"/{self.id}/stop", self._http_stop, methods=["POST"]),
            Route(f"/{self.id}/safety", self._http_safety),
        ]
        config = uvicorn.Config(Starlette(routes=routes), lifespan="off", log_config=None, timeout_graceful_shutdown=1)
        self._server = _QuietServer(config)
        self._tasks = [
            asyncio.create_task(self._server.serve(sockets=[listener])),
            asyncio.create_task(self._live()),
        ]
        return self

    async def close(self) -> None:
        """Switch it off."""
        if self._server is not None:
            self._server.should_exit = True
        self._tasks[1].cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await asyncio.to_thread(self._link.stop)

    def reset(self, stop_id: str) -> None:
        """Clear one press, as somebody with the right to would."""
        self.presses.pop(stop_id, None)
        self.was_reset.add(stop_id)
        self._say_safety()

    @property
    def is_latched(self) -> bool:
        return bool(self.presses)

    @property
    def is_standing(self) -> bool:
        return self._zero_since is not None and time.monotonic() - self._zero_since >= 0.5

    def safety(self) -> up.Safety:
        """Return what its safety controller says now."""
        return up.Safety(
            **self._header(),
            hardware_stop=False,
            latched=self.is_latched,
            standstill=self.is_standing,
            speed_mps=self.speed_mps,
            tool_off=True,
            presses=list(self.presses.values()),
            stopping_distance_m=0.31 if self.is_standing else None,
        )

    def latch(self, message: down.Stop) -> up.Ack:
        """Take a STOP and answer it."""
        if message.stop_id in self.was_reset:
            return self._ack(message, "rejected", "already_reset")
        if message.stop_id not in self.presses:
            self.presses[message.stop_id] = up.Press(
                stop_id=message.stop_id, by=message.by, device=message.device, mono_ms=_mono_ms()
            )
        return self._ack(message, "accepted", "ok")

    def _header(self) -> dict[str, object]:
        self._seq += 1
        return {"robot": self.id, "boot": self.boot, "seq": self._seq, "mono_ms": _mono_ms(), "wall_ms": 0}

    def _ack(self, message: down.Stop, outcome: str, code: str) -> up.Ack:
        return up.Ack(
            **self._header(), kind="stop", ref=message.stop_id, outcome=outcome, code=code, speed_mps=self.speed_mps
        )

    def _received(self, name: str, data: bytes) -> None:
        if self.is_silent:
            return
        kind = name.rsplit("/", 1)[1]
        if kind == Down.PING.value:
            message = decode_body(Address(self.id, Down.PING), data)
            self._say(Up.HEARTBEAT, self._heartbeat(message.nonce))
        elif kind == Down.STOP.value and not self.is_deaf:
            message = decode_body(Address(self.id, Down.STOP), data)
            self.stops_by_mqtt.append(message.stop_id)
            self._loop.call_later(self.ack_after_s, self._answer, message)

    def _answer(self, message: down.Stop) -> None:
        self._say(Up.ACK, self.latch(message))

    def _heartbeat(self, nonce: str | None = None) -> up.Heartbeat:
        return up.Heartbeat(**self._header(), challenge="c" * 16, echo_nonce=nonce)

    def _say(self, kind: Up, message: up.Header) -> None:
        if not self.is_silent:
            self._link.publish(topic(self.id, kind), encode(message), qos=0 if kind is Up.HEARTBEAT else 1)

    def _say_safety(self) -> None:
        if not self.is_mute:
            self._say(Up.SAFETY, self.safety())

    async def _live(self) -> None:
        beat = 0
        while True:
            if self.is_latched and not self.is_runaway:
                self.speed_mps = max(0.0, self.speed_mps - DECEL_MPS2 * STEP_S)
            if self.speed_mps > 0:
                self._zero_since = None
            elif self._zero_since is None:
                self._zero_since = time.monotonic()
            beat += 1
            if beat % 4 == 0:
                self._say(Up.HEARTBEAT, self._heartbeat())
            if beat % 2 == 0:
                self._say_safety()
            await asyncio.sleep(STEP_S)

    async def _http_stop(self, request: Request) -> Response:
        if request.headers.get("authorization") != f"Bearer {self.token}":
            return Response(b'{"code":"bad_token","text":"Wrong token."}', 401)
        message = decode_body(Address(self.id, Down.STOP), await request.body())
        if self.is_silent or self.is_deaf:
            await asyncio.sleep(2.0)  # longer than anybody waits
            return Response(status_code=503)
        self.stops_by_http.append(message.stop_id)
        await asyncio.sleep(self.ack_after_s)
        return Response(encode(self.latch(message)))

    async def _http_safety(self, _request: Request) -> Response:
        if self.is_silent or self.is_http_mute:
            await asyncio.sleep(2.0)
            return Response(status_code=503)
        return Response(encode(self.safety()))


class _QuietServer(uvicorn.Server):
    """A server among others in one process: the signals are not its own."""

    @contextlib.contextmanager
    def capture_signals(self):
        yield


def _mono_ms() -> int:
    return int(time.monotonic() * 1000)

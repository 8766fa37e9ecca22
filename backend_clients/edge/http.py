"""The robot's own HTTP endpoint: the second path for STOP and the one for large things.

Paths below ``base_url`` (from the registry, never from the wire)::

    POST stop            Stop            -> Ack
    POST stop-reset      StopReset       -> Ack
    GET  safety                          -> Safety
    GET  state                           -> State
    GET  factsheet                       -> Factsheet
    PUT  missions/{id}   Mission         -> Ack with the hash of what was stored
    GET  missions/{id}                   -> Mission
    GET  logs?lines=N                    -> text
    GET  map, model, cameras             -> what the robot declares, 404 with a reason if nothing
    POST cameras/{id}/control            {"lamp"|"zoom"|"trigger"} -> 204, 409 with a reason
    GET  cameras/{id}/control            -> CameraSetting, 404 from a robot that does not tell
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Annotated

import httpx
import msgspec

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import decode_body, encode
from backend_clients.edge.topics import Address, Up, check_id
from backend_clients.errors import MalformedPayload, Refused, TimedOut, TransportError
from backend_clients.trust import authorities

TIMEOUT_S = 1.0  # one STOP attempt; the sender repeats
UPLOAD_TIMEOUT_S = 20.0
LOG_TIMEOUT_S = 5.0
MAX_LOG_BYTES = 1_000_000  # 2,000 lines of 500 characters
MAX_SETTING_BYTES = 4096


class CameraSetting(msgspec.Struct, frozen=True):
    """How a camera is set: ``lamp`` ``None`` is by itself or unknown, ``zoom`` ``None`` unknown."""

    lamp: bool | None = None
    zoom: Annotated[float, msgspec.Meta(gt=0, le=1000)] | None = None


class RobotHttp:
    """HTTP client of one robot.

    Args:
        robot: its id; answers that name another robot are refused.
        base_url: e.g. ``http://10.0.0.7:9000/weeder-01``.
        token: bearer token from the registry.
        transport: test seam, as in httpx.

    Raises:
        TransportError: address or token cannot be used at all.
    """

    def __init__(
        self, robot: str, base_url: str, token: str, *, transport: httpx.AsyncBaseTransport | None = None
    ) -> None:
        self.robot = check_id(robot)
        try:
            self._client = httpx.AsyncClient(
                base_url=base_url.rstrip("/") + "/",
                headers={"Authorization": f"Bearer {token}"},
                timeout=TIMEOUT_S,
                follow_redirects=False,
                trust_env=False,
                verify=authorities(),
                transport=transport,
                limits=httpx.Limits(max_connections=8, max_keepalive_connections=4),
            )
        except (httpx.InvalidURL, UnicodeError) as error:  # neither is an HTTPError
            raise TransportError(f"{robot}: its address or token cannot be used") from error

    async def close(self) -> None:
        """Close all connections."""
        await self._client.aclose()

    async def stop(self, message: down.Stop) -> up.Ack:
        """Send STOP; return the robot's acknowledgement."""
        return self._ack(await self._send("POST", "stop", encode(message)))

    async def reset(self, message: down.StopReset) -> up.Ack:
        """Ask the robot to clear latched presses; it never moves from this."""
        return self._ack(await self._send("POST", "stop-reset", encode(message)))

    async def safety(self) -> up.Safety:
        """Return the robot's safety state now."""
        message = decode_body(Address(self.robot, Up.SAFETY), await self._send("GET", "safety"))
        assert isinstance(message, up.Safety)
        return message

    async def state(self) -> up.State:
        """Return the robot's state now."""
        message = decode_body(Address(self.robot, Up.STATE), await self._send("GET", "state"))
        assert isinstance(message, up.State)
        return message

    async def upload_mission(self, mission: down.Mission) -> up.Ack:
        """Store a mission on the robot; the acknowledgement carries the read-back hash."""
        path = f"missions/{check_id(mission.mission_id)}"
        return self._ack(await self._send("PUT", path, encode(mission), timeout_s=UPLOAD_TIMEOUT_S))

    async def logs(self, lines: int) -> str:
        """Return the last lines of the robot's log; a longer answer than a megabyte is refused."""
        try:
            async with asyncio.timeout(LOG_TIMEOUT_S):
                return (await self._read(f"logs?lines={int(lines)}", MAX_LOG_BYTES)).decode("utf-8", "replace")
        except TimeoutError as error:  # a robot that sends a byte now and then would hold the caller for ever
            raise TimedOut(f"{self.robot} did not send its log in {LOG_TIMEOUT_S:g} s") from error

    async def control_camera(self, camera: str, order: Mapping[str, bool | float]) -> None:
        """Switch the lamp, set the zoom or trigger a picture; see docs/protocols/cameras.md."""
        await self._send("POST", f"cameras/{check_id(camera)}/control", msgspec.json.encode(order))

    async def camera_setting(self, camera: str) -> CameraSetting:
        """Return how a camera is set now."""
        path = f"cameras/{check_id(camera)}/control"
        try:
            return msgspec.json.decode(await self._read(path, MAX_SETTING_BYTES), type=CameraSetting)
        except msgspec.MsgspecError as error:
            raise MalformedPayload(f"{self.robot} GET {path}: {error}") from error

    def _ack(self, body: bytes) -> up.Ack:
        message = decode_body(Address(self.robot, Up.ACK), body)
        assert isinstance(message, up.Ack)
        return message

    async def _read(self, path: str, most: int) -> bytes:
        try:
            async with self._client.stream("GET", path) as response:
                body = b""
                async for piece in response.aiter_bytes():
                    body += piece
                    if len(body) > most:
                        raise MalformedPayload(f"{self.robot} GET {path}: more than {most} bytes")
        except httpx.TimeoutException as error:
            raise TimedOut(f"{self.robot} did not answer GET {path} in {TIMEOUT_S:g} s") from error
        except httpx.HTTPError as error:
            raise TransportError(f"{self.robot} GET {path}: {error}") from error
        if response.status_code >= 300:
            raise _refusal(httpx.Response(response.status_code, content=body))
        return body

    async def _send(self, method: str, path: str, body: bytes | None = None, *, timeout_s: float = TIMEOUT_S) -> bytes:
        headers = {"Content-Type": "application/json"} if body is not None else {}
        try:
            response = await self._client.request(method, path, content=body, headers=headers, timeout=timeout_s)
        except httpx.TimeoutException as error:
            raise TimedOut(f"{self.robot} did not answer {method} {path} in {timeout_s:g} s") from error
        except httpx.HTTPError as error:
            raise TransportError(f"{self.robot} {method} {path}: {error}") from error
        if response.status_code >= 400:
            raise _refusal(response)
        if response.status_code >= 300:
            raise MalformedPayload(f"{self.robot} {method} {path}: redirect refused")
        return response.content


def _refusal(response: httpx.Response) -> Refused:
    try:
        body = response.json()
        return Refused(str(body["code"])[:64], str(body["text"])[:400])
    except (ValueError, KeyError, TypeError):
        return Refused(f"http_{response.status_code}", f"The robot answered {response.status_code}.")

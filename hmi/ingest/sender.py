"""Puts the console's orders on the wire: MQTT for what must be quick, the robot's HTTP for what is large."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Protocol, TypeVar

import msgspec
from msgspec import UNSET

from backend_clients.edge import messages_down as down
from backend_clients.edge.codec import encode, mission_hash
from backend_clients.edge.http import RobotHttp
from backend_clients.edge.topics import Down, topic
from backend_clients.errors import ClientError, Refused
from hmi.domain.camera import CameraSetting, ControlFailed
from hmi.domain.command import (
    Acknowledgement,
    CommandOrder,
    DriveOrder,
    JogOrder,
    OperatorPulse,
    Order,
    OrderFailed,
    ResetOrder,
    StopOrder,
)
from hmi.domain.robot_log import LogFailed
from hmi.ingest import translate

log = logging.getLogger(__name__)

MISSION_ACK_S = 15.0  # a robot on a slow radio needs some seconds for a megabyte


class Address(Protocol):
    """Where a robot's HTTP endpoint is."""

    @property
    def http_url(self) -> str:
        """Base address."""
        ...

    @property
    def token(self) -> str:
        """Bearer token."""
        ...


class Publisher(Protocol):
    """Sends now or not at all."""

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """Send now or not at all."""
        ...


AddressOf = Callable[[str], Address | None]
T = TypeVar("T")
MakeHttp = Callable[[str, str, str], RobotHttp]


class EdgeSender:
    """``hmi.domain.command.OrderSender`` over one broker connection and the robots' HTTP.

    Args:
        publisher: the broker connection.
        address_of: the registry; an address is never taken from the wire.
        make_http: test seam.
    """

    def __init__(self, publisher: Publisher, address_of: AddressOf, make_http: MakeHttp = RobotHttp) -> None:
        self._publisher, self._address_of, self._make_http = publisher, address_of, make_http
        self._clients: dict[str, tuple[tuple[str, str], RobotHttp]] = {}
        self._waiting: dict[tuple[str, str], asyncio.Future[Acknowledgement]] = {}
        self._closing: set[asyncio.Task[None]] = set()

    def send(self, order: Order) -> bool:
        """Publish ``order``; return False if there is no connection (nothing is queued)."""
        kind, message, qos = _wire(order)
        return self._publisher.publish(topic(order.robot_id, kind), encode(message), qos=qos)

    async def stop_by_http(self, order: StopOrder) -> Acknowledgement | None:
        """Send STOP by the robot's own HTTP; ``None`` if it has none or did not answer."""
        client = self._client(order.robot_id)
        if client is None:
            return None
        message = _stop(order)
        try:
            return translate.acknowledgement(await client.stop(message), None)
        except ClientError as error:
            log.info("stop by http: %s", error)
            return None

    async def upload_mission(self, robot_id: str, document: dict[str, Any]) -> Acknowledgement:
        """Store a mission on the robot and return its answer with the hash it read back.

        HTTP first; a robot without it, or that cannot be reached there, gets it by MQTT. A robot that
        stored something else than was sent is answered for with ``hash_mismatch``.

        Raises:
            OrderFailed: nothing usable came back, or the document is no mission.
        """
        mission = _mission(robot_id, document)
        answer = await self._by_http(robot_id, mission)
        if answer is None:
            answer = await self._by_mqtt(robot_id, mission)
        if answer.is_accepted and answer.sha256 != mission_hash(mission):
            text = "The robot stored something else than was sent. Send it again."
            return _refusal(robot_id, mission.mission_id, "hash_mismatch", text, answer.sha256)
        return answer

    async def tail_log(self, robot_id: str, lines: int) -> list[str]:
        """Return the last lines of a robot's log; see ``hmi.domain.robot_log.LogSource``.

        Raises:
            LogFailed: it has no address, does not answer, or refuses.
        """
        client = self._client(robot_id)
        if client is None:
            raise LogFailed("no_address", "The robot has no address here. An admin can add it under Admin, Robots.")
        try:
            return (await client.logs(lines)).splitlines()[-lines:]
        except Refused as refused:
            raise LogFailed(refused.code, f"The robot does not give its log: {refused.text}") from refused
        except ClientError as error:
            log.info("log by http: %s", error)
            raise LogFailed("no_answer", "The robot did not give its log: no answer. Try again.") from error

    async def control_camera(self, robot_id: str, camera: str, order: Mapping[str, bool | float]) -> None:
        """Tell a robot's camera: lamp, zoom or trigger.

        Raises:
            ControlFailed: it has no address, does not answer, or refuses.
        """
        await self._asked(
            robot_id, lambda client: client.control_camera(camera, order), "Nothing is known to have changed."
        )

    async def camera_setting(self, robot_id: str, camera: str) -> CameraSetting:
        """Ask a robot how its camera is set; raises ``ControlFailed`` as above."""
        told = await self._asked(robot_id, lambda client: client.camera_setting(camera), "Lamp and zoom are not known.")
        return CameraSetting(told.lamp, told.zoom)

    async def _asked(self, robot_id: str, ask: Callable[[RobotHttp], Awaitable[T]], unknown: str) -> T:
        client = self._client(robot_id)
        if client is None:
            raise ControlFailed("no_address", "The robot has no address here. An admin can add it under Admin, Robots.")
        try:
            return await ask(client)
        except Refused as refused:
            raise ControlFailed(refused.code, refused.text) from refused
        except ClientError as error:
            log.info("camera by http: %s", error)
            raise ControlFailed("no_answer", f"The robot did not answer. {unknown}") from error

    def acknowledged(self, answer: Acknowledgement) -> None:
        """Hear every acknowledgement; give it to ``EdgeListeners.on_ack``."""
        waiting = self._waiting.get((answer.robot_id, answer.ref)) if answer.kind == "mission" else None
        if waiting is not None and not waiting.done():
            waiting.set_result(answer)

    async def close(self) -> None:
        """Close all HTTP connections."""
        clients, self._clients = [c for _, c in self._clients.values()], {}
        await asyncio.gather(*(c.close() for c in clients), *self._closing)

    async def _by_http(self, robot_id: str, mission: down.Mission) -> Acknowledgement | None:
        client = self._client(robot_id)
        if client is None:
            return None
        try:
            return translate.acknowledgement(await client.upload_mission(mission), None)
        except Refused as refused:
            return _refusal(robot_id, mission.mission_id, refused.code, refused.text, None)
        except ClientError as error:
            log.info("mission by http: %s", error)
            return None

    async def _by_mqtt(self, robot_id: str, mission: down.Mission) -> Acknowledgement:
        key = (robot_id, mission.mission_id)
        waiting = self._waiting.setdefault(key, asyncio.get_running_loop().create_future())
        try:
            if not self._publisher.publish(topic(robot_id, Down.MISSION), encode(mission), qos=1):
                raise OrderFailed(
                    "not_connected", "No link to the broker. The mission was not sent.", is_outcome_known=True
                )
            return await asyncio.wait_for(asyncio.shield(waiting), MISSION_ACK_S)
        except TimeoutError as error:
            text = "The robot did not answer. It may have stored the mission all the same."
            raise OrderFailed("no_answer", text, is_outcome_known=False) from error
        finally:
            if self._waiting.get(key) is waiting:
                del self._waiting[key]

    def _client(self, robot_id: str) -> RobotHttp | None:
        address = self._address_of(robot_id)
        known = self._clients.get(robot_id)
        if known is not None and (address is None or known[0] != (address.http_url, address.token)):
            del self._clients[robot_id]
            task = asyncio.get_running_loop().create_task(known[1].close(), name="robot-http-close")
            self._closing.add(task)
            task.add_done_callback(self._closing.discard)
            known = None
        if known is None and address is not None:
            try:
                known = (address.http_url, address.token), self._make_http(robot_id, address.http_url, address.token)
            except ClientError as error:
                log.warning("no HTTP: %s", error)
                return None
            self._clients[robot_id] = known
        return known[1] if known is not None else None


def _wire(order: Order) -> tuple[Down, down.Order, int]:
    match order:
        case CommandOrder():
            return Down.COMMAND, _command(order), 1
        case StopOrder():
            return Down.STOP, _stop(order), 1
        case ResetOrder():
            return Down.STOP_RESET, _reset(order), 1
        case DriveOrder():
            return Down.DRIVE, _drive(order), 0
        case JogOrder():
            return Down.JOG, _jog(order), 0
        case OperatorPulse():
            return Down.OPERATOR, _pulse(order), 0


def _command(order: CommandOrder) -> down.Command:
    return down.Command(
        robot=order.robot_id,
        command_id=order.command_id,
        action=order.action.value,
        by=order.by,
        lease_token=order.lease_token,
        lease_seq=order.lease_seq,
        ttl_ms=order.ttl_ms,
        challenge=order.challenge,
        mission_id=order.mission_id,
        mission_sha256=order.mission_sha256,
        is_supervised=order.is_supervised,
        node=UNSET if order.node is None else order.node,
        place=UNSET if order.place is None else order.place,
        target=UNSET if order.target is None else order.target,
    )


def _stop(order: StopOrder) -> down.Stop:
    return down.Stop(robot=order.robot_id, stop_id=order.stop_id, by=order.by, device=order.device, reason=order.reason)


def _reset(order: ResetOrder) -> down.StopReset:
    return down.StopReset(
        robot=order.robot_id,
        reset_id=order.reset_id,
        stop_ids=list(order.stop_ids),
        by=order.by,
        reason=order.reason,
        lease_token=order.lease_token,
        lease_seq=order.lease_seq,
        ttl_ms=order.ttl_ms,
        challenge=order.challenge,
    )


def _drive(order: DriveOrder) -> down.Drive:
    return down.Drive(
        robot=order.robot_id,
        lease_token=order.lease_token,
        lease_seq=order.lease_seq,
        challenge=order.challenge,
        v_mps=order.v_mps,
        yaw_rate_radps=order.yaw_rate_radps,
    )


def _jog(order: JogOrder) -> down.Jog:
    return down.Jog(
        robot=order.robot_id,
        lease_token=order.lease_token,
        lease_seq=order.lease_seq,
        challenge=order.challenge,
        rates=dict(order.rates),
    )


def _pulse(order: OperatorPulse) -> down.OperatorHeartbeat:
    return down.OperatorHeartbeat(
        robot=order.robot_id,
        lease_token=order.lease_token,
        lease_seq=order.lease_seq,
        challenge=order.challenge,
    )


def _mission(robot_id: str, document: dict[str, Any]) -> down.Mission:
    try:
        return msgspec.convert({**document, "robot": robot_id}, down.Mission)
    except msgspec.ValidationError as error:
        raise OrderFailed("bad_mission", f"This is no mission a robot takes: {error}", is_outcome_known=True) from error


def _refusal(robot_id: str, ref: str, code: str, text: str, sha256: str | None) -> Acknowledgement:
    return Acknowledgement(robot_id, "mission", ref, False, code, text, None, sha256, None)

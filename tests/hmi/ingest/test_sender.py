"""Orders reach the wire as the contract has them, now or not at all."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import Any

import httpx
import msgspec
import pytest

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import decode, encode, mission_hash
from backend_clients.edge.http import RobotHttp
from hmi.domain.command import (
    Acknowledgement,
    Action,
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
from hmi.ingest.sender import EdgeSender
from hmi.store.fleet import RobotAddress

ID = "weeder-01"
STOP = StopOrder(ID, "stop-0001", "Martha Keller", "Tablet 3", "Person")
COMMAND = CommandOrder(ID, "command-1", Action.START, "Martha Keller", 7, 3, 2000, "challenge", "m-1", "a" * 64, True)
RESET = ResetOrder(ID, "reset-001", ("stop-0001",), "Martha Keller", "Test", 7, 4, 2000, "challenge")
DRIVE = DriveOrder(ID, 7, 5, "challenge", 0.2, -0.1)
JOG = JogOrder(ID, 7, 5, "challenge", {"slew": 0.1, "extension": -0.2})
RESTART = CommandOrder(ID, "command-2", Action.NODE_RESTART, "Ada Adams", 0, 0, 2000, "challenge", node="gnss")
RETRACT = CommandOrder(ID, "command-3", Action.TOOL_GO_TO, "Ada Adams", 7, 3, 2000, "challenge", place=(1.0, 2.0, 0.0))
PULSE = OperatorPulse(ID, 7, 6, "challenge")
DOCUMENT: dict[str, Any] = {
    "v": 1,
    "robot": "somebody-else",
    "mission_id": "m-1",
    "revision": 1,
    "name": "M-0412",
    "field_name": "Nordfeld 12",
    "datum": {"lat_deg": 52.0, "lon_deg": 5.0},
    "width_m": 1.5,
    "area_m2": 12200.0,
    "parcel": [[[5.0, 52.0], [5.1, 52.0], [5.1, 52.1], [5.0, 52.0]]],
    "segments": [{"kind": "row", "points": [[0, 0], [10, 0]], "speed_mps": 0.45, "tool_on": True, "row": 1}],
}


@dataclass
class Broker:
    """A connection that keeps what is published."""

    is_up: bool = True
    sent: list[tuple[str, bytes, int]] = field(default_factory=list)
    published: asyncio.Event = field(default_factory=asyncio.Event)

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """Keep it, or refuse it while down."""
        assert not retain
        if self.is_up:
            self.sent.append((topic, payload, qos))
            self.published.set()
        return self.is_up


def mission() -> down.Mission:
    """Return the document as the robot gets it."""
    return msgspec.convert({**DOCUMENT, "robot": ID}, down.Mission)


def ack(kind: str, ref: str, **values: Any) -> bytes:
    """Return a robot's answer by HTTP."""
    head = {"robot": ID, "boot": "boot-aaaa", "seq": 1, "mono_ms": 1, "wall_ms": 1}
    return encode(up.Ack(**head, kind=kind, ref=ref, outcome="accepted", **values))  # type: ignore[arg-type]


class Net:
    """The robots' HTTP endpoints."""

    def __init__(self, answer: httpx.Response | Exception) -> None:
        self.answer = answer
        self.requests: list[httpx.Request] = []

    def client(self, robot: str, url: str, token: str) -> RobotHttp:
        """Make a client whose requests come here."""
        return RobotHttp(robot, url, token, transport=httpx.MockTransport(self._handle))

    def _handle(self, request: httpx.Request) -> httpx.Response:
        self.requests.append(request)
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


ADDRESS = RobotAddress("http://10.0.0.7:9000/weeder-01", "token-1")


def sender(broker: Broker, net: Net | None = None, address: RobotAddress | None = ADDRESS) -> EdgeSender:
    """Return a sender with a registry of one robot."""
    return EdgeSender(broker, lambda _id: address if net else None, net.client if net else RobotHttp)


@pytest.mark.parametrize(
    ("order", "kind", "qos"),
    [
        (COMMAND, "command", 1),
        (RESTART, "command", 1),
        (RETRACT, "command", 1),
        (STOP, "stop", 1),
        (RESET, "stop-reset", 1),
        (DRIVE, "drive", 0),
        (JOG, "jog", 0),
        (PULSE, "operator", 0),
    ],
)
def test_every_order_is_one_the_robot_can_read(order: Order, kind: str, qos: int) -> None:
    broker = Broker()
    assert sender(broker).send(order)
    topic, payload, sent_qos = broker.sent[0]
    assert (topic, sent_qos) == (f"headland/v1/{ID}/{kind}", qos)
    _, message = decode(topic, payload)
    for name in order.__dataclass_fields__:
        value, wire = getattr(order, name), getattr(message, {"robot_id": "robot"}.get(name, name))
        wire = None if wire is msgspec.UNSET else wire
        assert value == (tuple(wire) if isinstance(wire, list) else wire)


def test_an_order_made_while_the_broker_is_away_is_refused_not_queued() -> None:
    broker = Broker(is_up=False)
    one = sender(broker)
    assert not one.send(COMMAND)
    broker.is_up = True
    assert broker.sent == []


async def test_stop_goes_to_the_address_of_the_registry_with_its_token() -> None:
    net = Net(httpx.Response(200, content=ack("stop", "stop-0001", speed_mps=0.42)))
    one = sender(Broker(), net)
    answer = await one.stop_by_http(STOP)
    assert answer is not None
    assert (answer.is_accepted, answer.ref, answer.speed_mps) == (True, "stop-0001", 0.42)
    assert str(net.requests[0].url) == "http://10.0.0.7:9000/weeder-01/stop"
    assert net.requests[0].headers["authorization"] == "Bearer token-1"
    await one.close()


@pytest.mark.parametrize(
    "answer",
    [httpx.ConnectError("refused"), httpx.ReadTimeout("late"), httpx.Response(500), httpx.Response(200, content=b"{")],
)
async def test_a_stop_that_is_not_answered_by_http_is_none(answer: httpx.Response | Exception) -> None:
    one = sender(Broker(), Net(answer))
    assert await one.stop_by_http(STOP) is None
    await one.close()


async def test_a_robot_without_http_is_not_asked() -> None:
    assert await sender(Broker()).stop_by_http(STOP) is None


async def test_a_mission_goes_by_http_and_its_hash_is_compared() -> None:
    digest = mission_hash(mission())
    net = Net(httpx.Response(200, content=ack("mission", "m-1", sha256=digest)))
    broker = Broker()
    one = sender(broker, net)
    answer = await one.upload_mission(ID, DOCUMENT)
    assert answer.is_accepted
    assert answer.sha256 == digest
    assert broker.sent == []
    assert net.requests[0].method == "PUT"
    await one.close()


async def test_a_robot_that_stored_something_else_is_not_believed() -> None:
    net = Net(httpx.Response(200, content=ack("mission", "m-1", sha256="b" * 64)))
    one = sender(Broker(), net)
    answer = await one.upload_mission(ID, DOCUMENT)
    assert not answer.is_accepted
    assert answer.code == "hash_mismatch"
    await one.close()


async def test_a_refusal_by_http_is_the_answer_and_is_not_tried_again_by_mqtt() -> None:
    broker = Broker()
    one = sender(broker, Net(httpx.Response(409, json={"code": "mission_active", "text": "Abort it first."})))
    answer = await one.upload_mission(ID, DOCUMENT)
    assert (answer.is_accepted, answer.code, answer.text) == (False, "mission_active", "Abort it first.")
    assert broker.sent == []
    await one.close()


async def test_a_mission_goes_by_mqtt_where_http_does_not_reach() -> None:
    broker = Broker()
    one = sender(broker, Net(httpx.ConnectError("refused")))
    upload = asyncio.create_task(one.upload_mission(ID, DOCUMENT))
    async with asyncio.timeout(5):
        await broker.published.wait()  # the attempt by HTTP has failed before
    _, message = decode(broker.sent[0][0], broker.sent[0][1])
    assert message == mission()
    digest = mission_hash(mission())
    one.acknowledged(Acknowledgement(ID, "command", "m-1", True, "ok", "", None, None, None))
    one.acknowledged(Acknowledgement("weeder-02", "mission", "m-1", True, "ok", "", None, digest, None))
    one.acknowledged(Acknowledgement(ID, "mission", "m-1", True, "ok", "", None, digest, None))
    assert (await upload).is_accepted
    await one.close()


async def test_a_mission_without_any_way_to_the_robot_is_known_not_to_be_sent() -> None:
    with pytest.raises(OrderFailed) as failure:
        await sender(Broker(is_up=False)).upload_mission(ID, DOCUMENT)
    assert failure.value.code == "not_connected"
    assert failure.value.is_outcome_known


async def test_a_mission_that_is_not_answered_has_an_unknown_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hmi.ingest.sender.MISSION_ACK_S", 0.01)
    with pytest.raises(OrderFailed) as failure:
        await sender(Broker()).upload_mission(ID, DOCUMENT)
    assert failure.value.code == "no_answer"
    assert not failure.value.is_outcome_known


async def test_a_document_that_is_no_mission_is_refused_before_anything_is_sent() -> None:
    broker = Broker()
    with pytest.raises(OrderFailed) as failure:
        await sender(broker).upload_mission(ID, {**DOCUMENT, "segments": []})
    assert failure.value.code == "bad_mission"
    assert broker.sent == []


async def test_a_changed_address_is_used_from_the_next_order_on() -> None:
    net = Net(httpx.Response(200, content=ack("stop", "stop-0001")))
    addresses = [ADDRESS, RobotAddress("http://10.0.0.8:9000", "token-2")]
    one = EdgeSender(Broker(), lambda _id: addresses[0], net.client)
    await one.stop_by_http(STOP)
    addresses.pop(0)
    await one.stop_by_http(STOP)
    assert [r.url.host for r in net.requests] == ["10.0.0.7", "10.0.0.8"]
    assert net.requests[1].headers["authorization"] == "Bearer token-2"
    await one.close()


async def test_the_log_comes_from_the_address_of_the_registry_as_lines() -> None:
    net = Net(httpx.Response(200, content=b"1.0 up\n2.0 \xff odd\n3.0 down"))
    one = sender(Broker(), net)
    assert await one.tail_log(ID, 2) == ["2.0 \ufffd odd", "3.0 down"]
    assert str(net.requests[0].url) == "http://10.0.0.7:9000/weeder-01/logs?lines=2"
    await one.close()


@pytest.mark.parametrize(
    ("answer", "code"),
    [
        (httpx.Response(404, json={"code": "not_found", "text": "It keeps no log."}), "not_found"),
        (httpx.Response(500, content=b"oops"), "http_500"),
        (httpx.ConnectError("refused"), "no_answer"),
        (httpx.ReadTimeout("slow"), "no_answer"),
        (httpx.Response(200, content=b"x" * 1_000_001), "no_answer"),
    ],
)
async def test_a_log_that_cannot_be_read_is_told_apart(answer: httpx.Response | Exception, code: str) -> None:
    one = sender(Broker(), Net(answer))
    with pytest.raises(LogFailed) as failed:
        await one.tail_log(ID, 10)
    assert failed.value.code == code
    await one.close()


async def test_a_robot_without_an_address_has_no_log_here() -> None:
    with pytest.raises(LogFailed, match="no_address"):
        await sender(Broker(), Net(httpx.Response(200)), None).tail_log(ID, 10)


async def test_an_address_or_token_that_cannot_be_used_is_as_none() -> None:
    broken = EdgeSender(Broker(), lambda _id: RobotAddress("http://10.0.0.7:9000", "gehölz"))
    assert await broken.stop_by_http(STOP) is None
    with pytest.raises(LogFailed):
        await broken.tail_log(ID, 10)

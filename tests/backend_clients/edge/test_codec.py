"""Every message survives the wire; nothing from the wire can do more than be refused."""

from __future__ import annotations

import functools
import json
from typing import Any

import msgspec
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import (
    DOWN_TYPES,
    MAX_BYTES,
    UP_TYPES,
    decode,
    decode_body,
    encode,
    mission_hash,
)
from backend_clients.edge.topics import Address, Down, Up, is_id, parse, topic
from backend_clients.errors import MalformedPayload, OversizedPayload, WireError, WrongIdentity
from tests.backend_clients.edge import machine_messages
from tests.backend_clients.simulator.rig import Rig, small_mission

KINDS: list[Up | Down] = [*Up, *Down]
numbers = st.floats(allow_nan=False, allow_infinity=False, min_value=-2, max_value=2)
words = st.text(max_size=80)
refs = st.text(min_size=8, max_size=64)
counts = st.integers(0, 2**53)


@pytest.mark.slow
@given(token=counts, seq=counts, challenge=refs, v=numbers, w=numbers)
def test_a_drive_setpoint_survives_the_wire(token: int, seq: int, challenge: str, v: float, w: float) -> None:
    sent = down.Drive(robot="r", lease_token=token, lease_seq=seq, challenge=challenge, v_mps=v, yaw_rate_radps=w)
    assert decode(topic("r", Down.DRIVE), encode(sent)) == (Address("r", Down.DRIVE), sent)


@given(stop_id=refs, by=words, device=words, reason=words)
def test_a_stop_survives_the_wire(stop_id: str, by: str, device: str, reason: str) -> None:
    sent = down.Stop(robot="r", stop_id=stop_id, by=by, device=device, reason=reason)
    assert decode(topic("r", Down.STOP), encode(sent))[1] == sent


@given(data=st.dictionaries(st.text(max_size=8), st.one_of(st.integers(-(2**53), 2**53), words, st.none()), max_size=5))
def test_an_event_survives_the_wire(data: dict[str, Any]) -> None:
    sent = up.Event(
        robot="r",
        boot="boot-0001",
        seq=1,
        mono_ms=2,
        wall_ms=3,
        event_id="event-001",
        kind="mission",
        name="n",
        data=data,
    )
    assert decode(topic("r", Up.EVENT), encode(sent))[1] == sent


def test_everything_a_robot_says_survives_the_wire() -> None:
    rig = Rig()
    rig.start()
    rig.run(8)
    rig.stop()
    reporter = rig.boot.reporter
    said: list[tuple[Up, up.Header]] = [
        (Up.PRESENCE, reporter.presence()),
        (Up.FACTSHEET, reporter.factsheet()),
        (Up.HEARTBEAT, reporter.heartbeat()),
        (Up.TELEMETRY, reporter.telemetry()),
        (Up.STATE, reporter.state()),
        (Up.SAFETY, reporter.safety()),
        (Up.ACK, rig.stop()),
        *((Up.NODE, node) for node in reporter.nodes()),
        *((Up.EVENT, reporter.event(happening)) for happening in rig.events),
        (Up.BODY, machine_messages.body(**reporter.header())),
        (Up.WORKSITE, machine_messages.worksite(**reporter.header())),
        (Up.SCAN, machine_messages.scan(**reporter.header())),
        (Up.DETECTIONS, machine_messages.detections(**reporter.header())),
    ]
    planter = Rig(family="planter").boot.reporter
    said += [(Up.FACTSHEET, planter.factsheet()), (Up.STATE, planter.state()), (Up.BODY, planter.body())]
    for kind, message in said:
        assert decode(topic("weeder-01", kind), encode(message))[1] == message
        # a chart makes a factsheet long; it is sent once
        assert len(encode(message)) < MAX_BYTES / (2 if kind is Up.FACTSHEET else 8)
    assert {kind for kind, _ in said} == set(UP_TYPES)


@settings(max_examples=150, deadline=None)
@given(kind=st.sampled_from(KINDS), payload=st.binary(max_size=200))
@example(kind=Up.STATE, payload=b"[" * 5000)
@example(kind=Down.STOP, payload=b'{"robot":"r","stop_id":"\xff"}')
def test_random_bytes_raise_wire_errors_only(kind: Up | Down, payload: bytes) -> None:
    with pytest.raises(WireError):
        decode_body(Address("r", kind), payload)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=12,
)


@pytest.mark.slow
@settings(max_examples=150, deadline=None)
@given(kind=st.sampled_from(KINDS), field=st.text(max_size=12), value=json_values)
def test_broken_fields_of_honest_messages_raise_wire_errors_or_are_within_range(
    kind: Up | Down, field: str, value: Any
) -> None:
    fields = dict(_honest(kind))
    names = sorted(fields)
    fields[names[len(field) % len(names)]] = value
    try:
        message = decode_body(Address("weeder-01", kind), json.dumps(fields).encode())
    except WireError:
        return
    assert decode_body(Address("weeder-01", kind), encode(message)) == message


@functools.cache
def _honest(kind: Up | Down) -> dict[str, Any]:
    rig = Rig()
    reporter = rig.boot.reporter
    order = {"robot": "weeder-01", "lease_token": 1, "lease_seq": 1, "challenge": "12345678"}
    makers: dict[Up | Down, Any] = {
        Up.PRESENCE: reporter.presence,
        Up.FACTSHEET: reporter.factsheet,
        Up.HEARTBEAT: reporter.heartbeat,
        Up.TELEMETRY: reporter.telemetry,
        Up.STATE: reporter.state,
        Up.SAFETY: reporter.safety,
        Up.EVENT: lambda: reporter.event(rig.robot.take_events()[0]),
        Up.NODE: lambda: reporter.nodes()[0],
        Up.BODY: lambda: machine_messages.body(**reporter.header()),
        Up.WORKSITE: lambda: machine_messages.worksite(**reporter.header()),
        Up.SCAN: lambda: machine_messages.scan(**reporter.header()),
        Up.DETECTIONS: lambda: machine_messages.detections(**reporter.header()),
        Up.ACK: rig.stop,
        Down.COMMAND: lambda: rig.order("start"),
        Down.MISSION: lambda: small_mission(rows=1),
        Down.STOP: lambda: down.Stop(robot="weeder-01", stop_id="12345678", by="Anna"),
        Down.STOP_RESET: lambda: down.StopReset(
            **order, reset_id="12345678", stop_ids=["12345678"], by="A", reason="R"
        ),
        Down.DRIVE: lambda: down.Drive(**order, v_mps=0.1, yaw_rate_radps=0.0),
        Down.JOG: lambda: down.Jog(**order, rates={"slew": 0.1}),
        Down.OPERATOR: lambda: down.OperatorHeartbeat(**order),
        Down.PING: lambda: down.Ping(robot="weeder-01", nonce="1"),
    }
    fields: dict[str, Any] = msgspec.to_builtins(makers[kind]())
    return fields


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999", "3.5"])
def test_numbers_that_are_none_or_out_of_range_are_refused(number: str) -> None:
    head = b'{"robot":"r","lease_token":1,"lease_seq":1,"challenge":"12345678","yaw_rate_radps":0.0,"v_mps":'
    body = head + number.encode() + b"}"
    with pytest.raises(MalformedPayload):
        decode_body(Address("r", Down.DRIVE), body)


def test_a_message_of_another_robot_is_refused() -> None:
    with pytest.raises(WrongIdentity):
        decode(topic("weeder-02", Down.PING), encode(down.Ping(robot="weeder-01", nonce="1")))


def test_an_oversized_message_is_refused_before_it_is_read() -> None:
    with pytest.raises(OversizedPayload):
        decode(topic("r", Up.STATE), b" " * (MAX_BYTES + 1))


def test_unknown_fields_are_ignored_upwards_and_refused_downwards() -> None:
    head = '"robot":"r","boot":"boot-0001","seq":1,"mono_ms":1,"wall_ms":1,'
    decode_body(Address("r", Up.HEARTBEAT), ("{" + head + '"challenge":"12345678","new":1}').encode())
    with pytest.raises(MalformedPayload):
        decode_body(Address("r", Down.PING), b'{"robot":"r","nonce":"1","new":1}')


@pytest.mark.parametrize("bad", ["", "A", "-a", "a b", "a/b", "a+", "#", "$SYS", "a\n", "a\x00", "a" * 65, "é"])
def test_ids_outside_the_rule_are_refused_everywhere(bad: str) -> None:
    assert not is_id(bad)
    with pytest.raises(WrongIdentity):
        topic(bad, Down.STOP)
    with pytest.raises(WrongIdentity):
        parse(f"headland/v1/{bad}/stop")
    with pytest.raises(MalformedPayload):
        decode_body(Address(bad, Down.PING), json.dumps({"robot": bad, "nonce": "1"}).encode())


def test_the_hash_of_a_mission_ignores_white_space_but_not_content() -> None:
    mission = small_mission()
    spaced = json.dumps(msgspec.to_builtins(mission), indent=3).encode()
    read = decode_body(Address("weeder-01", Down.MISSION), spaced)
    assert isinstance(read, down.Mission)
    assert mission_hash(read) == mission_hash(mission)
    assert mission_hash(small_mission(revision=2)) != mission_hash(mission)


def test_every_topic_has_a_model_and_round_trips() -> None:
    assert set(UP_TYPES) == set(Up)
    assert set(DOWN_TYPES) == set(Down)
    for kind in KINDS:
        assert parse(topic("weeder-01", kind)) == Address("weeder-01", kind)

"""Every message of a station survives the wire; nothing from the wire can do more than be refused."""

from __future__ import annotations

import json
from typing import Any

import msgspec
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from backend_clients.edge import topics as robots
from backend_clients.errors import MalformedPayload, OversizedPayload, WireError, WrongIdentity
from backend_clients.field import messages as m
from backend_clients.field.codec import MAX_BYTES, MAX_FRAME_BYTES, TYPES, decode, decode_body, encode
from backend_clients.field.topics import Address, Down, Up, every_station, parse, topic
from tests.backend_clients.field.honest import STATION, honest

KINDS: list[Up | Down] = [*Up, *Down]
JPEG = b"\xff\xd8\xff\xe0 picture"


def test_every_kind_has_a_topic_and_a_model_or_is_a_picture() -> None:
    assert {*TYPES, Up.FRAME} == set(KINDS)
    for kind in KINDS:
        assert parse(topic(STATION, kind)) == Address(STATION, kind)


def test_every_message_survives_the_wire() -> None:
    assert set(honest()) == set(TYPES)
    for kind, message in honest().items():
        assert decode(topic(STATION, kind), encode(message)) == (Address(STATION, kind), message)


def test_a_picture_survives_the_wire_and_nothing_else_passes_for_one() -> None:
    assert decode(topic("cam", Up.FRAME), JPEG) == (Address("cam", Up.FRAME), JPEG)
    with pytest.raises(MalformedPayload, match="JPEG"):
        decode(topic("cam", Up.FRAME), b"{}")
    with pytest.raises(OversizedPayload):
        decode(topic("cam", Up.FRAME), JPEG + bytes(MAX_FRAME_BYTES))
    with pytest.raises(MalformedPayload, match="picture"):
        decode_body(Address("cam", Up.FRAME), b"{}")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("robot_id", ["field", "weeder-01"])
def test_no_station_is_taken_for_a_robot(kind: Up | Down, robot_id: str) -> None:
    text = topic(robot_id, kind)
    with pytest.raises(WrongIdentity):
        robots.parse(text)
    filters = [robots.every_robot(one) for one in [*robots.Up, *robots.Down]]
    assert all(one.count("/") != text.count("/") for one in filters)
    assert text.count("/") == every_station(kind).count("/")


def test_a_robot_called_field_is_no_station() -> None:
    with pytest.raises(WrongIdentity):
        parse(robots.topic("field", robots.Up.ACK))


@given(
    value=st.floats(allow_nan=False, allow_infinity=False, min_value=-1e9, max_value=1e9),
    depth=st.none() | st.floats(0, 20),
    seq=st.integers(0, 2**53),
    battery=st.none() | st.floats(0, 1),
)
def test_values_survive_the_wire(value: float, depth: float | None, seq: int, battery: float | None) -> None:
    reading = m.Reading(quantity="co2", value=value, depth_m=msgspec.UNSET if depth is None else depth)
    sent = msgspec.structs.replace(
        honest()[Up.DATA], seq=seq, values=[reading], battery=msgspec.UNSET if battery is None else battery
    )
    assert decode(topic(STATION, Up.DATA), encode(sent))[1] == sent


@settings(max_examples=150, deadline=None)
@given(kind=st.sampled_from(KINDS), payload=st.binary(max_size=200).filter(lambda raw: not raw.startswith(JPEG[:3])))
@example(kind=Up.DATA, payload=b"[" * 5000)
@example(kind=Down.NOTICE, payload=b"")
@example(kind=Down.TRIGGER, payload=b'{"station":"soil-01","id":"\xff"}')
def test_random_bytes_raise_wire_errors_only(kind: Up | Down, payload: bytes) -> None:
    with pytest.raises(WireError):
        decode(topic(STATION, kind), payload)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None)
@given(kind=st.sampled_from(sorted(TYPES)), place=st.integers(0, 20), value=json_values)
def test_broken_fields_raise_wire_errors_or_are_within_range(kind: Up | Down, place: int, value: Any) -> None:
    fields = msgspec.to_builtins(honest()[kind])
    names = sorted(fields)
    fields[names[place % len(names)]] = value
    try:
        message = decode_body(Address(STATION, kind), json.dumps(fields).encode())
    except WireError:
        return
    assert decode_body(Address(STATION, kind), encode(message)) == message


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999", "1e12"])
def test_numbers_that_are_none_or_out_of_range_are_refused(number: str) -> None:
    body = encode(honest()[Up.DATA]).replace(b"0.21", number.encode())
    with pytest.raises(MalformedPayload):
        decode(topic(STATION, Up.DATA), body)


@pytest.mark.parametrize(
    "moment",
    ["2026-05-14T12:00:00", "2026-05-14T12:00:00+02:00", "0001-01-01T00:00:00+05:00", "9999-12-31T23:00:00-05:00", ""],
)
def test_times_that_are_not_utc_are_refused(moment: str) -> None:
    for kind, name in ((Up.DATA, "utc"), (Down.NOTICE, "until_utc"), (Down.TRIGGER, "utc")):
        fields = msgspec.to_builtins(honest()[kind]) | {name: moment}
        with pytest.raises(MalformedPayload):
            decode_body(Address(STATION, kind), json.dumps(fields).encode())


def test_a_message_of_another_station_is_refused() -> None:
    with pytest.raises(WrongIdentity):
        decode(topic("soil-02", Up.DATA), encode(honest()[Up.DATA]))


def test_an_oversized_message_is_refused_before_it_is_read() -> None:
    with pytest.raises(OversizedPayload):
        decode(topic(STATION, Up.DATA), b" " * (MAX_BYTES + 1))


def test_a_quantity_named_twice_at_one_depth_is_refused() -> None:
    twice = [m.Reading(quantity="soil_moisture", value=value, depth_m=0.1) for value in (0.1, 0.2)]
    with pytest.raises(MalformedPayload, match="twice"):
        decode(topic(STATION, Up.DATA), encode(msgspec.structs.replace(honest()[Up.DATA], values=twice)))
    rows = [m.Quantity(quantity="co2", unit="umol/mol")] * 2
    with pytest.raises(MalformedPayload, match="twice"):
        decode(topic(STATION, Up.ABOUT), encode(msgspec.structs.replace(honest()[Up.ABOUT], quantities=rows)))


def test_unknown_fields_are_ignored_upwards_and_refused_downwards() -> None:
    for kind, message in honest().items():
        body = json.dumps(msgspec.to_builtins(message) | {"new": 1}).encode()
        if isinstance(kind, Up):
            assert decode_body(Address(STATION, kind), body) == message
        else:
            with pytest.raises(MalformedPayload):
                decode_body(Address(STATION, kind), body)


def test_the_longest_honest_message_is_under_the_limit() -> None:
    rows = [m.Reading(quantity="soil_temperature", value=-12.3456, depth_m=n / 4) for n in range(64)]
    assert len(encode(msgspec.structs.replace(honest()[Up.DATA], values=rows))) < MAX_BYTES / 2


@pytest.mark.parametrize("bad", ["", "A", "a/b", "a+", "#", "$SYS", "a\n", "a" * 65, "é"])
def test_ids_outside_the_rule_are_refused_everywhere(bad: str) -> None:
    with pytest.raises(WrongIdentity):
        topic(bad, Up.DATA)
    with pytest.raises(WrongIdentity):
        parse(f"headland/v1/field/{bad}/data")
    with pytest.raises(MalformedPayload):
        decode_body(Address(bad, Down.TRIGGER), json.dumps({"station": bad, "id": "12345678"}).encode())

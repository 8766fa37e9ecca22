"""Bytes to messages and back, trusting nothing.

The decoder refuses NaN and infinities (they are not JSON), values out of range, payloads over the
limit of their kind, and messages whose robot is not the robot of the topic.
"""

from __future__ import annotations

import hashlib
from typing import Any

import msgspec

from backend_clients.edge import machine
from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Address, Down, Up, parse
from backend_clients.errors import MalformedPayload, OversizedPayload, WrongIdentity

UP_TYPES: dict[Up, type[up.Header]] = {
    Up.PRESENCE: up.Presence,
    Up.FACTSHEET: up.Factsheet,
    Up.HEARTBEAT: up.Heartbeat,
    Up.TELEMETRY: up.Telemetry,
    Up.STATE: up.State,
    Up.SAFETY: up.Safety,
    Up.EVENT: up.Event,
    Up.NODE: up.Node,
    Up.BODY: machine.Body,
    Up.WORKSITE: machine.Worksite,
    Up.SCAN: machine.Scan,
    Up.DETECTIONS: machine.Detections,
    Up.ACK: up.Ack,
}
DOWN_TYPES: dict[Down, type[down.Order]] = {
    Down.COMMAND: down.Command,
    Down.MISSION: down.Mission,
    Down.STOP: down.Stop,
    Down.STOP_RESET: down.StopReset,
    Down.DRIVE: down.Drive,
    Down.JOG: down.Jog,
    Down.OPERATOR: down.OperatorHeartbeat,
    Down.PING: down.Ping,
}
MAX_BYTES = 64 * 1024  # the largest honest message, a factsheet, is under 8 KB
MAX_MISSION_BYTES = 8 * 1024 * 1024  # 802 swaths of a 17 ha parcel at 0.5 m take about 1 MB

_encoder = msgspec.json.Encoder()
_decoders: dict[Up | Down, msgspec.json.Decoder[Any]] = {
    **{k: msgspec.json.Decoder(t) for k, t in UP_TYPES.items()},
    **{k: msgspec.json.Decoder(t) for k, t in DOWN_TYPES.items()},
}
_header_decoder = msgspec.json.Decoder(up.Header)


def encode(message: up.Header | down.Order) -> bytes:
    """Return the message as JSON bytes."""
    return _encoder.encode(message)


def decode(topic: str, payload: bytes) -> tuple[Address, up.Header | down.Order]:
    """Return address and message of one MQTT publication.

    Raises:
        OversizedPayload, MalformedPayload, WrongIdentity: see ``backend_clients.errors``.
    """
    address = parse(topic)
    return address, decode_body(address, payload)


def decode_body(address: Address, payload: bytes) -> up.Header | down.Order:
    """Decode a payload whose robot and kind are already known, e.g. an HTTP body."""
    limit = MAX_MISSION_BYTES if address.kind is Down.MISSION else MAX_BYTES
    if len(payload) > limit:
        raise OversizedPayload(f"{address.robot}/{address.kind}: {len(payload)} bytes, limit {limit}")
    try:
        message: up.Header | down.Order = _decoders[address.kind].decode(payload)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise MalformedPayload(f"{address.robot}/{address.kind}: {error}") from error
    if message.robot != address.robot:
        raise WrongIdentity(f"topic says {address.robot}, payload says {message.robot}")
    return message


def header_of(address: Address, payload: bytes) -> up.Header:
    """Return only the header of an upward payload, for what its number tells; the rest may be anything.

    Raises:
        MalformedPayload, WrongIdentity: see ``backend_clients.errors``.
    """
    try:
        header = _header_decoder.decode(payload)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise MalformedPayload(f"{address.robot}/{address.kind}: {error}") from error
    if header.robot != address.robot:
        raise WrongIdentity(f"topic says {address.robot}, payload says {header.robot}")
    return header


def mission_hash(mission: down.Mission) -> str:
    """Return the SHA-256 hex digest of a mission's canonical bytes, as the robot reads it back.

    Canonical: decoded and encoded again by this contract with sorted keys, so white space does not count. The proof
    of an update is about the moment of sending and does not count either.
    """
    canonical = msgspec.json.encode(msgspec.structs.replace(mission, proof=msgspec.UNSET), order="sorted")
    return hashlib.sha256(canonical).hexdigest()

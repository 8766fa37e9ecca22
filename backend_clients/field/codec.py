"""Bytes of field stations to messages and back, trusting nothing.

The decoder refuses NaN and infinities (they are not JSON), values out of range, times that are not UTC, payloads over
the limit of their kind, and messages whose station is not the station of the topic.
"""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any

import msgspec

from backend_clients.errors import MalformedPayload, OversizedPayload, WrongIdentity
from backend_clients.field import messages
from backend_clients.field.topics import Address, Down, Up, parse

Message = messages.About | messages.Data | messages.Ack | messages.Notice | messages.Trigger

TYPES: dict[Up | Down, type[Message]] = {
    Up.ABOUT: messages.About,
    Up.DATA: messages.Data,
    Up.ACK: messages.Ack,
    Down.NOTICE: messages.Notice,
    Down.TRIGGER: messages.Trigger,
}  # a frame is a JPEG file as it is
MAX_BYTES = 16 * 1024  # 64 values of a multi-depth probe take 5 KB
MAX_FRAME_BYTES = 512 * 1024
_JPEG_BEGIN = b"\xff\xd8\xff"

_encoder = msgspec.json.Encoder()
_decoders: dict[Up | Down, msgspec.json.Decoder[Any]] = {k: msgspec.json.Decoder(t) for k, t in TYPES.items()}


def encode(message: Message) -> bytes:
    """Return the message as JSON bytes."""
    return _encoder.encode(message)


def decode(topic: str, payload: bytes) -> tuple[Address, Message | bytes]:
    """Return address and message of one MQTT publication; a frame comes as its JPEG bytes.

    Raises:
        OversizedPayload, MalformedPayload, WrongIdentity: see ``backend_clients.errors``.
    """
    address = parse(topic)
    return address, decode_frame(address, payload) if address.kind is Up.FRAME else decode_body(address, payload)


def decode_body(address: Address, payload: bytes) -> Message:
    """Decode a JSON payload whose station and kind are known; an empty one is malformed as well."""
    where = f"{address.station}/{address.kind}"
    if len(payload) > MAX_BYTES:
        raise OversizedPayload(f"{where}: {len(payload)} bytes, limit {MAX_BYTES}")
    decoder = _decoders.get(address.kind)
    if decoder is None:
        raise MalformedPayload(f"{where}: a frame is a JPEG picture, not JSON")
    try:
        message: Message = decoder.decode(payload)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise MalformedPayload(f"{where}: {error}") from error
    if message.station != address.station:
        raise WrongIdentity(f"topic says {address.station}, payload says {message.station}")
    _check_times(where, message)
    _check_once(where, message)
    return message


def decode_frame(address: Address, payload: bytes) -> bytes:
    """Return the JPEG bytes of a picture; what is inside is for whoever decodes it."""
    if len(payload) > MAX_FRAME_BYTES:
        raise OversizedPayload(f"{address.station}/frame: {len(payload)} bytes, limit {MAX_FRAME_BYTES}")
    if not payload.startswith(_JPEG_BEGIN):
        raise MalformedPayload(f"{address.station}/frame: not a JPEG picture")
    return payload


def _check_times(where: str, message: Message) -> None:
    # an offset would make the year 1 or 9999 overflow where somebody converts it
    for name in ("utc", "until_utc"):
        moment: datetime | None = getattr(message, name, None)
        if moment is not None and moment.utcoffset() != timedelta(0):
            raise MalformedPayload(f"{where}: {name} must be UTC, with Z")


def _check_once(where: str, message: Message) -> None:
    rows: list[Any] = []
    if isinstance(message, messages.About):
        rows = message.quantities
    elif isinstance(message, messages.Data):
        rows = message.values
    keys = [(row.quantity, row.depth_m) for row in rows]
    if len(set(keys)) != len(keys):
        raise MalformedPayload(f"{where}: a quantity is named twice at the same depth")

"""What a browser may send, checked before anything else sees it."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec
from msgspec import Meta, Struct

from hmi.domain.ids import ID_PATTERN
from hmi.stop_gateway.errors import BadFrame

MAX_FRAME_BYTES = 64 * 1024  # a thousand robot ids of 64 characters
StopId = Annotated[str, Meta(pattern=r"^[0-9A-Za-z_-]{8,64}(?!\n)$")]
RobotId = Annotated[str, Meta(pattern=ID_PATTERN + r"(?!\n)")]
Robots = Annotated[list[RobotId], Meta(min_length=1, max_length=1000)] | Literal["all"]


class AuthFrame(Struct, tag_field="k", tag="auth", frozen=True):
    """The first frame."""

    token: str


class StopFrame(Struct, tag_field="k", tag="stop", frozen=True):
    """STOP, or one more copy of it."""

    stop_id: StopId
    robots: Robots
    reason: Annotated[str, Meta(max_length=80)] = ""


class PingFrame(Struct, tag_field="k", tag="ping", frozen=True):
    """Measures the round trip."""

    n: Annotated[int, Meta(ge=0, le=2**53)]


class StopBody(Struct, frozen=True):
    """Body of ``POST /stop``; ``token`` spares the browser the preflight that a header costs."""

    stop_id: StopId
    robots: Robots
    token: str = ""
    reason: Annotated[str, Meta(max_length=80)] = ""


Frame = AuthFrame | StopFrame | PingFrame
_frame = msgspec.json.Decoder(Frame)
_body = msgspec.json.Decoder(StopBody)


def read_frame(data: bytes | str) -> Frame:
    """Return a browser's frame; raises ``BadFrame``."""
    try:
        frame: Frame = _frame.decode(data)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise BadFrame(f"The frame cannot be read: {error}") from error
    return frame


def read_body(data: bytes) -> StopBody:
    """Return the body of ``POST /stop``; raises ``BadFrame``."""
    if len(data) > MAX_FRAME_BYTES:
        raise BadFrame(f"The body has more than {MAX_FRAME_BYTES} bytes.")
    try:
        return _body.decode(data)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise BadFrame(f"The body cannot be read: {error}") from error


def encode(frame: object) -> str:
    """Return a frame as text for a websocket."""
    return msgspec.json.encode(frame).decode("utf-8")

"""What a camera's worker and the camera process say to each other over a socket pair.

Worker to process: 36 bytes, then the payload. Process to worker: one JSON line each.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum

import msgspec
from msgspec import Struct

HEAD = struct.Struct("<BBHHHIIdQI")
MAX_PAYLOAD_BYTES = 16 * 1024 * 1024


class Kind(IntEnum):
    """What a message carries."""

    H264 = 1
    VP8 = 2
    JPEG = 3
    NEWS = 4


@dataclass(frozen=True, slots=True)
class Piece:
    """One encoded picture.

    ``captured_ms`` is on the machine's monotonic clock; ``wanted_width`` is which JPEG this is (0: as it came).
    ``seq`` is the same for all pieces made of one picture. ``pts`` counts 90 kHz and never goes back.
    """

    kind: Kind
    data: bytes
    captured_ms: float
    seq: int
    width: int
    height: int
    is_key: bool = True
    is_dated: bool = False
    wanted_width: int = 0
    pts: int = 0

    def packed(self) -> bytes:
        """Return the bytes on the socket."""
        flags = (1 if self.is_key else 0) | (2 if self.is_dated else 0)
        head = HEAD.pack(
            self.kind,
            flags,
            self.width & 0xFFFF,
            self.height & 0xFFFF,
            self.wanted_width & 0xFFFF,
            self.seq & 0xFFFFFFFF,
            0,
            self.captured_ms,
            self.pts,
            len(self.data),
        )
        return head + self.data


class News(Struct, frozen=True, kw_only=True):
    """What a worker tells of its source, once a second and when it ends.

    ``pictures`` and ``size`` (bytes) since it began; ``bad``: what came and could not be used, ``why`` the last reason;
    ``skipped``: pictures a newer one overtook. ``ended``: why the worker gives up, empty while it works. ``mark``: of
    the last picture that came without a time, by which the next worker knows it again. ``waits_key``: what comes can
    only be shown from the camera's next key picture on.
    """

    pictures: int = 0
    size: int = 0
    bad: int = 0
    why: str = ""
    skipped: int = 0
    ended: str = ""
    mark: str = ""
    waits_key: bool = False

    def packed(self) -> bytes:
        """Return the bytes on the socket."""
        data = msgspec.json.encode(self)
        return HEAD.pack(Kind.NEWS, 0, 0, 0, 0, 0, 0, 0.0, 0, len(data)) + data


class JpegWish(Struct, frozen=True):
    """JPEGs of at most this width (0: as they come) and at most so many a second."""

    width: int
    fps: float


class Plan(Struct, frozen=True, tag_field="k", tag="plan"):
    """What a worker shall make now; ``fps`` and ``width`` (0: any) limit what it asks of the source."""

    fps: float = 15.0
    width: int = 0
    has_h264: bool = False
    has_vp8: bool = False
    video_width: int = 1280
    jpegs: tuple[JpegWish, ...] = ()


class KeyPicture(Struct, frozen=True, tag_field="k", tag="key"):
    """Make a picture now that can be decoded alone."""


Order = Plan | KeyPicture
order_decoder: msgspec.json.Decoder[Order] = msgspec.json.Decoder(Order)
news_decoder: msgspec.json.Decoder[News] = msgspec.json.Decoder(News)


def pack_order(order: Order) -> bytes:
    """Return an order as it goes over the socket."""
    return msgspec.json.encode(order) + b"\n"


def unpack_piece(head: bytes, data: bytes) -> Piece:
    """Return a picture; the kind is not ``NEWS``."""
    kind, flags, width, height, wanted, seq, _, captured_ms, pts, _ = HEAD.unpack(head)
    return Piece(Kind(kind), data, captured_ms, seq, width, height, bool(flags & 1), bool(flags & 2), wanted, pts)

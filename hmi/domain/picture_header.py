"""What a picture says about itself before anything decodes it: format and size, and whether its end came too.

Bytes from a field are not decoded in the console. Its headers are read here, with every length checked.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

MOST_PIXELS = 40_000_000  # a large field camera has 24 million; 16k x 16k, 268 million, would fill the memory
MOST_SIDE_PX = 16_384
_PNG = b"\x89PNG\r\n\x1a\n"
_PNG_END = b"\x00\x00\x00\x00IEND\xaeB`\x82"
_JPEG, _JPEG_END = b"\xff\xd8", b"\xff\xd9"
_FRAMES = frozenset({0xC0, 0xC1, 0xC2})  # baseline, extended, progressive; the others are what no browser shows
_OTHER_FRAMES = frozenset({0xC3, 0xC5, 0xC6, 0xC7, 0xC9, 0xCA, 0xCB, 0xCD, 0xCE, 0xCF})
_BARE = frozenset({0x01, *range(0xD0, 0xD8)})
_SCAN, _END = 0xDA, 0xD9
_MOST_SEGMENTS = 512


class BadPicture(ValueError):
    """These bytes are no picture that is taken; ``code`` for programs, the text one sentence for a person.

    Codes: ``not_a_picture``, ``too_large``, ``truncated``.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text


@dataclass(frozen=True, slots=True)
class Header:
    """Format and size of a picture."""

    media_type: str
    width_px: int
    height_px: int


def read_picture(data: bytes, most_pixels: int = MOST_PIXELS) -> Header:
    """Return format and size of a whole JPEG or PNG; raises ``BadPicture``."""
    if data.startswith(_JPEG):
        header = _jpeg(data)
        is_whole = data.rstrip(b"\x00").endswith(_JPEG_END)  # some cameras pad to a block
    elif data.startswith(_PNG):
        header = _png(data)
        is_whole = data.endswith(_PNG_END)
    else:
        raise BadPicture("not_a_picture", "This is neither a JPEG nor a PNG.")
    wide, high = header.width_px, header.height_px
    if wide < 1 or high < 1:
        raise BadPicture("not_a_picture", "This picture has no size.")
    if wide > MOST_SIDE_PX or high > MOST_SIDE_PX or wide * high > most_pixels:
        text = f"{wide} x {high} is more than {most_pixels // 1_000_000} million pixels."
        raise BadPicture("too_large", text)
    if not is_whole:
        raise BadPicture("truncated", "The end of this picture is missing.")
    return header


def _png(data: bytes) -> Header:
    if len(data) < 33 or data[12:16] != b"IHDR":
        raise BadPicture("truncated", "The end of this picture is missing.")
    wide, high = struct.unpack_from(">II", data, 16)
    return Header("image/png", wide, high)


def _jpeg(data: bytes) -> Header:
    """Walk the segments up to the frame header."""
    at = 2
    for _ in range(_MOST_SEGMENTS):
        at = _marker(data, at)
        marker = data[at]
        at += 1
        if marker in _BARE:
            continue
        if marker in (_SCAN, _END) or marker in _OTHER_FRAMES:
            raise BadPicture("not_a_picture", "This JPEG cannot be shown.")
        if at + 2 > len(data):
            break
        (length,) = struct.unpack_from(">H", data, at)
        if length < 2:
            raise BadPicture("not_a_picture", "This JPEG is damaged.")
        if marker in _FRAMES:
            if at + 7 > len(data) or length < 8:
                break
            high, wide = struct.unpack_from(">HH", data, at + 3)
            return Header("image/jpeg", wide, high)
        at += length
    raise BadPicture("truncated", "The end of this picture is missing.")


def _marker(data: bytes, at: int) -> int:
    """Return where the code of the next marker stands; raises ``BadPicture``."""
    if at >= len(data):
        raise BadPicture("truncated", "The end of this picture is missing.")
    if data[at] != 0xFF:
        raise BadPicture("not_a_picture", "This JPEG is damaged.")
    while at < len(data) and data[at] == 0xFF:
        at += 1
    if at >= len(data):
        raise BadPicture("truncated", "The end of this picture is missing.")
    return at

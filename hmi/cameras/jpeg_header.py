"""What a JPEG says of itself before anybody decodes it."""

from __future__ import annotations

MAX_BYTES = 8 * 1024 * 1024
MAX_PIXELS = 40_000_000  # 12 bytes each while it is decoded and converted
_FRAMES = frozenset({0xC0, 0xC1, 0xC2})  # baseline, extended, progressive: what decoders know
_BARE = frozenset({0x01, *range(0xD0, 0xD8)})  # markers without a length


class BadPicture(Exception):
    """It is no picture that can be shown; the text says why in a few words."""


def checked_size(data: bytes) -> tuple[int, int]:
    """Return width and height in pixels of a whole JPEG within the limits.

    Raises:
        BadPicture: not a JPEG, cut off, or too large to be decoded here.
    """
    if len(data) > MAX_BYTES:
        raise BadPicture(f"larger than {MAX_BYTES // 1024 // 1024} MB")
    width, height = size_of(data)
    if not width >= 1 or not height >= 1:
        raise BadPicture("a picture without size")
    if width * height > MAX_PIXELS:
        raise BadPicture(f"{width} x {height} pixels are too many")
    if b"\xff\xd9" not in data[-64:]:  # some cameras pad
        raise BadPicture("cut off")
    return width, height


def size_of(data: bytes) -> tuple[int, int]:
    """Return width and height from the frame header; raises ``BadPicture``."""
    if data[:2] != b"\xff\xd8":
        raise BadPicture("not a JPEG")
    at = 2
    while at + 4 <= len(data):
        if data[at] != 0xFF:
            raise BadPicture("broken header")
        marker = data[at + 1]
        if marker == 0xFF:  # fill byte
            at += 1
            continue
        if marker in _BARE:
            at += 2
            continue
        if marker in (0xD9, 0xDA):
            raise BadPicture("no size before the picture")
        length = int.from_bytes(data[at + 2 : at + 4], "big")
        if length < 2:
            raise BadPicture("broken header")
        if marker in _FRAMES:
            if at + 9 > len(data):
                break
            return int.from_bytes(data[at + 7 : at + 9], "big"), int.from_bytes(data[at + 5 : at + 7], "big")
        if 0xC3 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            raise BadPicture("a kind of JPEG that is not read")
        at += 2 + length
    raise BadPicture("cut off")

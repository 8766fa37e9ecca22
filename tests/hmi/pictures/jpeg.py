"""Pictures for tests, some of them wrong."""

from __future__ import annotations

import io
import struct

from PIL import Image


def picture(width_px: int = 64, height_px: int = 48, shade: int = 90, kind: str = "JPEG", **options: object) -> bytes:
    """Return a picture of one shade."""
    made = io.BytesIO()
    Image.new("RGB", (width_px, height_px), (shade, 200, 40)).save(made, kind, **options)
    return made.getvalue()


def bomb(width_px: int, height_px: int) -> bytes:
    """Return a small JPEG whose header promises a large picture."""
    data = bytearray(picture())
    at = data.index(b"\xff\xc0") + 5
    data[at : at + 4] = struct.pack(">HH", height_px, width_px)
    return bytes(data)

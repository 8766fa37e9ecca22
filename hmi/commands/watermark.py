"""Who looked at a picture and when, burnt into the copy that leaves; what is kept stays as it was taken."""

from __future__ import annotations

import io
import warnings
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:
    from PIL import Image

QUALITY = 90
_MARGIN_PX = 6


def mark_of(user_name: str, at: datetime) -> str:
    """Return what is burnt in for a person at a time."""
    return f"{user_name}  {at:%Y-%m-%d %H:%M} UTC"


def watermarked(source: Path | BinaryIO, text: str) -> bytes:
    """Return a JPEG with a line of text at its lower edge; blocking.

    The picture was judged when it came, so that its size is bounded. Raises ``OSError`` for one that cannot be decoded.
    """
    from PIL import ImageDraw, ImageFont  # few installations want this; it must not slow every start

    picture = _opened(source)
    font = ImageFont.load_default(size=max(12, picture.height // 40))
    pen = ImageDraw.Draw(picture, "RGBA")
    left, top, right, bottom = pen.textbbox((0, 0), text, font=font)
    y = picture.height - (bottom - top) - 2 * _MARGIN_PX
    pen.rectangle((0, y, right - left + 2 * _MARGIN_PX, picture.height), fill=(0, 0, 0, 160))
    pen.text((_MARGIN_PX - left, y + _MARGIN_PX - top), text, font=font, fill=(255, 255, 255, 255))
    made = io.BytesIO()
    picture.save(made, "JPEG", quality=QUALITY)
    return made.getvalue()


def as_jpeg(data: bytes) -> bytes:
    """Return a PNG as JPEG for those who look, who take nothing else; blocking. Raises ``OSError`` as above."""
    made = io.BytesIO()
    _opened(io.BytesIO(data)).save(made, "JPEG", quality=QUALITY)
    return made.getvalue()


def _opened(source: Path | BinaryIO) -> Image.Image:
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        try:
            with Image.open(source, formats=("JPEG", "PNG")) as opened:
                return opened.convert("RGB")
        except (Image.DecompressionBombError, Image.DecompressionBombWarning, SyntaxError, ValueError) as error:
            raise OSError("this picture cannot be decoded") from error

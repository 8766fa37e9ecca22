"""Who looked at a picture and when, burnt into the copy that leaves; what is kept stays as it was taken."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

QUALITY = 90
_MARGIN_PX = 6


def watermarked(path: Path, text: str) -> bytes:
    """Return a JPEG with a line of text at its lower edge; blocking.

    The file passed ``read_picture`` when it was kept, so that its size is bounded. Raises ``OSError`` for one that
    cannot be decoded.
    """
    from PIL import Image, ImageDraw, ImageFont  # few installations want this; it must not slow every start

    with warnings.catch_warnings():
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        try:
            with Image.open(path, formats=("JPEG", "PNG")) as opened:
                picture = opened.convert("RGB")
        except (Image.DecompressionBombError, Image.DecompressionBombWarning, SyntaxError, ValueError) as error:
            raise OSError(f"{path.name} cannot be drawn on") from error
    font = ImageFont.load_default(size=max(12, picture.height // 40))
    pen = ImageDraw.Draw(picture, "RGBA")
    left, top, right, bottom = pen.textbbox((0, 0), text, font=font)
    y = picture.height - (bottom - top) - 2 * _MARGIN_PX
    pen.rectangle((0, y, right - left + 2 * _MARGIN_PX, picture.height), fill=(0, 0, 0, 160))
    pen.text((_MARGIN_PX - left, y + _MARGIN_PX - top), text, font=font, fill=(255, 255, 255, 255))
    made = io.BytesIO()
    picture.save(made, "JPEG", quality=QUALITY)
    return made.getvalue()

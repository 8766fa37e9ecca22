"""Small text in a picture: robot, camera and time."""

from __future__ import annotations

from datetime import UTC, datetime
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from backend_clients.simulator.cameras.scene import Look

SHOT_S = 0.8
SHOWN_ZOOM = 1.01


@lru_cache(maxsize=8)
def font(size_px: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return Pillow's own font."""
    return ImageFont.load_default(size_px)


def write_caption(pixels: NDArray[np.uint32], look: Look, *, is_lit: bool = False) -> NDArray[np.uint32]:
    """Write who looks, when, how near, and whether by the lamp, into the lower left corner; return the picture."""
    pixels = pixels if pixels.flags.writeable else pixels.copy()
    high, wide = pixels.shape
    more = (f"  {look.zoom:.1f}x" if look.zoom > SHOWN_ZOOM else "") + ("  lamp" if is_lit else "")
    when = datetime.fromtimestamp(look.wall_ms // 1000, UTC)
    ink = _label(f"{look.robot}  {look.camera}  {when:%Y-%m-%d %H:%M:%S} UTC{more}", wide)
    part = pixels[high - ink.shape[0] :, : ink.shape[1]]
    part[...] = (part >> np.uint32(1)) & np.uint32(0x7F7F7F7F)
    part[ink] = np.uint32(0xFFF4F6F4)
    if look.age_of_shot_s < SHOT_S:
        edge = max(wide // 90, 4)
        for border in (pixels[:edge], pixels[-edge:], pixels[:, :edge], pixels[:, -edge:]):
            border[...] = np.uint32(0xFFFFFFFF)
    return pixels


@lru_cache(maxsize=32)  # a second's text serves all pictures of that second
def _label(text: str, wide_px: int) -> NDArray[np.bool_]:
    size = max(round(wide_px / 58), 10)
    length = min(round(font(size).getlength(text) + size), wide_px)
    label = Image.new("L", (length, round(size * 1.6)), 0)
    ImageDraw.Draw(label).text((size * 0.5, size * 0.2), text, fill=255, font=font(size))
    return np.asarray(label) > 110

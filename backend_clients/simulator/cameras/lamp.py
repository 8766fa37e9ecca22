"""What is seen of a picture in the light there is: daylight, the machine's lamp, infrared, or false colours."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image

if TYPE_CHECKING:
    from backend_clients.simulator.cameras.composer import Canvas

HIGH_M = 6.0
LOW_LIGHT = (0.4, 0.44, 0.5)  # what a flying camera makes of a night without a lamp
WARM = (1.02, 0.98, 0.88)
BY_DAY = 0.5  # of its strength is seen of a lamp beside the sun
NEAR_INFRARED = (-1.1, 2.5, -0.35, 0.0)  # leaves shine, soil does not
# near infrared, red and green are shown as red, green and blue
FALSE_COLOURS = (*NEAR_INFRARED, 0.85, 0.0, 0.0, 0.0, 0.0, 0.95, 0.0, 0.0)


def lit(image: Image.Image, canvas: Canvas) -> NDArray[np.uint32]:
    """Return the pixels of a picture as the camera sees them."""
    is_infrared = canvas.mount.kind == "infrared"
    if is_infrared:
        image = image.convert("RGB").convert("L", NEAR_INFRARED).convert("RGB").convert("RGBX")
    elif canvas.mount.kind == "multispectral":
        image = image.convert("RGB").convert("RGB", FALSE_COLOURS).convert("RGBX")
    pixels = np.asarray(image)
    high, wide = pixels.shape[:2]
    is_lit = canvas.is_lit or is_infrared
    if canvas.light.day < 0.98 or is_lit:
        gains = tuple(round(g, 2) for g in canvas.light.gain)
        if is_infrared:
            gains = (gains[1], gains[1], gains[1])
        if canvas.eye.z_m > HIGH_M:
            gains = tuple(max(gain, least) for gain, least in zip(gains, LOW_LIGHT, strict=True))
        pitch = round(canvas.eye.pitch_rad, 1)
        lamp_m = canvas.mount.lamp_m if is_lit and canvas.eye.z_m <= HIGH_M else 0.0
        gain = _gain_map(wide, high, gains, lamp_m, round(canvas.light.day, 1), pitch)
        pixels = np.minimum((pixels * gain) >> 8, 255).astype(np.uint8)
    return np.ascontiguousarray(pixels).view(np.uint32).reshape(high, wide)


@lru_cache(maxsize=24)
def _gain_map(
    wide: int, high: int, ambient: tuple[float, ...], lamp_m: float, day: float, pitch: float
) -> NDArray[np.uint16] | NDArray[np.uint32]:
    """Return the light on each pixel and colour in 256ths, shape (high, wide, 4); ``lamp_m`` 0 is no lamp.

    Times a pixel, 16 bits hold up to 257 of them: more than full light is twice as wide.
    """
    total = np.empty((high, wide, 4), dtype=np.float32)
    total[:] = (*ambient, 1.0)
    most = 256.0
    if lamp_m:
        y, x = np.mgrid[0:high, 0:wide].astype(np.float32)
        # a cone that falls on the ground ahead: widest below, gone above the horizon
        horizon = 0.5 + pitch / 1.1
        down = np.clip((y / high - horizon) / max(1.05 - horizon, 0.2), 0, 1) if pitch > -1.2 else np.full_like(x, 0.62)
        side = (x / wide - 0.5) / (0.30 + 0.42 * down)
        cone = np.exp(-(side**2) * 1.6) * np.exp(-(((down - 0.55) / 0.42) ** 2)) if pitch > -1.2 else _spot(x, y)
        cone *= np.clip(down * 8, 0, 1)  # the sky gives nothing back
        warm = np.array((*(WARM if len(set(ambient)) > 1 else (1.0, 1.0, 1.0)), 0.0), dtype=np.float32)
        total += cone[:, :, None] * warm * min(0.8 + lamp_m / 30, 1.15) * (1 - (1 - BY_DAY) * day)
        most += 256 * BY_DAY * day
    shares: NDArray[np.uint16] | NDArray[np.uint32] = np.clip(total * 256, 0, most).astype(np.uint16)
    if most > 256:
        shares = shares.astype(np.uint32)
    shares[:, :, 3] = 256
    return shares


def _spot(x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.float32]:
    high, wide = x.shape
    away = np.hypot((x / wide - 0.5) * wide / high, y / high - 0.5)
    spot: NDArray[np.float32] = np.exp(-((away / 0.62) ** 4)).astype(np.float32)
    return spot

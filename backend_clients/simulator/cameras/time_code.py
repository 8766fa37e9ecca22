"""The capture time in the pixels: two rows of 24 squares at the top left, the second inverted.

White is 1, most significant bit first: the lower 24 bits of the wall clock in milliseconds.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

BITS = 24
LEAST_PX, SHARE = 4, 80


def square_px(width_px: int) -> int:
    """Return the side of a square in a picture of this width."""
    return max(LEAST_PX, width_px // SHARE)


def burn(pixels: NDArray[np.uint32], wall_ms: int) -> None:
    """Write the code into a picture of packed RGBX pixels, shape (height, width)."""
    side = min(square_px(pixels.shape[1]), pixels.shape[1] // BITS)
    bits = (wall_ms >> np.arange(BITS - 1, -1, -1)) & 1
    rows = np.stack((bits, 1 - bits)).astype(np.uint32) * np.uint32(0x00FFFFFF) | np.uint32(0xFF000000)
    pixels[: 2 * side, : BITS * side] = rows.repeat(side, axis=0).repeat(side, axis=1)


def read(picture: NDArray[Any]) -> int | None:
    """Return the 24 bits of a picture, shape (height, width[, colours]); ``None`` if it says nothing."""
    grey = picture.mean(axis=2) if picture.ndim == 3 else picture
    side = square_px(grey.shape[1])
    at = np.arange(BITS) * side + side // 2
    if grey.shape[0] < 2 * side or at[-1] >= grey.shape[1]:
        return None
    first, second = grey[side // 2, at] > 127, grey[side + side // 2, at] > 127
    if (first == second).any():
        return None
    return int("".join("1" if bit else "0" for bit in first), 2)

"""Draws a tiled ground, or leaves above it, in perspective: each pixel looks up where its ray meets the plane.

Places on a tile are 32-bit fractions of its period, so that they wrap by themselves.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from backend_clients.simulator.cameras.eye import Eye, Floats
from backend_clients.simulator.cameras.row_frame import straightened
from backend_clients.simulator.cameras.scene import Rows
from backend_clients.simulator.cameras.textures import Tile

Pixels = NDArray[np.uint32]
Mask = NDArray[np.bool_]
FAR_M = 900.0
PATCH_PX = 24
CHUNK_PX = 80000
LEAF = np.uint32(0x60000000)  # alpha from which a canopy's pixel is a leaf
ONE = float(1 << 32)


@dataclass(frozen=True, slots=True)
class Frame:
    """How a tile lies on the ground: its corner and the direction it runs along; bent ones as ``scene.Rows``."""

    x_m: float = 0.0
    y_m: float = 0.0
    bearing_rad: float = 0.0
    bend_1pm: float = 0.0
    along_m: float = 0.0
    across_m: float = 0.0


def frame_of(rows: Rows) -> Frame:
    """Return how the tile of a crop lies along its rows."""
    return Frame(*rows.anchor, rows.bearing_rad, rows.bend_1pm, *rows.at)


@dataclass(frozen=True, slots=True)
class Bands:
    """Pixel rows that meet a plane, cut where another size of the tile fits: ``(first, end, level)`` each."""

    runs: tuple[tuple[int, int, int], ...]
    reach_m: Floats
    ahead: Floats


def bands(eye: Eye, tile: Tile, plane_m: float, nearest_m: float = 0.0, furthest_m: float = FAR_M) -> Bands:
    """Return the rows whose rays meet the plane between two distances."""
    flat = Eye(0.0, 0.0, eye.z_m, 0.0, eye.pitch_rad, eye.width_px, eye.height_px, eye.focal_px)
    return _bands(flat, plane_m, nearest_m, furthest_m, tile.texel_m, len(tile.levels))


@lru_cache(maxsize=1024)
def _bands(eye: Eye, plane_m: float, nearest_m: float, furthest_m: float, texel_m: float, levels: int) -> Bands:
    reach, ahead = eye.ground_rows(plane_m)
    is_met = np.isfinite(reach) & (reach * np.hypot(ahead, 0.2) < furthest_m) & (reach >= nearest_m)
    rows = np.flatnonzero(is_met)
    if not len(rows):
        return Bands((), reach, ahead)
    # a pixel shows more ground along the view than across it; between the two neither blurs nor flickers
    across_m = reach[rows] / eye.focal_px
    along_m = across_m * np.maximum(reach[rows] / max(eye.z_m - plane_m, 0.05), 1.0)
    size = across_m**0.62 * along_m**0.38 / texel_m
    fits = np.clip(np.floor(np.log2(np.maximum(size, 1e-6)) + 0.35), 0, levels - 1).astype(int)
    cuts = np.flatnonzero((np.diff(fits) != 0) | (np.diff(rows) != 1)) + 1
    edges = [0, *cuts.tolist(), len(rows)]
    runs = tuple((int(rows[a]), int(rows[b - 1]) + 1, int(fits[a])) for a, b in itertools.pairwise(edges))
    return Bands(runs, reach, ahead)


def paint(
    canvas: Pixels,
    eye: Eye,
    tile: Tile,
    frame: Frame,
    *,
    plane_m: float = 0.0,
    nearest_m: float = 0.0,
    furthest_m: float = FAR_M,
    mask: Mask | None = None,
    is_canopy: bool = False,
) -> None:
    """Draw a tile into ``canvas``, shape (height, width); a canopy covers only where it has leaves."""
    found = bands(eye, tile, plane_m, nearest_m, furthest_m)
    for first, end, level, index in _chunks(eye, tile, frame, found, mask):  # clip: twice as fast as checking
        if mask is None and not is_canopy:
            np.take(tile.levels[level], index, out=canvas[first:end], mode="clip")
            continue
        pixels = np.take(tile.levels[level], index, mode="clip")
        where = None if mask is None else mask[first:end]
        if is_canopy:
            leaves = pixels >= LEAF
            where = leaves if where is None else np.logical_and(leaves, where, out=leaves)
        np.copyto(canvas[first:end], pixels, where=where if where is not None else True)


def canopy_mask(eye: Eye, tile: Tile, frame: Frame, plane_m: float, furthest_m: float) -> Mask:
    """Return where leaves at a height are seen, shape (height, width)."""
    seen = np.zeros((eye.height_px, eye.width_px), dtype=bool)
    found = bands(eye, tile, plane_m, 0.0, furthest_m)
    for first, end, level, index in _chunks(eye, tile, frame, found, None):
        seen[first:end] = np.take(tile.levels[level], index, mode="clip") >= LEAF
    return seen


def _chunks(
    eye: Eye, tile: Tile, frame: Frame, found: Bands, mask: Mask | None
) -> Iterator[tuple[int, int, int, NDArray[np.int64]]]:
    """Yield some rows at a time, so that what is worked on stays in the processor's cache."""
    if not found.runs:
        return
    step = max(CHUNK_PX // eye.width_px, 4)
    metres = _metres(eye, frame, found)
    laid = _fixed(metres, np.array((tile.along_m, tile.across_m) * 2)[:, None])
    for run_first, run_end, level in found.runs:
        for first in range(run_first, run_end, step):
            end = min(first + step, run_end)
            if mask is None or mask[first:end].any():
                if frame.bend_1pm:
                    down, over = _bent(tile, metres[:, first:end, None], eye.width_px, frame)
                else:
                    down, over = _even(laid[:, first:end, None], eye.width_px)
                yield first, end, level, _places(tile, down, over, level)


def _metres(eye: Eye, frame: Frame, found: Bands) -> Floats:
    """Return for each row where its first pixel is in the frame, along and across, and the steps on; (4, rows)."""
    reach, ahead = np.where(np.isfinite(found.reach_m), found.reach_m, 0.0), found.ahead
    turn = eye.yaw_rad - frame.bearing_rad
    cos, sin = math.cos(turn), math.sin(turn)
    dx, dy = eye.x_m - frame.x_m, eye.y_m - frame.y_m
    fc, fs = math.cos(frame.bearing_rad), math.sin(frame.bearing_rad)
    side = (0.5 - eye.middle[0]) / eye.focal_px
    return np.stack(
        (
            dx * fc + dy * fs + reach * (ahead * cos + side * sin),
            dy * fc - dx * fs + reach * (ahead * sin - side * cos),
            reach * sin / eye.focal_px,
            -reach * cos / eye.focal_px,
        )
    )


def _even(laid: NDArray[np.uint32], wide_px: int) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """Return where the pixels of some rows are on the tile; ``laid`` are fractions, shape (4, rows, 1)."""
    along, across, along_step, across_step = laid
    columns = np.arange(wide_px, dtype=np.uint32)[None, :]
    down = along_step * columns
    down += along
    over = across_step * columns
    over += across
    return down, over


def _bent(tile: Tile, metres: Floats, wide_px: int, frame: Frame) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """Return the same along rows that bend; ``metres`` has shape (4, rows, 1)."""
    ahead, left, ahead_step, left_step = metres.astype(np.float32)
    columns = np.arange(wide_px, dtype=np.float32)[None, :]
    along, across = straightened(
        ahead + ahead_step * columns, left + left_step * columns, frame.bend_1pm, frame.across_m
    )
    # the first row's own place is taken off before: a hundred metres in 32 bits are too coarse for leaves
    start, side = frame.along_m % tile.along_m, frame.across_m % tile.across_m
    return _fixed(along + np.float32(start), tile.along_m), _fixed(across + np.float32(side), tile.across_m)


def _places(tile: Tile, down: NDArray[np.uint32], over: NDArray[np.uint32], level: int) -> NDArray[np.int64]:
    """Return the flat places on a tile's level; works in the arrays it is given."""
    bits_down, bits_over = tile.along_bits - level, tile.across_bits - level
    down >>= np.uint32(32 - bits_down)
    down <<= np.uint32(bits_over)
    over >>= np.uint32(32 - bits_over)
    down |= over
    found: NDArray[np.int64] = down.astype(np.int64)
    return found


def _fixed(metres: Floats | NDArray[np.float32], period_m: float | Floats) -> NDArray[np.uint32]:
    """Return lengths as 32-bit fractions of a period."""
    share = metres / period_m
    share -= np.floor(share)
    return (share * ONE).astype(np.uint64).astype(np.uint32)


def paint_patches(canvas: Pixels, eye: Eye, first_row: int) -> None:
    """Let large patches of a ground seen from above be lighter and darker, as wet and dry ones are."""
    high, wide = eye.height_px - first_row, eye.width_px
    small = (max(wide // PATCH_PX, 2), max(high // PATCH_PX, 2))
    v = np.linspace(first_row, eye.height_px - 1, small[1]).astype(int)
    reach, ahead = eye.ground_rows()
    far = np.minimum(reach[v], FAR_M)[:, None]
    side = ((np.linspace(0, wide, small[0]) - eye.middle[0]) / eye.focal_px)[None, :]
    cos, sin = math.cos(eye.yaw_rad), math.sin(eye.yaw_rad)
    x = eye.x_m + far * (ahead[v][:, None] * cos + side * sin)
    y = eye.y_m + far * (ahead[v][:, None] * sin - side * cos)
    total = sum(
        high_share * np.sin(x * kx + 1.7 * np.sin(y * ky * 0.7)) * np.sin(y * ky + 1.3 * np.sin(x * kx * 0.6))
        for high_share, kx, ky in ((0.6, 0.11, 0.13), (0.5, 0.31, 0.27), (0.3, 0.83, 0.71))
    )
    gain = np.clip(128 * (1 + 0.16 * np.asarray(total)), 0, 255).astype(np.uint8)
    smooth = np.asarray(Image.fromarray(gain).resize((wide, high), Image.Resampling.BILINEAR))
    part = canvas[first_row:].view(np.uint8).reshape(high, wide, 4)
    lit = (part.astype(np.uint16) * smooth[:, :, None]) >> 7
    part[:, :, :3] = np.minimum(lit, 255)[:, :, :3]

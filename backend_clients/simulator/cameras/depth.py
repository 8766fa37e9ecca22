"""The time-of-flight camera: how far each pixel is, in false colours from 0.3 m to 5 m; nothing beyond."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from backend_clients.simulator.cameras.bodies import box_of
from backend_clients.simulator.cameras.caption import font
from backend_clients.simulator.cameras.crops import LEAVES_SHARE, crop_of
from backend_clients.simulator.cameras.ground_painter import canopy_mask, frame_of
from backend_clients.simulator.cameras.leaves import person_stamp
from backend_clients.simulator.cameras.textures import field_of

if TYPE_CHECKING:
    from backend_clients.simulator.cameras.composer import Canvas

NEAREST_M, FURTHEST_M = 0.3, 5.0
STOPS = (
    (0.0, (122, 4, 3)), (0.12, (218, 57, 7)), (0.27, (254, 155, 45)), (0.42, (210, 233, 53)), (0.56, (97, 252, 108)),
    (0.7, (24, 214, 203)), (0.85, (70, 107, 227)), (1.0, (48, 18, 59)),
)  # fmt: skip
NOTHING = (14, 14, 18)


def distances(canvas: Canvas) -> NDArray[np.float32]:
    """Return metres along each pixel's ray, ``inf`` where nothing answers; shape (height, width)."""
    eye = canvas.eye
    side = ((np.arange(eye.width_px) + 0.5 - eye.middle[0]) / eye.focal_px)[None, :]
    down = ((np.arange(eye.height_px) + 0.5 - eye.middle[1]) / eye.focal_px)[:, None]
    stretch = np.sqrt(1 + side**2 + down**2)
    reach, _ = eye.ground_rows()
    found = (reach[:, None] * stretch).astype(np.float32)
    rows = canvas.stage.field_at(canvas.look, eye.x_m + 2 * np.cos(eye.yaw_rad), eye.y_m + 2 * np.sin(eye.yaw_rad))
    if rows is not None:
        tiles, high = field_of(rows), crop_of(rows.crop).high_m
        plane = LEAVES_SHARE * high
        leaves = canopy_mask(eye, tiles.leaves, frame_of(rows), plane, FURTHEST_M + 1)
        above, _ = eye.ground_rows(plane)
        np.copyto(found, (above[:, None] * stretch).astype(np.float32), where=leaves)
    for thing in canvas.look.things:
        box = box_of(eye, thing) if thing.kind in ("person", "stump", "stone", "weeder", "planter") else None
        if box is None:
            continue
        left, top, right, low = (round(value) for value in box)
        if right <= left or low <= top:
            continue
        _, _, depth = eye.project(np.array([(thing.x_m, thing.y_m, 0.8)]))
        part = found[top:low, left:right]
        shape = np.ones(part.shape, dtype=bool)
        if thing.kind == "person":
            stamp = person_stamp().getchannel("A").resize((right - left, low - top))
            shape = np.asarray(stamp) > 127
        here = (float(depth[0]) * stretch[top:low, left:right]).astype(np.float32)
        np.copyto(part, here, where=shape & (here < part))
    return found


def draw_depth(canvas: Canvas) -> None:
    """Draw distances as colours, with their scale at the right."""
    found = distances(canvas)
    rng = np.random.default_rng(canvas.look.wall_ms & 0xFFFF)
    with np.errstate(invalid="ignore"):
        found = found * (1 + 0.006 * rng.standard_normal(found.shape, dtype=np.float32))
    share = (found - NEAREST_M) / (FURTHEST_M - NEAREST_M)
    step = np.where((share >= 0) & (share <= 1), np.clip(share, 0, 1) * 254, 255).astype(np.uint8)
    canvas.pixels = _scale(_ramp()[step])
    from backend_clients.simulator.cameras.composer import note_standing

    note_standing(canvas, FURTHEST_M)


@lru_cache(maxsize=1)
def _ramp() -> NDArray[np.uint32]:
    at = np.linspace(0, 1, 255)
    four = np.full((256, 4), 255, dtype=np.uint8)
    for k in range(3):
        four[:255, k] = np.interp(at, [s for s, _ in STOPS], [c[k] for _, c in STOPS])
    four[255, :3] = NOTHING
    return four.view(np.uint32)[:, 0]


def _scale(pixels: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """Draw the scale of colours with its metres."""
    high, wide = pixels.shape
    bar, top, low = max(wide // 40, 6), round(high * 0.2), round(high * 0.8)
    ramp = _ramp()[np.linspace(254, 0, low - top).astype(np.uint8)]
    pixels[top - 1 : low + 1, wide - 2 * bar - 1 : wide - bar + 1] = np.uint32(0xFF000000)
    pixels[top:low, wide - 2 * bar : wide - bar] = ramp[:, None]
    image = Image.fromarray(np.ascontiguousarray(pixels).view(np.uint8).reshape(high, wide, 4), "RGBX")
    draw = ImageDraw.Draw(image)
    for metres in (0.3, 1, 2, 3, 4, 5):
        y = low - (metres - NEAREST_M) / (FURTHEST_M - NEAREST_M) * (low - top)
        text = f"{metres:g} m" if metres in (0.3, 5) else f"{metres:g}"
        draw.text((wide - 2 * bar - 4, y), text, fill=(240, 240, 240), font=font(max(high // 26, 9)), anchor="rm",
                  stroke_width=1, stroke_fill=(0, 0, 0))  # fmt: skip
    return np.asarray(image).reshape(high, -1).view(np.uint32).copy()

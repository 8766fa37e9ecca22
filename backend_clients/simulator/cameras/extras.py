"""What belongs to one view only: marks of the tracks, the laser's frame and beam, the planting point, a UAV's cross."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from backend_clients.simulator.cameras.bodies import paste
from backend_clients.simulator.cameras.leaves import seedling_stamp
from backend_clients.simulator.cameras.shapes import disc
from backend_clients.simulator.cameras.solid_painter import ring3

if TYPE_CHECKING:
    from backend_clients.simulator.cameras.composer import Canvas

TRACK_M = {"weeder": (0.75, 0.3), "planter": (1.05, 0.5)}
TOOL_BACK_M = -0.8


def paint_tracks(canvas: Canvas, mask: NDArray[np.bool_] | None) -> None:
    """Press the marks of the tracks into the ground of a camera that looks back."""
    look, eye = canvas.look, canvas.eye
    if canvas.mount.view not in ("rear", "tool") or len(look.trail) < 2 or look.family not in TRACK_M:
        return
    marks = Image.new("L", (eye.width_px, eye.height_px), 0)
    draw = ImageDraw.Draw(marks)
    gauge_m, wide_m = TRACK_M[look.family]
    way = np.asarray(look.trail)
    steps = np.gradient(way, axis=0)
    normal = np.column_stack((-steps[:, 1], steps[:, 0])) / np.maximum(np.hypot(*steps.T), 1e-6)[:, None]
    for side in (gauge_m, -gauge_m):
        left, right = way + normal * (side + wide_m / 2), way + normal * (side - wide_m / 2)
        ring = np.concatenate((left, right[::-1]))
        outline = eye.outline(np.column_stack((ring, np.zeros(len(ring)))))
        if len(outline) >= 3:
            draw.polygon(outline, fill=255)
    where = np.asarray(marks) > 0
    if mask is not None:
        where &= mask
    dark = canvas.pixels - ((canvas.pixels >> np.uint32(2)) & np.uint32(0x003F3F3F))
    np.copyto(canvas.pixels, dark, where=where)


def draw_over(image: Image.Image, draw: ImageDraw.ImageDraw, canvas: Canvas) -> None:
    """Draw what is before everything else."""
    match canvas.mount.view:
        case "tool":
            _tool(draw, canvas)
        case "head":
            _head(image, draw, canvas)
        case _:
            return


def _tool(draw: ImageDraw.ImageDraw, canvas: Canvas) -> None:
    """Draw the frame of the laser and its beam on the weed it is at."""
    eye, look = canvas.eye, canvas.look
    cos, sin = math.cos(look.theta_rad), math.sin(look.theta_rad)

    def at(forward: float, left: float, z: float = 0.0) -> NDArray[np.float64]:
        return np.array((look.x_m + forward * cos - left * sin, look.y_m + forward * sin + left * cos, z))

    wide, high = eye.width_px, eye.height_px
    bar = max(high // 26, 8)
    for top in (0, high - bar):
        draw.rectangle((0, top, wide, top + bar), fill=(40, 42, 44))
        draw.line((0, top + (bar if top == 0 else 0), wide, top + (bar if top == 0 else 0)), fill=(92, 96, 98), width=2)
    _, v, _ = eye.project(np.array([at(TOOL_BACK_M, -0.72), at(TOOL_BACK_M, 0.72)]))
    dash = max(wide // 60, 6)
    for begin in range(0, wide, dash * 2):
        draw.line((begin, float(v[0]), begin + dash, float(v[0])), fill=(210, 196, 120), width=max(wide // 400, 1))
    if not look.is_tool_on:
        return
    target = _next_weed(canvas, float(v[0]))
    if target is None:
        return
    x, y = target
    for radius, colour in ((22, (255, 120, 90)), (12, (255, 190, 150)), (6, (255, 255, 255))):
        px = radius * wide / 900
        draw.ellipse((x - px, y - px, x + px, y + px), fill=colour)
    draw.line((wide / 2, 0, x, y), fill=(255, 150, 120), width=max(wide // 320, 2))


def _next_weed(canvas: Canvas, line_px: float) -> tuple[float, float] | None:
    """Return the middle of the weed nearest before the laser's line."""
    best = None
    for box in canvas.boxes:
        if box.kind != "weed" or box.hit is not None:
            continue
        x = (box.x + box.w / 2) * canvas.eye.width_px
        y = (box.y + box.h / 2) * canvas.eye.height_px
        if best is None or abs(y - line_px) < abs(best[1] - line_px):
            best = (x, y)
    return best if best is not None and abs(best[1] - line_px) < 0.3 * canvas.eye.height_px else None


def _head(image: Image.Image, draw: ImageDraw.ImageDraw, canvas: Canvas) -> None:
    """Draw the planting point, the head's jaws and the seedling it holds."""
    look, eye = canvas.look, canvas.eye
    crane = look.crane
    if crane is None:
        return
    for thing in look.things:
        if thing.kind == "tree" and thing.state in ("current", "planned"):
            outline = eye.outline(ring3(disc(thing.x_m, thing.y_m, 0.2, 40), 0.0))
            if len(outline) > 2:
                colour = (250, 250, 246) if thing.state == "current" else (170, 176, 170)
                draw.line([*outline, outline[0]], fill=colour, width=max(eye.width_px // 240, 2))
    wide, high = eye.width_px, eye.height_px
    for side in (-1, 1):
        x, tip = wide / 2 + side * wide * 0.5, wide / 2 + side * wide * 0.34
        jaw = [(x, high * 0.36), (tip, high * 0.44), (tip, high * 0.56), (x, high * 0.64)]
        draw.polygon(jaw, fill=(70, 74, 76), outline=(110, 114, 116))
    if crane.is_loaded:
        size = high * 0.62
        paste(image, seedling_stamp(), wide * 0.5 - size / 2, high * 0.5 - size / 2, size, size)

"""Composes one picture: sky, ground, plants, what stands on it, the tool's work, lamp light, time code."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from backend_clients.simulator.cameras import depth, extras, time_code
from backend_clients.simulator.cameras.bodies import box_of, draw_crane, draw_solid, draw_thing
from backend_clients.simulator.cameras.caption import write_caption
from backend_clients.simulator.cameras.crops import LEAVES_SHARE, crop_of
from backend_clients.simulator.cameras.eye import Eye
from backend_clients.simulator.cameras.ground_painter import Frame, frame_of, paint, paint_patches
from backend_clients.simulator.cameras.lamp import lit
from backend_clients.simulator.cameras.mounts import MOUNTS, Mount
from backend_clients.simulator.cameras.scene import Box, Look, Rows, Thing
from backend_clients.simulator.cameras.sky import Light, light_at, paint_sky
from backend_clients.simulator.cameras.stage import Stage, rows_of
from backend_clients.simulator.cameras.textures import far_field, field_of, is_made, plain
from backend_clients.simulator.cameras.weeds import Spot, draw_litter, draw_weeds

Pixels = NDArray[np.uint32]
MOST_PX = 1024  # wider pictures are drawn at half their size: a lens is no sharper
NEAR_M = 5.5  # leaves stand above the ground as far as this
HIGH_UP_M = 6.0  # from there plants are a pattern
THING_FAR_M = 150.0
SEEN_M = 40.0  # nothing is told apart further away
LIKELY = {"person": 0.97, "stump": 0.91, "stone": 0.88}


@dataclass(slots=True)
class Canvas:
    """A picture while it is drawn."""

    look: Look
    mount: Mount
    eye: Eye
    light: Light
    stage: Stage
    pixels: Pixels
    boxes: list[Box] = field(default_factory=list)
    owed: list[Rows] = field(default_factory=list)

    @property
    def is_lit(self) -> bool:
        """Whether its lamp is on."""
        if self.mount.lamp_m <= 0:
            return False
        return self.light.is_dark if self.look.lamp is None else self.look.lamp


def compose(look: Look, stage: Stage, owed: list[Rows] | None = None) -> tuple[Pixels, list[Box]]:
    """Return the picture of a look as packed RGBX pixels, shape (height, width), and what is seen in it.

    Args:
        owed: takes the rows that a hasty look showed as coarse as from afar, for they are not made yet.
    """
    mount = MOUNTS[(look.family, look.camera)]
    half = look.width_px > MOST_PX
    wide, high = (look.width_px // 2, look.height_px // 2) if half else (look.width_px, look.height_px)
    eye = mount.eye(look, wide, high)
    sun_ms = look.wall_ms if look.sun_ms is None else look.sun_ms
    light = light_at(sun_ms, stage.scene.lat_deg, stage.scene.lon_deg)
    canvas = Canvas(look, mount, eye, light, stage, np.empty((high, wide), dtype=np.uint32))
    if mount.kind == "depth":
        depth.draw_depth(canvas)
    else:
        _draw(canvas)
    if owed is not None:
        owed += canvas.owed
    pixels = canvas.pixels
    if half:
        pixels = _doubled(pixels)
    pixels = write_caption(pixels, look, is_lit=canvas.is_lit)
    time_code.burn(pixels, look.wall_ms)
    return pixels, canvas.boxes


def _doubled(pixels: Pixels) -> Pixels:
    """Return a picture with each pixel four times."""
    high, wide = pixels.shape
    large = np.empty((high * 2, wide * 2), dtype=np.uint32)
    broad = pixels.repeat(2, axis=1)
    large[0::2], large[1::2] = broad, broad
    return large


def _draw(canvas: Canvas) -> None:
    eye, look, mount = canvas.eye, canvas.look, canvas.mount
    horizon = paint_sky(canvas.pixels, eye, canvas.light)
    rows = _paint_grounds(canvas, horizon) if horizon < eye.height_px else None
    image = _image(canvas.pixels)
    draw = ImageDraw.Draw(image)
    if eye.z_m < HIGH_UP_M and rows is not None:
        spots = draw_weeds(image, eye, rows, look, canvas.stage)
        canvas.boxes += _weed_boxes(spots, eye, look)
    elif eye.z_m < HIGH_UP_M:
        draw_litter(image, eye, canvas.stage, is_close=mount.view == "head")
    _draw_standing(image, draw, canvas)
    if look.crane is not None and not mount.is_on_crane:
        draw_crane(draw, eye, look.crane)
    extras.draw_over(image, draw, canvas)
    canvas.pixels = lit(image, canvas)


def _paint_grounds(canvas: Canvas, horizon: int) -> Rows | None:
    """Draw every ground in sight; return the rows that grow where the camera looks."""
    eye = canvas.eye
    cover, shown = canvas.stage.cover(eye)
    counts = cover.crop((0, horizon, eye.width_px, eye.height_px)).histogram()
    total = eye.width_px * (eye.height_px - horizon)
    present = [number for number in (0, *shown) if counts[number]]
    numbers = None if counts[present[0]] == total else np.asarray(cover)
    for number in present:
        mask = None if numbers is None else numbers == number
        ground = shown.get(number)
        rows = rows_of(ground, canvas.look) if ground is not None else None
        if rows is not None:
            _paint_field(canvas, rows, mask)
        else:
            close = canvas.mount.view == "head"
            kind = "humus" if close else ground.kind if ground is not None else "grass"
            paint(canvas.pixels, eye, plain(kind), Frame(), mask=mask)
    _paint_haze(canvas, horizon)
    if eye.z_m > HIGH_UP_M:
        paint_patches(canvas.pixels, eye, horizon)
    return canvas.stage.field_at(canvas.look, *_looked_at(eye))


def _paint_field(canvas: Canvas, rows: Rows, mask: NDArray[np.bool_] | None) -> None:
    eye, frame = canvas.eye, frame_of(rows)
    high = crop_of(rows.crop).high_m
    is_far = eye.z_m > HIGH_UP_M or not _is_near(eye, mask)
    is_owed = not is_far and canvas.look.is_hasty and not is_made(rows)
    if is_owed:
        canvas.owed.append(rows)
    if is_far or is_owed:
        paint(canvas.pixels, eye, far_field(rows.crop, rows.spacing_m), frame, mask=mask)
        return
    tiles = field_of(rows)
    plane = LEAVES_SHARE * high
    near = NEAR_M * (eye.z_m - plane) / eye.z_m
    paint(canvas.pixels, eye, tiles.soil, frame, furthest_m=NEAR_M * 1.1, mask=mask)
    paint(canvas.pixels, eye, tiles.whole, frame, plane_m=plane, nearest_m=near, mask=mask)
    extras.paint_tracks(canvas, mask)
    paint(canvas.pixels, eye, tiles.leaves, frame, plane_m=plane, furthest_m=near, mask=mask, is_canopy=True)


def _is_near(eye: Eye, mask: NDArray[np.bool_] | None) -> bool:
    """Say whether part of a ground is so near that its leaves stand out."""
    if mask is None:
        return True
    reach, _ = eye.ground_rows()
    first = int(np.argmax(reach < NEAR_M * 1.3)) if (reach < NEAR_M * 1.3).any() else eye.height_px
    return bool(mask[first:].any())


def _paint_haze(canvas: Canvas, horizon: int) -> None:
    """Let the ground pale towards the horizon."""
    eye = canvas.eye
    last = min(horizon + max(eye.height_px // 14, 2), eye.height_px)
    if horizon <= 0 or last <= horizon:
        return
    share = (np.linspace(0.62, 0.0, last - horizon) * 256).astype(np.uint16)[:, None, None]
    part = canvas.pixels[horizon:last].view(np.uint8).reshape(last - horizon, eye.width_px, 4)
    pale = np.array([round(c * (0.06 + 0.94 * canvas.light.day)) for c in (176, 184, 172)] + [255], dtype=np.uint16)
    part[...] = ((part * (256 - share) + pale * share) >> 8).astype(np.uint8)


def _draw_standing(image: Image.Image, draw: ImageDraw.ImageDraw, canvas: Canvas) -> None:
    eye, look = canvas.eye, canvas.look
    things = [one for one in look.things if math.dist((one.x_m, one.y_m), (eye.x_m, eye.y_m)) < THING_FAR_M]
    flat = [one for one in things if one.kind == "tree"]
    upright = [one for one in things if one.kind != "tree"]
    for tree in sorted(flat, key=lambda one: -_far(one, eye)):
        draw_thing(image, draw, eye, tree)
    solids = canvas.stage.solids(eye)
    ways = [(min(math.dist(p, (eye.x_m, eye.y_m)) for p in one.ring), 0, n) for n, one in enumerate(solids)]
    ways += [(_far(one, eye), 1, n) for n, one in enumerate(upright)]
    for _, kind, n in sorted(ways, reverse=True):
        if kind == 0:
            draw_solid(image, draw, eye, solids[n])
        else:
            draw_thing(image, draw, eye, upright[n])
    note_standing(canvas)


def note_standing(canvas: Canvas, far_m: float = SEEN_M) -> None:
    """Add the boxes of people and obstacles that are in the picture."""
    for thing in canvas.look.things:
        box = box_of(canvas.eye, thing) if thing.kind in LIKELY and _far(thing, canvas.eye) <= far_m else None
        if box is not None:
            kind = "person" if thing.kind == "person" else "obstacle"
            canvas.boxes.append(share_box(canvas.eye, kind, box, LIKELY[thing.kind]))


def _weed_boxes(spots: list[Spot], eye: Eye, look: Look) -> list[Box]:
    unsure = 0.42 if look.is_unsure else 0.0
    hits = {-1: None, 0: False, 1: True}
    return [share_box(eye, "weed", s.box, round(s.score - unsure, 2), hits[s.outcome]) for s in spots]


def share_box(
    eye: Eye, kind: str, box: tuple[float, float, float, float], score: float, hit: bool | None = None
) -> Box:
    """Return a box in pixels as shares of the picture."""
    left, top, right, low = box
    wide, high = eye.width_px, eye.height_px
    return Box(
        kind, round(left / wide, 4), round(top / high, 4), round((right - left) / wide, 4),
        round((low - top) / high, 4), round(score, 2), hit,
    )  # fmt: skip


def _looked_at(eye: Eye) -> tuple[float, float]:
    """Return the ground three metres ahead, or below a camera that looks down."""
    ahead = 0.0 if eye.pitch_rad < -1.2 else 3.0
    return eye.x_m + ahead * math.cos(eye.yaw_rad), eye.y_m + ahead * math.sin(eye.yaw_rad)


def _far(thing: Thing, eye: Eye) -> float:
    return math.dist((thing.x_m, thing.y_m), (eye.x_m, eye.y_m))


def _image(pixels: Pixels) -> Image.Image:
    high, wide = pixels.shape
    return Image.frombuffer("RGBX", (wide, high), np.ascontiguousarray(pixels), "raw", "RGBX", 0, 1)

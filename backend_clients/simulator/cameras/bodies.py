"""How machines, people, stumps, trees, hedges and buildings look from a camera, and the boxes around them."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw

from backend_clients.simulator.cameras.eye import Eye, Floats
from backend_clients.simulator.cameras.leaves import person_stamp, seedling_stamp
from backend_clients.simulator.cameras.scene import Crane, Solid, Thing
from backend_clients.simulator.cameras.shapes import disc, oblong
from backend_clients.simulator.cameras.solid_painter import beam, block, fill, ring3, shaded

PERSON_M = 1.78
MOST_SIZES = 3000
LARGE_PX, LADDER = 72, 1.15
MOST_BUSHES = 90
BUSH = [(shaded((66, 98, 52), 0.66 + 0.06 * k), shaded((80, 114, 62), 0.66 + 0.06 * k)) for k in range(8)]
_SIZES: dict[tuple[int, int, int], tuple[Image.Image, Image.Image]] = {}
WHITE, DARK, GREEN, ORANGE, STEEL = (226, 228, 222), (46, 48, 50), (64, 118, 84), (214, 120, 42), (150, 154, 158)


def draw_solid(image: Image.Image, draw: ImageDraw.ImageDraw, eye: Eye, solid: Solid) -> None:
    """Draw a building, hedge, pylon or the like."""
    if solid.kind == "hedge":
        _hedge(draw, eye, solid)
    elif solid.kind == "building":
        block(draw, eye, solid.ring, 0.0, solid.height_m, (172, 150, 128), (132, 82, 68))
        _ridge(draw, eye, solid)
    else:
        wall, roof = ((122, 126, 130), (150, 154, 158)) if solid.kind == "pylon" else ((128, 124, 116), (152, 148, 140))
        block(draw, eye, solid.ring, 0.0, solid.height_m, wall, roof)


def draw_thing(image: Image.Image, draw: ImageDraw.ImageDraw, eye: Eye, thing: Thing) -> None:
    """Draw a machine, a person, an obstacle or a planted tree."""
    match thing.kind:
        case "person":
            _person(image, draw, eye, thing)
        case "weeder":
            _weeder(draw, eye, thing)
        case "planter":
            _planter(draw, eye, thing)
        case "uav":
            _uav(draw, eye, thing)
        case "stump":
            block(
                draw, eye, disc(thing.x_m, thing.y_m, thing.radius_m), 0, thing.height_m, (92, 70, 48), (176, 142, 96)
            )
            inner = ring3(disc(thing.x_m, thing.y_m, thing.radius_m * 0.55), thing.height_m)
            fill(draw, eye, inner, (156, 120, 78))
        case "stone":
            ring = disc(thing.x_m, thing.y_m, thing.radius_m, 8)
            block(draw, eye, ring, 0, thing.height_m * 0.6, (112, 110, 106), (150, 148, 142))
            top = disc(thing.x_m, thing.y_m, thing.radius_m * 0.7, 8)
            block(draw, eye, top, thing.height_m * 0.6, thing.height_m, (126, 124, 118), (168, 166, 160))
        case _:
            _tree(image, draw, eye, thing)


def box_of(eye: Eye, thing: Thing) -> tuple[float, float, float, float] | None:
    """Return left, top, right and bottom in pixels of something that stands, ``None`` if it is not in the picture."""
    high = thing.height_m or PERSON_M
    radius = thing.radius_m or 0.3
    right = eye.turn[:, 0]
    foot = np.array((thing.x_m, thing.y_m, thing.z_m))
    corners = np.array([foot + right * s * radius + (0, 0, z) for s in (-1, 1) for z in (0, high)])
    u, v, depth = eye.project(corners)
    if (depth < 0.3).any():
        return None
    left, top, end, low = float(u.min()), float(v.min()), float(u.max()), float(v.max())
    if end < 0 or left > eye.width_px or low < 0 or top > eye.height_px:
        return None
    return max(left, 0.0), max(top, 0.0), min(end, eye.width_px), min(low, eye.height_px)


def paste(image: Image.Image, stamp: Image.Image, left: float, top: float, wide: float, high: float) -> None:
    """Lay a picture with alpha into another, made as large as asked."""
    w, h = max(round(wide), 1), max(round(high), 1)
    if w > 4 * image.width or h > 4 * image.height:
        return
    colours, alpha = _sized(stamp, w, h)
    image.paste(colours, (round(left), round(top)), alpha)


def _sized(stamp: Image.Image, wide: int, high: int) -> tuple[Image.Image, Image.Image]:
    """Return a stamp in a size, colours and alpha apart; near sizes are the same, so that they can be kept."""
    if wide < LARGE_PX:
        wide, high = _rung(wide), _rung(high)
    else:
        wide, high = wide // 4 * 4, max(high // 4 * 4, 1)
    key = (id(stamp), wide, high)
    found = _SIZES.get(key)
    if found is None:
        if len(_SIZES) > MOST_SIZES:
            _SIZES.clear()
        sized = stamp.resize((wide, high), Image.Resampling.BILINEAR if wide > stamp.width else Image.Resampling.BOX)
        found = _SIZES[key] = (sized.convert("RGB").convert("RGBX"), sized.getchannel("A"))
    return found


@lru_cache(maxsize=256)
def _rung(size: int) -> int:
    """Return the nearest size of a ladder whose rungs are a seventh apart: nobody sees the difference in a weed."""
    return max(round(LADDER ** round(math.log(max(size, 1)) / math.log(LADDER))), 1)


def _person(image: Image.Image, draw: ImageDraw.ImageDraw, eye: Eye, thing: Thing) -> None:
    if eye.pitch_rad < -1.2:  # from above: shoulders and a helmet
        block(draw, eye, oblong(thing.x_m, thing.y_m, 0.6, 0.28, 0.52), 0.6, 1.5, (70, 70, 80), (226, 120, 30))
        block(draw, eye, disc(thing.x_m, thing.y_m, 0.14), 1.5, PERSON_M, (236, 196, 44), (240, 204, 60))
        return
    foot = np.array([(thing.x_m, thing.y_m, 0.0), (thing.x_m, thing.y_m, PERSON_M)])
    u, v, depth = eye.project(foot)
    if (depth < 0.4).any():
        return
    fill(draw, eye, ring3(disc(thing.x_m + 0.12, thing.y_m - 0.1, 0.34), 0.01), (58, 48, 38))
    high = float(v[0] - v[1])
    paste(image, person_stamp(), float(u[0]) - high / 6, float(v[1]), high / 3, high)


def _weeder(draw: ImageDraw.ImageDraw, eye: Eye, t: Thing) -> None:
    at = (t.x_m, t.y_m, t.theta_rad)
    far_first = sorted((0.75, -0.75), key=lambda side: -math.dist(oblong(*at, 0, 0, (0, side))[0], (eye.x_m, eye.y_m)))
    block(draw, eye, oblong(*at, 2.5, 0.32, (0, far_first[0])), 0.0, 0.55, DARK, (60, 62, 64))
    block(draw, eye, oblong(*at, 0.9, 1.3, (-0.75, 0)), 0.3, 0.9, STEEL, (170, 174, 178))
    block(draw, eye, oblong(*at, 2.3, 1.25, (0, 0)), 0.62, 1.25, WHITE, (238, 240, 236))
    block(draw, eye, oblong(*at, 1.0, 1.0, (-0.3, 0)), 1.25, 1.5, GREEN, (74, 134, 96))
    block(draw, eye, oblong(*at, 2.5, 0.32, (0, far_first[1])), 0.0, 0.55, DARK, (60, 62, 64))
    block(draw, eye, oblong(*at, 0.14, 0.14, (1.1, 0)), 1.25, 1.65, DARK, (60, 62, 64))


def _planter(draw: ImageDraw.ImageDraw, eye: Eye, t: Thing) -> None:
    at = (t.x_m, t.y_m, t.theta_rad)
    for along in (2.6, -1.3):
        for side in (1.1, -1.1):
            block(draw, eye, oblong(*at, 1.4, 0.5, (along, side)), 0.0, 1.35, DARK, (58, 60, 62))
    block(draw, eye, oblong(*at, 6.2, 1.6, (0.8, 0)), 0.8, 1.5, STEEL, (160, 164, 160))
    block(draw, eye, oblong(*at, 2.4, 2.2, (2.7, 0)), 1.3, 2.4, ORANGE, (226, 136, 56))
    block(draw, eye, oblong(*at, 1.5, 1.9, (0.7, 0)), 1.4, 3.1, (70, 84, 92), WHITE)
    block(draw, eye, oblong(*at, 0.7, 0.7, (-1.8, 0)), 1.4, 2.4, ORANGE, ORANGE)


def _uav(draw: ImageDraw.ImageDraw, eye: Eye, t: Thing) -> None:
    for turn in (0.785, 2.356):
        arm = oblong(t.x_m, t.y_m, t.theta_rad + turn, 0.9, 0.06)
        block(draw, eye, arm, t.z_m + 0.15, t.z_m + 0.2, DARK, (70, 72, 74))
    block(draw, eye, oblong(t.x_m, t.y_m, t.theta_rad, 0.4, 0.25), t.z_m + 0.05, t.z_m + 0.25, WHITE, WHITE)


def _tree(image: Image.Image, draw: ImageDraw.ImageDraw, eye: Eye, thing: Thing) -> None:
    """A point of the planting plan: planned is nothing to see, done is a seedling, failed is opened soil."""
    if thing.state in ("planned", "skipped"):
        return
    hole = ring3(disc(thing.x_m, thing.y_m, 0.24), 0.005)
    fill(draw, eye, hole, (96, 74, 54))
    fill(draw, eye, ring3(disc(thing.x_m, thing.y_m, 0.15), 0.006), (70, 52, 38))
    if thing.state != "done":
        return
    place = np.array([(thing.x_m, thing.y_m, 0.02), (thing.x_m, thing.y_m, 0.42)])
    u, v, depth = eye.project(place)
    if (depth < 0.2).any():
        return
    wide = 0.34 * eye.focal_px / float(depth[1])
    high = max(abs(float(v[0] - v[1])), wide * 0.55)
    middle = (float(v[0]) + float(v[1])) / 2
    paste(image, seedling_stamp(), float(u[1]) - wide / 2, middle - high * 0.6, wide, high)


def _hedge(draw: ImageDraw.ImageDraw, eye: Eye, solid: Solid) -> None:
    block(draw, eye, solid.ring, 0.0, solid.height_m * 0.8, (52, 78, 44), (74, 104, 58))
    bushes = _bushes(tuple(solid.ring), solid.height_m)
    u, v, depth = eye.project(bushes[:, :3])
    radius = bushes[:, 3] * eye.focal_px / np.maximum(depth, 0.1)
    is_seen = (depth > 1.5) & (radius > 1.6) & (u > -radius) & (u < eye.width_px + radius)
    order = np.flatnonzero(is_seen)
    order = order[np.argsort(-depth[order])][-MOST_BUSHES:]
    for x, y, r, tone in np.column_stack((u, v, radius, bushes[:, 4]))[order].tolist():
        dark, light = BUSH[int(tone * 7.99)]
        draw.ellipse((x - r, y - r * 0.85, x + r, y + r * 0.85), fill=dark)
        if r > 6:
            draw.ellipse((x - r * 0.7, y - r * 0.8, x + r * 0.3, y + r * 0.1), fill=light)


@lru_cache(maxsize=32)
def _bushes(ring: tuple[tuple[float, float], ...], high_m: float) -> Floats:
    """Return x, y, z, radius and tone of the bushes along a hedge's edge."""
    rng = np.random.default_rng(abs(int(sum(x + y for x, y in ring) * 10)) % (1 << 31))
    found = []
    for a, b in zip(ring, ring[1:] + ring[:1], strict=True):
        many = min(int(math.dist(a, b) / 1.3), 140)
        for share, grow, tone in rng.random((many, 3)):
            x, y = a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share
            found.append((x, y, high_m * (0.42 + 0.5 * grow), 0.75 + 0.65 * grow, tone))
    return np.array(found).reshape(-1, 5)


def _ridge(draw: ImageDraw.ImageDraw, eye: Eye, solid: Solid) -> None:
    """Draw the roof of a building of four corners as two slopes."""
    ring = solid.ring[:4]
    if len(solid.ring) not in (4, 5) or len(ring) < 4:
        return
    if math.dist(ring[0], ring[1]) < math.dist(ring[1], ring[2]):
        ring = ring[1:] + ring[:1]
    a, b, c, d = ring
    top = solid.height_m + 2.2
    e = ((a[0] + d[0]) / 2, (a[1] + d[1]) / 2)
    f = ((b[0] + c[0]) / 2, (b[1] + c[1]) / 2)
    h = solid.height_m
    slopes = [
        ([(*a, h), (*b, h), (*f, top), (*e, top)], (150, 84, 66)),
        ([(*d, h), (*c, h), (*f, top), (*e, top)], (122, 66, 54)),
    ]
    slopes.sort(key=lambda one: -math.dist((eye.x_m, eye.y_m), one[0][0][:2]))
    for face, colour in slopes:
        fill(draw, eye, np.array(face), colour)


def draw_crane(draw: ImageDraw.ImageDraw, eye: Eye, crane: Crane) -> None:
    """Draw pillar, boom, stick and planting head."""
    pillar, boom, stick, tip = crane.joints
    beam(draw, eye, (pillar[0], pillar[1], 1.2), pillar, 0.5, ORANGE)
    beam(draw, eye, pillar, boom, 0.36, ORANGE)
    beam(draw, eye, boom, stick, 0.28, (226, 140, 60))
    beam(draw, eye, stick, (tip[0], tip[1], tip[2] + 0.5), 0.12, DARK)
    beam(draw, eye, (tip[0], tip[1], tip[2] + 0.9), tip, 0.3, STEEL)

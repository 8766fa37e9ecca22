"""Plants drawn from above and from the side, as small pictures with alpha."""

from __future__ import annotations

import math
import random
from functools import lru_cache

from PIL import Image, ImageDraw

from backend_clients.simulator.cameras.crops import Crop

Colour = tuple[int, int, int]
TUFT = Crop("blade", 0.2, 0.2, 0.2, (56, 66, 34), (150, 156, 90))
OVER = 3  # drawn larger and made smaller: smooth edges


def mixed(a: Colour, b: Colour, share: float) -> Colour:
    """Return a colour between two."""
    return tuple(round(x + (y - x) * share) for x, y in zip(a, b, strict=True))  # type: ignore[return-value]


def plant_stamp(crop: Crop, size_px: int, turn_rad: float, seed: int, *, is_upper: bool = False) -> Image.Image:
    """Return a plant from above, ``size_px`` wide; the upper half of its leaves only if asked."""
    rng = random.Random(seed)  # noqa: S311
    side = size_px * OVER
    image = Image.new("RGBA", (side, side), (*crop.dark, 0))
    draw = ImageDraw.Draw(image)
    many = {"rosette": 9, "feather": 16, "blade": 7}[crop.shape]
    for n in range(many):
        share = n / many
        if is_upper and share < 0.5:
            rng.random(), rng.random(), rng.random()
            continue
        angle = turn_rad + n * 2.39996 + rng.uniform(-0.25, 0.25)  # golden angle, as leaves do
        long = side / 2 * (1.0 - 0.55 * share) * rng.uniform(0.85, 1.0)
        colour = mixed(crop.dark, crop.light, min(0.3 + 0.6 * share + rng.uniform(-0.1, 0.1), 1.0))
        _leaf(draw, side / 2, angle, long, crop.shape, colour, crop)
    return image.resize((size_px, size_px), Image.Resampling.BOX)


def _leaf(
    draw: ImageDraw.ImageDraw, middle: float, angle: float, long: float, shape: str, colour: Colour, crop: Crop
) -> None:
    wide = long * {"rosette": 0.36, "feather": 0.1, "blade": 0.09}[shape]
    cos, sin = math.cos(angle), math.sin(angle)
    left, right, rib = [], [], []
    for k in range(9):
        t = k / 8
        out = long * (0.06 + 0.94 * t)
        if shape == "rosette":
            half = wide * math.sin(math.pi * t**1.15) ** 0.8 * (1 + 0.1 * math.sin(14 * t)) + long * 0.03 * (1 - t)
        else:
            half = wide * (1 - t) ** 0.6
        bend = long * 0.08 * t * t
        x, y = middle + out * cos - bend * sin, middle + out * sin + bend * cos
        left.append((x - half * sin, y + half * cos))
        right.append((x + half * sin, y - half * cos))
        rib.append((x, y))
    light = mixed(colour, (235, 245, 190), 0.14)
    draw.polygon(left + rib[::-1], fill=(*light, 255))
    draw.polygon(right + rib[::-1], fill=(*mixed(colour, crop.dark, 0.3), 255))
    if shape == "rosette":
        draw.line(rib, fill=(*mixed(colour, (220, 230, 170), 0.5), 255), width=max(round(long * 0.035), 1))


@lru_cache(maxsize=64)
def weed_stamp(kind: int, state: int) -> Image.Image:
    """Return a weed from above, 96 px wide: ``state`` 1 is burnt, else green. Kinds 0 to 5."""
    rng = random.Random(kind)  # noqa: S311
    side = 96 * 2
    image = Image.new("RGBA", (side, side), (60, 90, 40, 0))
    draw = ImageDraw.Draw(image)
    dark, light = ((44, 92, 30), (150, 186, 70)) if kind % 2 else ((64, 100, 44), (172, 190, 96))
    if state == 1:
        draw.ellipse((18, 18, side - 18, side - 18), fill=(34, 26, 20, 130))
        dark, light = (40, 30, 22), (112, 86, 52)
    crop = Crop("rosette" if kind < 4 else "blade", 0.1, 0.1, 0.1, dark, light)
    many = 5 + kind if kind < 4 else 12
    for n in range(many):
        long = side / 2 * rng.uniform(0.6, 0.98) * (0.72 if state == 1 else 1.0)
        colour = mixed(dark, light, rng.uniform(0.2, 0.8))
        _leaf(draw, side / 2, n * 2.39996 + rng.uniform(-0.3, 0.3), long, crop.shape, colour, crop)
    if kind == 2 and state != 1:  # chamomile flowers
        for _ in range(4):
            x, y = (side / 2 + rng.uniform(-0.3, 0.3) * side for _ in range(2))
            draw.ellipse((x - 11, y - 11, x + 11, y + 11), fill=(240, 240, 232, 255))
            draw.ellipse((x - 4, y - 4, x + 4, y + 4), fill=(226, 186, 40, 255))
    return image.resize((96, 96), Image.Resampling.BOX)


@lru_cache(maxsize=32)
def litter_stamp(kind: int, *, is_close: bool) -> Image.Image:
    """Return a tuft of grass, a fern, a twig or a stone, 96 px wide; close ones are smaller things."""
    rng = random.Random(100 + kind)  # noqa: S311
    side = 96 * 2
    image = Image.new("RGBA", (side, side), (96, 92, 60, 0))
    draw = ImageDraw.Draw(image)
    if kind % 3 == 0:
        base: Colour = (70, 96, 46) if kind else (128, 122, 70)
        for n in range(26):
            colour = mixed(base, (168, 164, 98), rng.uniform(0, 0.7))
            _leaf(draw, side / 2, n * 2.4, side / 2 * rng.uniform(0.4, 1.0), "blade", colour, TUFT)
    elif kind % 3 == 1:
        for _ in range(4 if is_close else 7):
            x, y, turn = rng.uniform(40, side - 40), rng.uniform(40, side - 40), rng.uniform(0, 6.3)
            long, wide = rng.uniform(30, 76), 3 if is_close else 5
            line = (
                x - long * math.cos(turn),
                y - long * math.sin(turn),
                x + long * math.cos(turn),
                y + long * math.sin(turn),
            )
            draw.line(line, fill=(*mixed((66, 50, 36), (150, 122, 88), rng.random()), 255), width=wide)
    else:
        for n in range(3):
            x, y, r = side / 2 + rng.uniform(-50, 50), side / 2 + rng.uniform(-40, 40), rng.uniform(14, 36)
            grey = rng.uniform(0.2, 0.9)
            draw.ellipse((x - r, y - r * 0.7 + 8, x + r, y + r * 0.7 + 8), fill=(52, 44, 34, 150))
            draw.ellipse(
                (x - r, y - r * 0.7, x + r, y + r * 0.7), fill=(*mixed((98, 92, 84), (170, 166, 156), grey), 255)
            )
            box = (x - r * 0.7, y - r * 0.6, x + r * 0.4, y + r * 0.1)
            draw.ellipse(box, fill=(*mixed((120, 114, 104), (196, 192, 182), grey), 255))
            if n == 1 and not is_close:
                break
    return image.resize((96, 96), Image.Resampling.BOX)


@lru_cache(maxsize=8)
def seedling_stamp(size_px: int = 256, *, is_dark: bool = False) -> Image.Image:
    """Return a tree's seedling from above."""
    light: Colour = (86, 148, 78)
    crop = Crop("rosette", 0.2, 0.2, 0.3, (30, 66, 40), (52, 84, 50) if is_dark else light)
    return plant_stamp(crop, size_px, 0.4, 7)


@lru_cache(maxsize=8)
def person_stamp() -> Image.Image:
    """Return a person in a high-visibility vest, 80 x 240 px, feet at the lower edge."""
    high, wide = 240 * OVER, 80 * OVER
    image = Image.new("RGBA", (wide, high), (0, 0, 0, 0))
    draw = ImageDraw.Draw(image)

    def at(*points: tuple[float, float]) -> list[tuple[float, float]]:
        return [(x * wide, y * high) for x, y in points]

    trousers, shade, vest, skin, hair = (44, 52, 70), (34, 40, 56), (226, 120, 30), (208, 164, 134), (70, 48, 34)
    draw.polygon(at((0.30, 0.50), (0.50, 0.50), (0.48, 0.96), (0.33, 0.96)), fill=(*shade, 255))
    draw.polygon(at((0.48, 0.50), (0.70, 0.50), (0.68, 0.96), (0.53, 0.96)), fill=(*trousers, 255))
    draw.polygon(at((0.30, 0.95), (0.49, 0.95), (0.49, 1.0), (0.26, 1.0)), fill=(40, 32, 26, 255))
    draw.polygon(at((0.52, 0.95), (0.70, 0.95), (0.74, 1.0), (0.52, 1.0)), fill=(48, 38, 30, 255))
    draw.polygon(at((0.20, 0.22), (0.28, 0.185), (0.30, 0.50), (0.20, 0.53), (0.13, 0.52)), fill=(178, 92, 24, 255))
    draw.polygon(at((0.80, 0.22), (0.72, 0.185), (0.70, 0.50), (0.80, 0.53), (0.87, 0.52)), fill=(190, 100, 26, 255))
    draw.polygon(
        at((0.26, 0.19), (0.42, 0.165), (0.58, 0.165), (0.74, 0.19), (0.72, 0.52), (0.28, 0.52)), fill=(*vest, 255)
    )
    for y in (0.33, 0.43):
        draw.rectangle(
            [*at((0.27, y)), *at((0.73, y + 0.022))][0] + at((0.73, y + 0.022))[0], fill=(226, 228, 214, 255)
        )
    draw.rectangle(at((0.36, 0.19))[0] + at((0.41, 0.52))[0], fill=(226, 228, 214, 255))
    draw.rectangle(at((0.59, 0.19))[0] + at((0.64, 0.52))[0], fill=(226, 228, 214, 255))
    draw.ellipse(at((0.12, 0.51))[0] + at((0.22, 0.555))[0], fill=(*skin, 255))
    draw.ellipse(at((0.78, 0.51))[0] + at((0.88, 0.555))[0], fill=(*skin, 255))
    draw.rectangle(at((0.44, 0.13))[0] + at((0.56, 0.18))[0], fill=(186, 142, 114, 255))
    draw.ellipse(at((0.36, 0.03))[0] + at((0.64, 0.155))[0], fill=(*skin, 255))
    draw.pieslice(at((0.35, 0.01))[0] + at((0.65, 0.14))[0], 170, 370, fill=(*hair, 255))
    draw.pieslice(at((0.33, 0.0))[0] + at((0.67, 0.12))[0], 180, 360, fill=(236, 196, 44, 255))
    return image.resize((80, 240), Image.Resampling.BOX)

"""Ground from above, made once: tiles of packed RGBX pixels that repeat, each with its smaller copies.

The fourth byte of a canopy is 255 where leaves are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFilter

from backend_clients.simulator.cameras.crops import Crop, crop_of, periods, tile_plants
from backend_clients.simulator.cameras.leaves import plant_stamp
from backend_clients.simulator.cameras.scene import Rows

Pixels = NDArray[np.uint32]
ACROSS_BITS, ALONG_BITS = 10, 11
FAR_SHRINK = 2  # bits less for what is only seen from afar
PLAIN_BITS, PLAIN_M, CLOSE_M = 9, 4.096, 1.4
LEVELS = 7
VARIANTS = 6
MOST_FIELDS = 6  # 34 MB each; the newest is last
_SHADE = (1 - 0.5 * np.arange(256) / 255).astype(np.float32)
PLAIN: dict[str, tuple[tuple[int, int, int], int, int]] = {  # colour, fine and coarse roughness
    "soil": ((132, 106, 82), 26, 18),
    "grass": ((86, 112, 58), 30, 20),
    "road": ((134, 130, 122), 16, 8),
    "yard": ((148, 142, 130), 20, 10),
    "water": ((74, 98, 104), 6, 12),
    "forest": ((94, 92, 62), 36, 30),
    "humus": ((104, 90, 72), 30, 34),
}


@dataclass(frozen=True, slots=True)
class Tile:
    """A ground that repeats. ``levels[k]`` is flat, each side ``2**-k`` of the first; ``texel_m`` of the first."""

    levels: tuple[Pixels, ...]
    across_bits: int
    along_bits: int
    across_m: float
    along_m: float

    @property
    def texel_m(self) -> float:
        """How much ground one of its finest pixels shows."""
        return self.across_m / (1 << self.across_bits)


@dataclass(frozen=True, slots=True)
class Field:
    """The tiles of a crop: bare soil with shadows, leaves, and both together from afar."""

    soil: Tile
    leaves: Tile
    whole: Tile
    crop: Crop


_FIELDS: dict[tuple[str, float], Field] = {}


@lru_cache(maxsize=16)
def plain(kind: str) -> Tile:
    """Return a ground without rows."""
    colour, fine, coarse = PLAIN.get(kind, PLAIN["grass"])
    side = 1 << PLAIN_BITS
    rgb = _rough(side, side, colour, fine, coarse, seed=len(kind) * 7 + fine)
    if kind in ("grass", "forest", "humus"):
        rgb = _tufted(rgb, kind)
    metres = CLOSE_M if kind == "humus" else PLAIN_M
    return Tile(_levels(_packed(rgb), 5), PLAIN_BITS, PLAIN_BITS, metres, metres)


def field_of(rows: Rows) -> Field:
    """Return the tiles of a crop at this row spacing; the first time takes a quarter of a second."""
    key = (rows.crop, rows.spacing_m)
    found = _FIELDS.pop(key) if key in _FIELDS else _field(*key)
    _FIELDS[key] = found
    if len(_FIELDS) > MOST_FIELDS:
        del _FIELDS[next(iter(_FIELDS))]
    return found


def is_made(rows: Rows) -> bool:
    """Say whether the tiles of a crop are there already."""
    return (rows.crop, rows.spacing_m) in _FIELDS


@lru_cache(maxsize=12)
def far_field(name: str, spacing_m: float) -> Tile:
    """Return a crop that is only seen from afar: a sixteenth of the work."""
    rows, size = Rows(name, spacing_m, 0.0, (0.0, 0.0)), _size(FAR_SHRINK)
    length, width, _, _ = periods(rows)
    whole = _whole(rows, size, _canopy(rows, size, is_upper=False), _canopy(rows, size, is_upper=True))[1]
    levels = _levels(_packed(np.asarray(whole)), LEVELS - FAR_SHRINK)
    return Tile(levels, ACROSS_BITS - FAR_SHRINK, ALONG_BITS - FAR_SHRINK, width, length)


def _field(name: str, spacing_m: float) -> Field:
    rows, size = Rows(name, spacing_m, 0.0, (0.0, 0.0)), _size(0)
    length, width, _, _ = periods(rows)
    lower, upper = _canopy(rows, size, is_upper=False), _canopy(rows, size, is_upper=True)
    soil, whole = _whole(rows, size, lower, upper)

    def tile(image: Any, levels: int) -> Tile:
        return Tile(_levels(_packed(np.asarray(image)), levels), ACROSS_BITS, ALONG_BITS, width, length)

    leaves = lower.copy()
    leaves.alpha_composite(upper)
    return Field(tile(soil, 3), tile(leaves, 3), tile(whole, LEVELS), crop_of(name))


def _size(shrink: int) -> tuple[int, int]:
    return 1 << (ACROSS_BITS - shrink), 1 << (ALONG_BITS - shrink)


def _whole(
    rows: Rows, size: tuple[int, int], lower: Image.Image, upper: Image.Image
) -> tuple[NDArray[np.uint8], Image.Image]:
    soil = _soil(lower, rows, size)
    whole = Image.fromarray(soil, "RGBA")
    whole.alpha_composite(lower)
    whole.alpha_composite(upper)
    return soil, whole


def _canopy(rows: Rows, size: tuple[int, int], *, is_upper: bool) -> Image.Image:
    crop, (wide, high) = crop_of(rows.crop), size
    length, width, _, _ = periods(rows)
    per_m = (wide / width, high / length)
    size_px = max(round(crop.wide_m * per_m[1]), 5)
    stamps = [
        [plant_stamp(crop, max(round(size_px * (0.75 + 0.12 * s)), 6), v * 1.1, v, is_upper=is_upper) for s in range(4)]
        for v in range(VARIANTS)
    ]
    if abs(per_m[0] / per_m[1] - 1) > 0.02:
        stretch = per_m[0] / per_m[1]
        stamps = [[s.resize((max(round(s.width * stretch), 3), s.height)) for s in line] for line in stamps]
    canopy = Image.new("RGBA", (wide, high), (*crop.dark, 0))
    for along, across, grown, turn in tile_plants(rows):
        stamp = stamps[int(turn * 10) % VARIANTS][min(max(int((grown - 0.72) * 10), 0), 3)]
        done: set[tuple[int, int]] = set()
        x, y = round(across * per_m[0] - stamp.width / 2), round(along * per_m[1] - stamp.height / 2)
        for dx in (0, wide if x < 0 else -wide if x + stamp.width > wide else 0):
            for dy in (0, high if y < 0 else -high if y + stamp.height > high else 0):
                if (dx, dy) not in done:
                    done.add((dx, dy))
                    canopy.paste(stamp, (x + dx, y + dy), stamp)
    return canopy


def _soil(lower: Image.Image, rows: Rows, size: tuple[int, int]) -> NDArray[np.uint8]:
    """Return bare soil with clods, the lines of the drill, and the shadows of the plants."""
    colour, fine, coarse = PLAIN[crop_of(rows.crop).floor]
    wide, high = size
    light = np.tile(_roughness(wide, wide, fine + 4, coarse - 2, seed=3), (high // wide, 1))
    width = periods(rows)[1]
    if rows.spacing_m > 0.3:
        across = np.arange(wide) * width / wide
        from_row = np.abs((across + rows.spacing_m / 2) % rows.spacing_m - rows.spacing_m / 2)
        light *= (0.93 + 0.1 * np.minimum(from_row / (rows.spacing_m / 2), 1.0)).astype(np.float32)
    alpha = lower.getchannel("A").reduce(4).filter(ImageFilter.BoxBlur(2)).resize(lower.size)
    shade = np.roll(np.asarray(alpha), (high // 200, wide // 128), (0, 1))
    light *= _SHADE[shade]
    return _coloured(light, colour)


def _rough(
    wide: int, high: int, colour: tuple[int, int, int], fine: int, coarse: int, *, seed: int
) -> NDArray[np.uint8]:
    """Return a ground of one colour with noise of several sizes that joins at its edges."""
    return _coloured(_roughness(wide, high, fine, coarse, seed=seed), colour)


def _roughness(wide: int, high: int, fine: int, coarse: int, *, seed: int) -> NDArray[np.float32]:
    """Return light around 1."""
    rng = np.random.default_rng(seed)
    total = (rng.random((high, wide), dtype=np.float32) - 0.5) * (fine * 1.1)
    for cell, strength in ((3, fine), (10, coarse), (64, coarse * 0.6)):
        total += strength * _smooth_noise(rng, wide, high, cell)
    total *= 1.6 / 255
    total += 1
    return total


def _coloured(light: NDArray[np.float32], colour: tuple[int, int, int]) -> NDArray[np.uint8]:
    """Return RGBX pixels of one colour, lit between 0 and 2."""
    step = np.arange(256) / 127.5
    shades = np.full((256, 4), 255, dtype=np.uint8)
    for k, share in enumerate((1.0, 0.98, 0.92)):
        shades[:, k] = np.clip(colour[k] * (1 + (step - 1) * share), 0, 255)
    packed = shades.view(np.uint32)[:, 0]
    light = light * 127.5
    return packed[np.clip(light, 0, 255, out=light).astype(np.uint8)].view(np.uint8).reshape(*light.shape, 4)


def _smooth_noise(rng: np.random.Generator, wide: int, high: int, cell: int) -> NDArray[np.float32]:
    rough = rng.random((max(high // cell, 2), max(wide // cell, 2)), dtype=np.float32)
    edged = np.pad(rough, 2, mode="wrap")
    step = (high / rough.shape[0], wide / rough.shape[1])
    large = Image.fromarray(edged).resize(
        (round(edged.shape[1] * step[1]), round(edged.shape[0] * step[0])), Image.Resampling.BILINEAR
    )
    top, left = round(2 * step[0]), round(2 * step[1])
    cut: NDArray[np.float32] = np.asarray(large)[top : top + high, left : left + wide] * 2 - 1
    return cut


def _tufted(rgb: NDArray[np.uint8], kind: str) -> NDArray[np.uint8]:
    """Draw blades of grass, or leaves, twigs and moss."""
    image = Image.fromarray(np.ascontiguousarray(rgb[:, :, :3]))
    draw = ImageDraw.Draw(image)
    rng = np.random.default_rng(5)
    side = rgb.shape[0]
    inks = {"grass": [(62, 92, 40), (112, 140, 74), (140, 150, 92), (78, 108, 50)],
            "humus": [(84, 70, 54), (126, 108, 86), (72, 60, 48), (140, 122, 96), (62, 52, 42)],
            "forest": [(70, 58, 38), (120, 96, 62), (66, 86, 42), (92, 106, 54), (52, 44, 32)]}[kind]  # fmt: skip
    for x, y, turn, long, ink in rng.random((2600, 5)):
        reach, colour = 3 + long * 9, inks[int(ink * len(inks))]
        x0, y0 = x * side, y * side
        dx, dy = reach * np.cos(turn * 6.3), reach * np.sin(turn * 6.3)
        for ox in (0, -side, side):
            if -12 < x0 + ox < side + 12:
                draw.line((x0 + ox, y0, x0 + ox + dx, y0 + dy), fill=colour, width=1 if kind == "grass" else 2)
    return np.asarray(image)


def _packed(rgb: NDArray[np.uint8]) -> Pixels:
    """Return pixels of shape (height, width) from RGB or RGBA ones."""
    high, wide = rgb.shape[:2]
    if rgb.shape[2] == 4:
        return np.ascontiguousarray(rgb).view(np.uint32)[:, :, 0]
    four = np.full((high, wide, 4), 255, dtype=np.uint8)
    four[:, :, : rgb.shape[2]] = rgb
    return four.view(np.uint32)[:, :, 0]


def _levels(first: Pixels, many: int) -> tuple[Pixels, ...]:
    """Return a picture and its halves, flat."""
    high, wide = first.shape
    found = [np.ascontiguousarray(first).ravel()]
    image = Image.fromarray(np.ascontiguousarray(first).view(np.uint8).reshape(high, wide, 4), "RGBX")
    for _ in range(many - 1):
        image = image.reduce(2)
        found.append(np.asarray(image).reshape(-1, 4).view(np.uint32)[:, 0])
    return tuple(found)

"""The sky over the site: where the sun is, how light it is, and what stands on the horizon."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFilter

from backend_clients.simulator.cameras.eye import Eye

PANORAMA_PX = 2048
HIGH_PX = 512
HIGH_RAD = 0.8  # of the sky that is drawn; above it stays the same
TREES_RAD = 0.055
DAY_RAD, NIGHT_RAD = math.radians(9.0), math.radians(-8.0)
HIGH_BY_DAY, HIGH_BY_NIGHT = (96, 136, 176), (9, 13, 26)
LOW_BY_DAY, LOW_BY_NIGHT = (214, 220, 220), (24, 30, 44)
GLOW = (236, 150, 84)


@dataclass(frozen=True, slots=True)
class Light:
    """How light it is: ``day`` 0 to 1, ``dusk`` how red the horizon is, and where the sun stands (ENU)."""

    day: float
    dusk: float
    azimuth_rad: float
    height_rad: float

    @property
    def is_dark(self) -> bool:
        """Whether lamps go on by themselves."""
        return self.day < 0.45

    @property
    def gain(self) -> tuple[float, float, float]:
        """How much of each colour is seen without a lamp."""
        dim = 0.05 + 0.95 * self.day
        return dim * (1 - 0.10 * (1 - self.day)), dim * (1 - 0.04 * (1 - self.day)), dim * (1 + 0.25 * (1 - self.day))


def light_at(wall_ms: int, lat_deg: float, lon_deg: float) -> Light:
    """Return the light at a moment and place, within a degree of the sun's true height."""
    days = wall_ms / 86_400_000 - 10_957.5  # since noon of 1 January 2000
    mean = math.radians((357.529 + 0.98560028 * days) % 360)
    long = math.radians((280.459 + 0.98564736 * days) % 360) + math.radians(1.915) * math.sin(mean)
    tilt = math.radians(23.439)
    rise = math.atan2(math.cos(tilt) * math.sin(long), math.cos(long))
    fall = math.asin(math.sin(tilt) * math.sin(long))
    turn = math.radians((280.46062 + 360.9856473 * days + lon_deg) % 360) - rise
    lat = math.radians(lat_deg)
    height = math.asin(math.sin(lat) * math.sin(fall) + math.cos(lat) * math.cos(fall) * math.cos(turn))
    east = -math.cos(fall) * math.sin(turn)
    north = math.cos(lat) * math.sin(fall) - math.sin(lat) * math.cos(fall) * math.cos(turn)
    share = min(max((height - NIGHT_RAD) / (DAY_RAD - NIGHT_RAD), 0.0), 1.0)
    dusk = max(0.0, 1 - abs(height - math.radians(-1)) / math.radians(9))
    return Light(share * share * (3 - 2 * share), dusk, math.atan2(north, east), height)


def paint_sky(canvas: NDArray[np.uint32], eye: Eye, light: Light) -> int:
    """Draw the sky above the horizon; return the first row below it."""
    u0, v0 = eye.middle
    edge = v0 + eye.focal_px * math.tan(eye.pitch_rad) if abs(eye.pitch_rad) < 1.5 else -1e9
    horizon = min(max(math.ceil(edge), 0), eye.height_px)
    if horizon <= 0:
        return 0
    picture = _panorama(round(light.day * 12), round(light.dusk * 6), round(light.azimuth_rad * 8))
    bearings = eye.yaw_rad - np.arctan((np.arange(eye.width_px) + 0.5 - u0) / eye.focal_px)
    columns = np.floor(bearings / (2 * math.pi) * PANORAMA_PX).astype(np.int64) % PANORAMA_PX
    heights = np.arctan((edge - np.arange(horizon) - 0.5) / eye.focal_px)
    rows = np.clip((1 - heights / HIGH_RAD) * HIGH_PX, 0, HIGH_PX - 1).astype(np.int64)
    np.take(picture.ravel(), rows[:, None] * PANORAMA_PX + columns, out=canvas[:horizon], mode="clip")
    return horizon


@lru_cache(maxsize=4)
def _panorama(day_step: int, dusk_step: int, sun_step: int) -> NDArray[np.uint32]:
    """Return the sky all around, shape (HIGH_PX, PANORAMA_PX): column by bearing, the horizon at the lower edge."""
    day, dusk = day_step / 12, dusk_step / 6
    up = np.linspace(1, 0, HIGH_PX, dtype=np.float32)[:, None] ** np.float32(0.7)
    bearing = np.arange(PANORAMA_PX, dtype=np.float32) * np.float32(2 * math.pi / PANORAMA_PX)
    toward = np.clip(np.cos(bearing - sun_step / 8), 0, 1) ** 3 * 0.75 + 0.25
    glow = (np.clip(1 - up * 2.2, 0, 1) * np.float32(dusk * 0.8)) * toward if dusk else None
    clouds = _clouds() * np.float32(6 + 34 * day)
    four = np.full((HIGH_PX, PANORAMA_PX, 4), 255, dtype=np.uint8)
    for k in range(3):  # one colour at a time: a quarter of the memory, and twice as fast
        high, low = (
            HIGH_BY_DAY[k] * day + HIGH_BY_NIGHT[k] * (1 - day),
            LOW_BY_DAY[k] * day + LOW_BY_NIGHT[k] * (1 - day),
        )
        shade = low + (high - low) * up
        colour = clouds + (shade if glow is None else shade + (GLOW[k] * (0.25 + 0.75 * day) - shade) * glow)
        four[:, :, k] = np.clip(colour, 0, 255, out=colour)
    image = Image.fromarray(four[:, :, :3])
    if day < 0.3:
        _stars(image, 1 - day / 0.3)
    _trees(image, day)
    four[:, :, :3] = np.asarray(image)
    return four.view(np.uint32)[:, :, 0]


@lru_cache(maxsize=1)
def _clouds() -> NDArray[np.float32]:
    rng = np.random.default_rng(11)
    total = np.zeros((HIGH_PX, PANORAMA_PX), dtype=np.float32)
    for cells, strength in ((12, 1.0), (28, 0.6), (70, 0.35), (170, 0.2)):
        small = rng.random((max(cells // 3, 2), cells), dtype=np.float32)
        small = np.concatenate((small, small[:, :1]), axis=1)
        wide = Image.fromarray(small - 0.5).resize((PANORAMA_PX, HIGH_PX), Image.Resampling.BILINEAR)
        total += np.asarray(wide) * np.float32(strength)
    total *= np.float32(1.1)
    return np.clip(total, -0.6, 1.0, out=total)


def _stars(image: Image.Image, strength: float) -> None:
    draw = ImageDraw.Draw(image)
    for x, y, bright in np.random.default_rng(3).random((500, 3)):
        grey = round((70 + 120 * bright) * strength)
        draw.point((x * PANORAMA_PX, y * HIGH_PX * 0.85), fill=(grey, grey, min(grey + 14, 255)))


def _trees(image: Image.Image, day: float) -> None:
    """Draw two lines of trees on the horizon; the further one is paler."""
    draw = ImageDraw.Draw(image)
    for far, shade in ((1.0, (126, 142, 128)), (0.55, (78, 98, 70))):
        rng = np.random.default_rng(int(far * 10))
        colour = tuple(round(c * (0.08 + 0.92 * day)) for c in shade)
        high = TREES_RAD / HIGH_RAD * HIGH_PX * (0.55 if far == 1.0 else 0.62)
        turns = np.arange(PANORAMA_PX) / PANORAMA_PX * 2 * math.pi
        swell = np.sum([np.sin(turns * k + k) / k for k in (3, 5, 11, 17)], axis=0)
        x = 0.0
        while x < PANORAMA_PX:
            here = high * (0.62 + 0.3 * float(swell[int(x)]) + 0.3 * rng.random())
            wide = (8 + 12 * rng.random()) * (1.3 - 0.5 * far)
            draw.ellipse((x - wide, HIGH_PX - here, x + wide, HIGH_PX + here), fill=colour)
            x += wide * 0.8
        draw.rectangle((0, HIGH_PX - 4, PANORAMA_PX, HIGH_PX), fill=colour)
    image.paste(
        image.crop((0, HIGH_PX - 70, PANORAMA_PX, HIGH_PX)).filter(ImageFilter.GaussianBlur(0.6)), (0, HIGH_PX - 70)
    )

"""What grows: how each crop looks, where its plants stand, and where weeds stand between them.

A plant's place follows from its row and number alone, so that the same plant is there again in every picture.
Frame of a field: ``along`` its rows and ``across`` them, metres from the anchor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from backend_clients.simulator.cameras.row_frame import from_field, to_field
from backend_clients.simulator.cameras.scene import Line, Rows

Floats = NDArray[np.float64]
TILE_ALONG_M, TILE_ACROSS_M = 8.0, 4.0
WEED_CELL_M = (0.8, 0.5)
WEED_SHARE = 0.42  # of the cells: about one a square metre, what the laser's rate is made for
MISSED_SHARE = 0.04
LEAVES_SHARE = 0.65  # of a plant's height, where most of its leaves are
TOOL_BEHIND_M, HALF_TOOL_M = 0.8, 0.75


@dataclass(frozen=True, slots=True)
class Crop:
    """One crop: shape of its plants, metres, the colours of old and young leaves, and its ground."""

    shape: str
    plant_m: float
    wide_m: float
    high_m: float
    dark: tuple[int, int, int] = (38, 74, 34)
    light: tuple[int, int, int] = (92, 142, 58)
    floor: str = "soil"


CROPS = {
    "sugar beet": Crop("rosette", 0.2, 0.3, 0.16),
    "chicory": Crop("rosette", 0.16, 0.24, 0.12, (44, 84, 38), (112, 156, 72)),
    "carrot": Crop("feather", 0.08, 0.2, 0.14, (40, 82, 36), (96, 150, 60)),
    "onion": Crop("blade", 0.1, 0.16, 0.18, (52, 88, 66), (120, 158, 112)),
    "maize": Crop("blade", 0.16, 0.42, 0.3, (46, 84, 34), (118, 160, 62)),
    "wheat": Crop("blade", 0.05, 0.2, 0.16, (58, 98, 38), (140, 172, 74)),
    "willow": Crop("feather", 2.0, 0.95, 0.8, (52, 84, 48), (128, 160, 96), "forest"),
    "alder": Crop("rosette", 2.0, 0.7, 0.7, (40, 72, 40), (92, 132, 72), "forest"),
}
USUAL = CROPS["sugar beet"]


def crop_of(name: str) -> Crop:
    """Return how a crop looks; one that is not known looks like beet."""
    low = name.lower()
    return next((crop for known, crop in CROPS.items() if known in low), USUAL)


def periods(rows: Rows) -> tuple[float, float, int, int]:
    """Return the tile's length and width in metres, and how many plants and rows it has."""
    crop = crop_of(rows.crop)
    plants = round(TILE_ALONG_M / crop.plant_m)
    lines = max(round(TILE_ACROSS_M / rows.spacing_m), 1)
    return TILE_ALONG_M, lines * rows.spacing_m, plants, lines


def tile_plants(rows: Rows) -> Floats:
    """Return the plants of one tile: along, across, size share and turn; a few are missing, as in any field."""
    length, _, plants, lines = periods(rows)
    rng = np.random.default_rng(plants * 1000 + lines)
    i, j = np.meshgrid(np.arange(plants), np.arange(lines), indexing="ij")
    along = (i + 0.5 + rng.uniform(-0.22, 0.22, i.shape)) * length / plants
    across = j * rows.spacing_m + rng.normal(0.0, 0.012, i.shape)
    size = rng.uniform(0.72, 1.12, i.shape)
    turn = rng.uniform(0, 2 * math.pi, i.shape)
    found = np.column_stack([one.ravel() for one in (along, across, size, turn)])
    kept: Floats = found[rng.random(len(found)) > 0.035]
    return kept


def plants_near(rows: Rows, x_m: float, y_m: float, radius_m: float) -> Floats:
    """Return ENU x, y and size share of the crop plants around a place."""
    length, width, _, _ = periods(rows)
    tile = tile_plants(rows)
    [(along, across)] = to_field(rows, np.array([(x_m, y_m)]))
    found = []
    for a in range(math.floor((along - radius_m) / length), math.floor((along + radius_m) / length) + 1):
        for c in range(math.floor((across - radius_m) / width), math.floor((across + radius_m) / width) + 1):
            found.append(tile[:, :3] + (a * length, c * width, 0.0))
    every = np.concatenate(found)
    every = every[np.hypot(every[:, 0] - along, every[:, 1] - across) <= radius_m]
    return np.column_stack((from_field(rows, every[:, :2]), every[:, 2]))


def weeds_near(rows: Rows, x_m: float, y_m: float, radius_m: float) -> Floats:
    """Return ENU x, y, size share, kind (0 to 1) and luck (0 to 1) of the weeds around a place."""
    [(along, across)] = to_field(rows, np.array([(x_m, y_m)]))
    da, dc = WEED_CELL_M
    i = np.arange(math.floor((along - radius_m) / da), math.floor((along + radius_m) / da) + 1)
    j = np.arange(math.floor((across - radius_m) / dc), math.floor((across + radius_m) / dc) + 1)
    ii, jj = (one.ravel() for one in np.meshgrid(i, j, indexing="ij"))
    draw = [_hash(ii, jj, salt) for salt in range(6)]
    spacing = rows.spacing_m
    a = (ii + draw[1]) * da
    c = (jj + draw[2]) * dc
    if spacing > 0.3:  # weeds of wide rows stand between them
        line = np.round(c / spacing) * spacing
        off = c - line
        c = np.where(np.abs(off) < 0.11, line + np.where(off < 0, -1, 1) * (0.11 + np.abs(off)), c)
    is_there = (draw[0] < WEED_SHARE) & (np.hypot(a - along, c - across) <= radius_m)
    here = np.column_stack((a, c))[is_there]
    return np.column_stack((from_field(rows, here), 0.5 + draw[3][is_there], draw[4][is_there], draw[5][is_there]))


def outcome_of(weeds: Floats, treated: list[Line]) -> NDArray[np.int8]:
    """Return for each weed -1 where the tool was not yet, 0 where it missed, 1 where it hit."""
    was_there = np.zeros(len(weeds), dtype=bool)
    for x0, y0, x1, y1 in treated:
        length = math.hypot(x1 - x0, y1 - y0)
        if length < 1e-6:
            continue
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        s = (weeds[:, 0] - x0) * ux + (weeds[:, 1] - y0) * uy
        off = (weeds[:, 1] - y0) * ux - (weeds[:, 0] - x0) * uy
        was_there |= (s >= -TOOL_BEHIND_M) & (s <= length - TOOL_BEHIND_M) & (np.abs(off) <= HALF_TOOL_M)
    outcome = np.where(was_there, np.where(weeds[:, 4] < MISSED_SHARE, 0, 1), -1)
    return outcome.astype(np.int8)


def _hash(i: NDArray[np.int64], j: NDArray[np.int64], salt: int) -> Floats:
    """Return a number from 0 to 1 for each cell, always the same."""
    x = (i.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)) ^ (j.astype(np.uint64) * np.uint64(0xC2B2AE3D27D4EB4F))
    x += np.uint64(salt + 1) * np.uint64(0x165667B19E3779F9)
    x ^= x >> np.uint64(33)
    x *= np.uint64(0xFF51AFD7ED558CCD)
    x ^= x >> np.uint64(33)
    x *= np.uint64(0xC4CEB9FE1A85EC53)
    x ^= x >> np.uint64(33)
    return (x >> np.uint64(11)).astype(np.float64) / float(1 << 53)

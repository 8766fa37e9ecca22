"""Small shapes that stand for places: a tree for done, a cross for failed, a ring for planned."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import viser
from numpy.typing import NDArray

from hmi.twin.model import Box, Colour
from hmi.twin.solids import Floats, placed, triangles_of

Shape = tuple[Floats, NDArray[np.uint32]]


@dataclass(frozen=True, slots=True)
class Mark:
    """A shape in a colour; outcomes differ in shape too, so that colour is not needed to tell them apart."""

    shape: str
    colour: Colour
    lift_m: float = 0.0


TREE = Mark("tree", (118, 138, 100))
CROSS = {
    "failed_tool": Mark("cross", (239, 125, 20), 0.05),
    "failed_ground": Mark("plus", (150, 98, 52), 0.05),
    "failed_machine": Mark("square", (60, 66, 70), 0.05),
}
RING = {
    "planned": Mark("ring", (74, 96, 112), 0.02),
    "current": Mark("target", (16, 20, 22), 0.03),
    "skipped": Mark("dash", (140, 146, 148), 0.02),
}


@cache
def marks_of(mark: Mark) -> Shape:
    """Return corners and faces of a mark, metres, standing on the ground."""
    corners = np.asarray(_SHAPES[mark.shape](), np.float32)
    return corners, np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)


def draw_marks(scene: viser.SceneApi, frame: str, mark: Mark, places: list[tuple[float, float]]) -> None:
    """Draw a mark at each place of the site's plane, all as one; metres."""
    corners, faces = marks_of(mark)
    positions = np.asarray([(x, y, mark.lift_m) for x, y in places], np.float32)
    turns = np.tile(np.asarray([1, 0, 0, 0], np.float32), (len(places), 1))
    scene.add_batched_meshes_simple(
        frame, corners, faces, turns, positions, batched_colors=mark.colour, cast_shadow=False, flat_shading=True
    )


def _tree() -> Floats:
    tiers = ((0.12, 0.20, 0.16), (0.22, 0.16, 0.15), (0.32, 0.11, 0.16))
    stem = placed(triangles_of(Box((0.03, 0.03, 0.12))), (0, 0, 0.06), (0, 0, 0))
    return np.concatenate([stem, *(_cone(*tier) for tier in tiers)])


def _cone(foot_m: float, radius_m: float, height_m: float, sides: int = 7) -> Floats:
    angles = np.linspace(0, 2 * math.pi, sides, endpoint=False)
    ring = np.column_stack([radius_m * np.cos(angles), radius_m * np.sin(angles), np.full(sides, foot_m)])
    top, low = np.tile([0, 0, foot_m + height_m], (sides, 1)), np.tile([0, 0, foot_m], (sides, 1))
    following = np.roll(ring, -1, axis=0)
    faces = [ring, following, top, following, ring, low]
    return np.asarray(np.stack(faces, axis=1).reshape(-1, 3), np.float32)


def _bars(*turns: float) -> Floats:
    bar = triangles_of(Box((0.5, 0.09, 0.05)))
    return np.concatenate([placed(bar, (0, 0, 0), (0, 0, turn)) for turn in turns])


def _ring(inner_m: float, outer_m: float, sides: int = 28) -> Floats:
    angles = np.linspace(0, 2 * math.pi, sides + 1)
    unit = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(sides + 1)])
    inner, outer = unit * inner_m, unit * outer_m
    faces = [inner[:-1], outer[:-1], outer[1:], inner[:-1], outer[1:], inner[1:]]
    return np.asarray(np.stack(faces, axis=1).reshape(-1, 3), np.float32)


_SHAPES: dict[str, Callable[[], Floats]] = {
    "tree": _tree,
    "cross": lambda: _bars(math.pi / 4, -math.pi / 4),
    "plus": lambda: _bars(0.0, math.pi / 2),
    "square": lambda: triangles_of(Box((0.3, 0.3, 0.06))),
    "ring": lambda: _ring(0.20, 0.25),
    "target": lambda: np.concatenate([_ring(0.32, 0.38), _ring(0.16, 0.21)]),
    "dash": lambda: _bars(0.0),
}

"""A scene made ready to be drawn: which grounds and solids can be in a picture."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from backend_clients.simulator.cameras.crops import weeds_near
from backend_clients.simulator.cameras.eye import Eye, Floats
from backend_clients.simulator.cameras.scene import Ground, Look, Rows, Scene, Solid

SOLID_FAR_M = 420.0
GROUND_FAR_M = 600.0
MOST_PLACES = 64


def rows_of(ground: Ground, look: Look) -> Rows | None:
    """Return the rows of a ground; those of a curve as they lie near the machine."""
    return look.rows if ground.is_bent and look.rows is not None else ground.rows


class Stage:
    """The grounds and solids of one scene with their boxes; the open land between them is grass."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._grounds = [(one, _flat(one.ring)) for one in scene.grounds]
        self._boxes = np.array([_box(ring) for _, ring in self._grounds]).reshape(-1, 4)
        self._weeds: dict[tuple[Rows, float, float, float], Floats] = {}
        self._solid_boxes = np.array([_box(one.ring) for one in scene.solids]).reshape(-1, 4)

    def field_at(self, look: Look, x_m: float, y_m: float) -> Rows | None:
        """Return the rows that grow at a place."""
        for ground, ring in reversed(self._grounds):
            if _is_inside(ring, x_m, y_m):
                return rows_of(ground, look)
        return None

    def ground_at(self, x_m: float, y_m: float) -> str:
        """Return the kind of ground at a place."""
        for ground, ring in reversed(self._grounds):
            if _is_inside(ring, x_m, y_m):
                return ground.kind
        return "grass"

    def is_in_field(self, look: Look, rows: Rows, points: Floats) -> NDArray[np.bool_]:
        """Return which points, shape (N, 2 or more), lie in the field of these rows and not on a road over it."""
        found = np.zeros(len(points), dtype=bool)
        for ground, ring in self._grounds:
            if rows_of(ground, look) == rows:
                found |= _inside(ring, points)
            elif ground.rows is None:
                found &= ~_inside(ring, points)
        return found

    def weeds(self, look: Look, rows: Rows, x_m: float, y_m: float, radius_m: float) -> Floats:
        """Return the weeds of a field around a place, as ``crops.weeds_near``; the same place again costs nothing."""
        key = (rows, x_m, y_m, radius_m)
        found = self._weeds.get(key)
        if found is None:
            if len(self._weeds) > MOST_PLACES:
                self._weeds.clear()
            every = weeds_near(rows, x_m, y_m, radius_m)
            found = self._weeds[key] = every[self.is_in_field(look, rows, every)]
        return found

    def cover(self, eye: Eye) -> tuple[Image.Image, dict[int, Ground]]:
        """Return what ground each pixel shows as numbers, and the grounds by number; 0 is the open land.

        Sky has a number too: only pixels below the horizon mean anything.
        """
        mask = Image.new("L", (eye.width_px, eye.height_px), 0)
        draw = ImageDraw.Draw(mask)
        shown: dict[int, Ground] = {}
        for index in _near(self._boxes, eye, GROUND_FAR_M):
            ground, ring = self._grounds[index]
            outline = eye.outline(ring)
            if len(outline) < 3:
                continue
            number = len(shown) + 1
            if number > 250:
                break
            draw.polygon(outline, fill=number)
            shown[number] = ground
        return mask, shown

    def solids(self, eye: Eye) -> list[Solid]:
        """Return what stands within sight, the furthest first."""
        found = [self.scene.solids[i] for i in _near(self._solid_boxes, eye, SOLID_FAR_M)]
        found.sort(key=lambda one: -_far_m(one, eye))
        return found


def _near(boxes: Floats, eye: Eye, far_m: float) -> list[int]:
    if not len(boxes):
        return []
    dx = np.maximum(np.maximum(boxes[:, 0] - eye.x_m, eye.x_m - boxes[:, 2]), 0.0)
    dy = np.maximum(np.maximum(boxes[:, 1] - eye.y_m, eye.y_m - boxes[:, 3]), 0.0)
    if eye.pitch_rad < -1.2:
        far_m = min(far_m, eye.z_m * 4 + 5)
    is_near = np.hypot(dx, dy) < far_m
    if eye.pitch_rad > -0.9:  # nothing of it may be ahead
        cos, sin = math.cos(eye.yaw_rad), math.sin(eye.yaw_rad)
        xs, ys = boxes[:, [0, 2, 0, 2]] - eye.x_m, boxes[:, [1, 1, 3, 3]] - eye.y_m
        is_near &= ((xs * cos + ys * sin) > -eye.z_m * 2).any(axis=1)
    return [int(i) for i in np.flatnonzero(is_near)]


def _far_m(solid: Solid, eye: Eye) -> float:
    return min(math.dist(point, (eye.x_m, eye.y_m)) for point in solid.ring)


def _flat(ring: list[tuple[float, float]]) -> Floats:
    flat = np.asarray(ring, dtype=np.float64)
    return np.column_stack((flat, np.zeros(len(flat))))


def _box(ring: Floats | list[tuple[float, float]]) -> tuple[float, float, float, float]:
    flat = np.asarray(ring, dtype=np.float64)
    return float(flat[:, 0].min()), float(flat[:, 1].min()), float(flat[:, 0].max()), float(flat[:, 1].max())


def _is_inside(ring: Floats, x: float, y: float) -> bool:
    return bool(_inside(ring, np.array([(x, y)]))[0])


def _inside(ring: Floats, points: Floats) -> NDArray[np.bool_]:
    """Return which points lie in a ring."""
    xs, ys = ring[:, 0], ring[:, 1]
    x, y = points[:, 0:1], points[:, 1:2]
    if x.min(initial=np.inf) > xs.max() or x.max(initial=-np.inf) < xs.min():
        return np.zeros(len(points), dtype=bool)
    xn, yn = np.roll(xs, -1), np.roll(ys, -1)
    crosses = (ys > y) != (yn > y)
    at = xs + (y - ys) * (xn - xs) / np.where(yn == ys, 1.0, yn - ys)
    odd: NDArray[np.bool_] = np.count_nonzero(crosses & (x < at), axis=1) % 2 == 1
    return odd

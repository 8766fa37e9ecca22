"""The point cloud a machine sees: ground, obstacles of its site, people; the same again for the same place."""

from __future__ import annotations

import base64
import math
import random
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backend_clients.edge.machine import MAX_SCAN_POINTS, Obstacle
from backend_clients.simulator.enu import Point
from backend_clients.simulator.machine import Machine
from backend_clients.simulator.terrain import WAVES, height_m

RINGS, PER_RING = 28, 64
NEAREST_M, FURTHEST_M = 3.0, 22.0
PERSON_M = 1.75


@lru_cache(maxsize=1)
def _pattern() -> NDArray[np.float64]:
    """Return x, y of the beams' ends on flat ground around the machine."""
    radii = NEAREST_M * (FURTHEST_M / NEAREST_M) ** (np.arange(RINGS) / (RINGS - 1))
    turns = np.arange(PER_RING) * 2 * math.pi / PER_RING
    r, a = np.meshgrid(radii, turns)
    a = a + 0.05 * (r % 1)
    return np.column_stack(((r * np.cos(a)).ravel(), (r * np.sin(a)).ravel()))


def scan_fields(machine: Machine) -> dict[str, Any]:
    """Return the scan message without its header: centimetres from where the machine stands, as int16."""
    base, rig = machine.base, machine.rig
    obstacles = tuple(rig.site.obstacles) if rig is not None and rig.site is not None else ()
    origin, points = _cloud(round(base.x_m, 2), round(base.y_m, 2), obstacles, machine.person)
    return {"origin": origin, "points": points}


@lru_cache(maxsize=64)  # a machine that stands sees the same again
def _cloud(
    x_m: float, y_m: float, obstacles: tuple[Obstacle, ...], person: Point | None
) -> tuple[tuple[float, ...], str]:
    here = (x_m, y_m, height_m(x_m, y_m))
    flat = _pattern()
    heights = _ground(flat[:, 0] + x_m, flat[:, 1] + y_m) - here[2]
    parts = [np.column_stack((flat, heights))]
    parts += [_cylinder(one.x_m - x_m, one.y_m - y_m, one.radius_m, one.height_m, 24) for one in obstacles]
    if person is not None:
        parts.append(_cylinder(person[0] - x_m, person[1] - y_m, 0.25, PERSON_M, 120))
    points = np.concatenate(parts)[:MAX_SCAN_POINTS]
    centimetres = np.clip(np.round(points * 100), -32000, 32000).astype("<i2")
    return tuple(round(value, 3) for value in here), base64.b64encode(centimetres.tobytes()).decode("ascii")


def _ground(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    total = np.zeros_like(x)
    for high, length, turn in WAVES:
        total += high * np.sin(2 * math.pi * (x * math.cos(turn) + y * math.sin(turn)) / length)
    return total


def _cylinder(x_m: float, y_m: float, radius_m: float, high_m: float, many: int) -> NDArray[np.float64]:
    rng = random.Random(f"{x_m:.1f}/{y_m:.1f}")  # noqa: S311
    found = []
    for _ in range(many):
        turn = rng.random() * 2 * math.pi
        found.append((x_m + radius_m * math.cos(turn), y_m + radius_m * math.sin(turn), rng.random() * high_m))
    return np.array(found, dtype=np.float64)

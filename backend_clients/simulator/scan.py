"""The point cloud a machine sees: ground, obstacles of its site, people; the same again for the same place."""

from __future__ import annotations

import base64
import math
import random
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backend_clients.edge.machine import MAX_SCAN_POINTS
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
    base = machine.base
    here = (base.x_m, base.y_m, height_m(base.x_m, base.y_m))
    flat = _pattern()
    heights = _ground(flat[:, 0] + here[0], flat[:, 1] + here[1]) - here[2]
    parts = [np.column_stack((flat, heights))]
    if machine.rig is not None and machine.rig.site is not None:
        parts += [
            _cylinder(one.x_m - here[0], one.y_m - here[1], one.radius_m, one.height_m, 24)
            for one in machine.rig.site.obstacles
        ]
    if machine.person is not None:
        parts.append(_cylinder(machine.person[0] - here[0], machine.person[1] - here[1], 0.25, PERSON_M, 120))
    points = np.concatenate(parts)[:MAX_SCAN_POINTS]
    centimetres = np.clip(np.round(points * 100), -32000, 32000).astype("<i2")
    origin = tuple(round(value, 3) for value in here)
    return {"origin": origin, "points": base64.b64encode(centimetres.tobytes()).decode("ascii")}


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

"""Where along its mission a planter stops, and which piece of row it plants from there."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import accumulate
from typing import TYPE_CHECKING

from msgspec import UnsetType

from backend_clients.simulator.planting_site import AREA_M, TREES_PER_M2, Stretch

if TYPE_CHECKING:
    from backend_clients.simulator.mission_run import MissionRun
    from backend_clients.simulator.route import Leg

BEHIND_M = 4.0  # from the machine's reference point back to the near edge of the area
LEAST_M = 0.8  # a shorter piece at the end of a row belongs to the one before


class Stops:
    """The stops of one path, in driving order."""

    def __init__(self, run: MissionRun) -> None:
        self.route = run.route
        self._stops = [
            stretch
            for leg, line_m in _lines(run.route.legs)
            for stretch in _in_line(
                _stretches(leg.row, leg.own_start_m, leg.end_m, run.route.length_m), line_m, spacing_of(run)
            )
        ]
        self._at = [one.stop_m for one in self._stops]
        lengths = [one.to_m - one.from_m for one in reversed(self._stops)]
        self._left_m = [*accumulate(lengths, initial=0.0)][::-1]
        trees_per_m = width_of(run) * TREES_PER_M2
        trees = [
            (one.to_m - one.from_m) * trees_per_m if one.spacing_m is None else len(one.plants_m)
            for one in reversed(self._stops)
        ]
        self._trees_left = [*accumulate(trees, initial=0.0)][::-1]

    def next(self, s_m: float, worked: set[tuple[int, int]]) -> Stretch | None:
        """Return the first stop at or after ``s_m`` whose ground is not worked yet."""
        for one in self._stops[bisect_left(self._at, s_m) :]:
            if self.key(one) not in worked:
                return one
        return None

    def key(self, stretch: Stretch) -> tuple[int, int]:
        """Return what names the ground of a stretch, whichever path leads there."""
        x, y = self.route.point_at((stretch.from_m + stretch.to_m) / 2)
        return round(x), round(y)

    def length_left_m(self, s_m: float) -> float:
        """Return the length of row that is planted from the stops at or after ``s_m``."""
        return self._left_m[bisect_left(self._at, s_m)]

    def trees_left(self, s_m: float) -> float:
        """Return how many trees are to be planted from the stops at or after ``s_m``."""
        return self._trees_left[bisect_left(self._at, s_m)]


def width_of(run: MissionRun) -> float:
    """Return how wide the staging area of a mission is, metres."""
    return min(run.mission.width_m, AREA_M)


def spacing_of(run: MissionRun) -> float | None:
    """Return how far apart the plants of a row are, metres; ``None``: as dense as usual."""
    spacing_m = run.mission.plant_spacing_m
    return None if isinstance(spacing_m, UnsetType) else spacing_m


def _lines(legs: Sequence[Leg]) -> Iterator[tuple[Leg, float]]:
    """Yield the legs that are planted, and where along the path the row or lap began that each is a piece of."""
    before, line_m = None, 0.0
    for leg in legs:
        if not leg.is_tool_on:
            before = None
            continue
        if before is None or before.row != leg.row:
            line_m = leg.own_start_m
        before = leg
        yield leg, line_m


def _in_line(stretches: Sequence[Stretch], line_m: float, spacing_m: float | None) -> list[Stretch]:
    """Return the stretches with their plants, the first half a spacing from ``line_m``; those without any are gone."""
    if spacing_m is None:
        return list(stretches)
    found = []
    for one in stretches:
        first = math.ceil((one.from_m - line_m) / spacing_m - 0.5)
        end = math.ceil((one.to_m - line_m) / spacing_m - 0.5)
        plants = tuple(line_m + (k + 0.5) * spacing_m for k in range(first, end))
        if plants:
            found.append(replace(one, plants_m=plants, spacing_m=spacing_m))
    return found


def _stretches(row: int, from_m: float, to_m: float, length_m: float) -> list[Stretch]:
    many = max(math.ceil((to_m - from_m - LEAST_M) / AREA_M), 1)
    found = []
    for n in range(many):
        begin, end = from_m + n * AREA_M, from_m + (n + 1) * AREA_M if n < many - 1 else to_m
        found.append(Stretch(row, begin, end, min(end + BEHIND_M, length_m - 0.05)))
    return found

"""Where along its mission a planter stops, and which piece of row it plants from there."""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import TYPE_CHECKING

from backend_clients.simulator.planting_site import AREA_M, Stretch

if TYPE_CHECKING:
    from backend_clients.simulator.mission_run import MissionRun

BEHIND_M = 4.0  # from the machine's reference point back to the near edge of the area
LEAST_M = 0.8  # a shorter piece at the end of a row belongs to the one before


class Stops:
    """The stops of one path, in driving order."""

    def __init__(self, run: MissionRun) -> None:
        self.route = run.route
        self._stops = [
            stretch
            for leg in run.route.legs
            if leg.is_tool_on
            for stretch in _stretches(leg.row, leg.own_start_m, leg.end_m, run.route.length_m)
        ]
        self._at = [one.stop_m for one in self._stops]

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

    def area_left(self, s_m: float, worked: set[tuple[int, int]]) -> float:
        """Return the length of row that is still to be planted, metres."""
        left = self._stops[bisect_left(self._at, s_m) :]
        return sum(one.to_m - one.from_m for one in left if self.key(one) not in worked)


def width_of(run: MissionRun) -> float:
    """Return how wide the staging area of a mission is, metres."""
    return min(run.mission.width_m, AREA_M)


def _stretches(row: int, from_m: float, to_m: float, length_m: float) -> list[Stretch]:
    many = max(math.ceil((to_m - from_m - LEAST_M) / AREA_M), 1)
    found = []
    for n in range(many):
        begin, end = from_m + n * AREA_M, from_m + (n + 1) * AREA_M if n < many - 1 else to_m
        found.append(Stretch(row, begin, end, min(end + BEHIND_M, length_m - 0.05)))
    return found

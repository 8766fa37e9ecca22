"""Rows along a curve, as they lie around a machine: the longest row of its mission leads, all others run beside it."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

from backend_clients.simulator.cameras.scene import Line, Rows
from backend_clients.simulator.route import Leg, Point, Route

STRAIGHT_M = 0.1  # off the line between its ends; less nobody sees
LOOK_M = 2.0  # the bend is that of so much row before and behind
LEAST_RADIUS_M = 3.0


def leading_row(route: Route) -> Leg | None:
    """Return the row that tells how the others lie: the longest."""
    rows = [one for one in route.legs if one.kind == "row"]
    return max(rows, key=lambda one: one.end_m - one.own_start_m, default=None)


def is_bent(route: Route, leg: Leg) -> bool:
    """Say whether a row leaves the straight line between its ends."""
    line = route.part(leg.own_start_m, leg.end_m)
    (ax, ay), (bx, by) = line[0], line[-1]
    long_m = math.hypot(bx - ax, by - ay)
    if long_m < STRAIGHT_M:
        return True
    return any(abs((x - ax) * (by - ay) - (y - ay) * (bx - ax)) / long_m > STRAIGHT_M for x, y in line)


@dataclass(slots=True)
class BentRows:
    """The rows of one mission, for looks from wherever its machine is."""

    route: Route
    leg: Leg
    crop: str
    spacing_m: float
    _boxes: dict[int, tuple[float, float, float, float]] = field(default_factory=dict)

    def near(self, here: Point) -> Rows:
        """Return how the rows lie around a place; beyond their ends they go on bending as there."""
        start_m, end_m = self.leg.own_start_m, self.leg.end_m
        s_m = self.route.locate(*here, start_m, end_m)
        look_m = min(LOOK_M, (end_m - start_m) / 2)
        middle_m = min(max(s_m, start_m + look_m), end_m - look_m)
        first, last = self._way(middle_m - look_m, middle_m), self._way(middle_m, middle_m + look_m)
        bend = math.remainder(last - first, 2 * math.pi) / look_m
        way = self._way(middle_m - look_m, middle_m + look_m) + bend * (s_m - middle_m)
        x, y = self.route.point_at(s_m)
        dx, dy = here[0] - x, here[1] - y
        over = dx * math.cos(way) + dy * math.sin(way)
        across = dy * math.cos(way) - dx * math.sin(way)
        inner = bend / max(1 - bend * across, abs(bend) * LEAST_RADIUS_M)  # of the row through that place
        return Rows(self.crop, self.spacing_m, way, here, inner, (s_m - start_m + over, across))

    def worked(self, leg: Leg, until_m: float, here: Point, reach_m: float) -> list[Line]:
        """Return the part of a segment near a place, up to ``until_m`` on the route, as short lines."""
        if leg.index not in self._boxes:
            xs, ys = zip(*self.route.part(leg.own_start_m, leg.end_m), strict=True)
            self._boxes[leg.index] = (min(xs), min(ys), max(xs), max(ys))
        left, low, right, high = self._boxes[leg.index]
        if not (left - reach_m < here[0] < right + reach_m and low - reach_m < here[1] < high + reach_m):
            return []
        until_m = min(until_m, leg.end_m)
        middle_m = self.route.locate(*here, leg.own_start_m, until_m)
        if math.dist(self.route.point_at(middle_m), here) > reach_m:
            return []
        places = self.route.part(max(middle_m - reach_m, leg.own_start_m), min(middle_m + reach_m, until_m))
        return [(*a, *b) for a, b in itertools.pairwise(places)]

    def _way(self, from_m: float, until_m: float) -> float:
        (ax, ay), (bx, by) = self.route.point_at(from_m), self.route.point_at(until_m)
        return math.atan2(by - ay, bx - ax)

"""Cheapest ways over the corners of the ground: short, and off the standing rows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from hmi.planning.projection import Floats

CROP_COST = 8.0  # a metre across standing rows costs as much as nine along the headland


@dataclass(frozen=True, slots=True, eq=False)
class _Sight:
    """Straight lines from one place to N others.

    ``lengths_m`` is infinite where a line leaves the ground; ``across_m`` is its part over standing rows, NaN as
    long as nobody needed it: that is the dear part of looking.
    """

    lengths_m: Floats
    across_m: Floats


class Ways:
    """The ways between any two places of one ground.

    Args:
        free: ground that a way may not leave, prepared.
        crop: standing rows that a way should go around, prepared.
        corners: (N, 2) places where a way may bend.
    """

    def __init__(self, free: BaseGeometry, crop: BaseGeometry, corners: Floats) -> None:
        self._free, self._crop, self._corners = free, crop, corners
        self._seen: dict[int, _Sight] = {}

    def cheapest(self, ends: Floats) -> Floats | None:
        """Return the cheapest polyline from the first to the second of ``ends``, or ``None``.

        Dijkstra's way, which looks around only from corners that it comes by, each time once.
        """
        n = len(self._corners)
        start, goal = n, n + 1
        nodes = np.vstack([self._corners, ends])
        to_goal = self._look(ends[1], self._corners)
        best = np.full(n + 2, math.inf)
        best[start] = 0.0
        came = np.full(n + 2, start)
        is_open = np.ones(n + 2, dtype=bool)
        while True:
            node = int(np.argmin(np.where(is_open, best, math.inf)))
            if node == goal or not is_open[node] or not math.isfinite(best[node]):
                break
            is_open[node] = False
            sight = self._look(ends[0], nodes) if node == start else self._from_corner(node)
            self._relax(sight, node, nodes, best, came)
            if node != start:
                # lines to the goal are kept by the corner they come from
                self._relax_goal(to_goal, node, nodes, best, came)
        if not math.isfinite(best[goal]):
            return None
        order = [goal]
        while order[-1] != start:
            order.append(int(came[order[-1]]))
        return np.asarray(nodes[order[::-1]], dtype=np.float64)

    def _relax(self, sight: _Sight, node: int, nodes: Floats, best: Floats, came: Floats) -> None:
        n = len(sight.lengths_m)
        is_hopeful = best[node] + sight.lengths_m < np.minimum(best[:n], best[-1])
        unknown = np.flatnonzero(is_hopeful & np.isnan(sight.across_m))
        sight.across_m[unknown] = self._across(nodes[node], nodes[unknown])
        hopeful = np.flatnonzero(is_hopeful)
        totals = best[node] + sight.lengths_m[hopeful] + CROP_COST * sight.across_m[hopeful]
        better = totals < best[hopeful]
        best[hopeful[better]] = totals[better]
        came[hopeful[better]] = node

    def _relax_goal(self, to_goal: _Sight, node: int, nodes: Floats, best: Floats, came: Floats) -> None:
        if best[node] + to_goal.lengths_m[node] >= best[-1]:
            return
        if np.isnan(to_goal.across_m[node]):
            to_goal.across_m[node] = self._across(nodes[node], nodes[-1:])[0]
        total = best[node] + to_goal.lengths_m[node] + CROP_COST * to_goal.across_m[node]
        if total < best[-1]:
            best[-1], came[-1] = total, node

    def _from_corner(self, number: int) -> _Sight:
        if number not in self._seen:
            self._seen[number] = self._look(self._corners[number], self._corners)
        return self._seen[number]

    def _look(self, place: Floats, others: Floats) -> _Sight:
        lines = _lines(place, others)
        lengths = np.where(shapely.covers(self._free, lines), shapely.length(lines), math.inf)
        across = np.zeros(len(others))
        seen = np.flatnonzero(np.isfinite(lengths))
        across[seen[shapely.intersects(self._crop, lines[seen])]] = math.nan
        return _Sight(lengths, across)

    def _across(self, place: Floats, others: Floats) -> Floats:
        lengths: Floats = shapely.length(shapely.intersection(_lines(place, others), self._crop))
        return lengths


def _lines(place: Floats, others: Floats) -> Floats:
    lines: Floats = shapely.linestrings(np.stack([np.broadcast_to(place, others.shape), others], axis=1))
    return lines

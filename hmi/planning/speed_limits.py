"""Slow zones: legs are cut where one begins or ends, and driven no faster in it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from hmi.planning.plan import Leg
from hmi.planning.projection import Floats
from hmi.planning.spans import Zone, between, joined, merged, spans_along, without_later

SNAP_M = 0.05  # a cut nearer to a corner lies on it: paths are told in millimetres, crumbs would have any heading


@dataclass(frozen=True)  # no slots: the zones are worked out once
class SpeedLimits:
    """The most a machine may drive, in the plan's plane.

    Args:
        areas: ground where its base may not be faster than so many m/s; where they overlap, the slowest counts.
    """

    areas: tuple[Zone, ...] = ()

    def cut(self, legs: Sequence[Leg]) -> list[Leg]:
        """Return the legs cut at the borders of the areas, none of them too fast."""
        return [piece for leg in legs for piece in self.pieces(leg)]

    def pieces(self, leg: Leg) -> list[Leg]:
        """Return one leg cut; itself where it is slow enough."""
        if not self.areas or not shapely.intersects(self._anywhere, shapely.linestrings(leg.points)):
            return [leg]
        found = merged(spans_along(leg.points, self._zones, math.inf))
        spans = joined((begin, end, min(leg.speed_mps, most)) for begin, end, most in found)
        ends = [0.0, *(_on_corner(leg.points, end) for _, end, _ in spans[:-1]), spans[-1][1]]
        return [
            replace(
                leg,
                points=between(leg.points, ends[k], ends[k + 1]),
                speed_mps=speed,
                pivot=leg.pivot and k == 0,
                is_continued=leg.is_continued or k > 0,
            )
            for k, (_, _, speed) in enumerate(spans)
        ]

    @cached_property
    def _anywhere(self) -> BaseGeometry:
        area = shapely.union_all([area for area, _ in self.areas])
        shapely.prepare(area)
        return area

    @cached_property
    def _zones(self) -> list[Zone]:
        return without_later(sorted(self.areas, key=lambda area: -area[1]))


def _on_corner(points: Floats, at_m: float) -> float:
    """Return a distance along a line, or that of an inner corner that is next to it."""
    inner = np.cumsum(np.hypot(*np.diff(points, axis=0).T))[:-1]
    if not len(inner):
        return at_m
    nearest = float(inner[np.argmin(np.abs(inner - at_m))])
    return nearest if abs(nearest - at_m) < SNAP_M else at_m


UNLIMITED = SpeedLimits()

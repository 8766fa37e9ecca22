"""A cornered way made one that a machine drives: its corners rounded with the turning radius."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from hmi.planning import dubins
from hmi.planning.links import Linker
from hmi.planning.polyline import distinct
from hmi.planning.projection import Floats

_WIDER_M = (0.0, 0.1, 0.2, 0.4, 0.7, 1.1, 1.7, 2.6, 4.0, 6.0, 9.0)
"""How far a corner is moved outward, along the piece before it and the one after it."""
_WIDER = sorted(((later, sooner) for later in _WIDER_M for sooner in _WIDER_M), key=sum)
_MOST_TRIES = 250  # places of corners looked at for one way
_MOST_CORNERS = 300  # of a way of kilometres
_LAST_TRIES = _MOST_CORNERS  # after those a way is ended as it comes; each turn on the spot would double them
_STRAIGHT_RAD = math.radians(0.5)
_STEP_M = 0.05
_STEP_RAD = math.radians(8)
_FAR_M = 1000.0  # longer than what any arc takes of a piece
_MOST_RAD = math.radians(160)  # nearly back: no corner to be rounded


class BentWay:
    """Rounds the corners of one way on the ground of a linker.

    Args:
        way: (N, 2) corners, metres.
        radius_m: of its arcs.
    """

    def __init__(self, linker: Linker, way: Floats, radius_m: float) -> None:
        self._ground = linker.ground
        self._machine = linker.machine
        self._radius = radius_m
        self._stops: list[int] = []
        self._left = _MOST_TRIES
        self._corners = [np.asarray(one, dtype=float) for one in self._merged(way)]

    def pieces(self) -> list[Floats] | None:
        """Return polylines that the machine drives, with a turn on the spot between two of them.

        ``None`` if a corner is too tight, or no way round all of them was found among those that were tried.
        """
        if len(self._corners) > _MOST_CORNERS or not self._driven(0, 1):
            return None
        stops = [0, *self._stops, len(self._corners) - 1]
        done = [self._rounded(self._corners[a : b + 1]) for a, b in pairwise(stops)]
        whole = [piece for piece in done if piece is not None and self._ground.fits(piece)]
        return whole if len(whole) == len(done) else None

    def _driven(self, first: int, k: int) -> bool:
        """Place corner ``k`` and those after it so that they can be driven.

        Args:
            first: where the piece begins: corners before it are behind a turn on the spot.
        """
        corners = self._corners
        if k == len(corners) - 1:
            return True
        if self._left <= -_LAST_TRIES:
            return False
        there = corners[k]
        u, v = _unit(there - corners[k - 1]), _unit(corners[k + 1] - there)
        for later_m, sooner_m in _WIDER:
            corners[k] = there + later_m * u - sooner_m * v
            if self._fits(first, k) and self._driven(first, k + 1):
                return True
            if self._left <= 0:
                break
        corners[k] = there
        if self._machine.can_pivot and self._ground.can_turn_at((float(there[0]), float(there[1]))):
            self._stops.append(k)
            if self._driven(k, k + 1):
                return True
            self._stops.pop()
        return False

    def _fits(self, first: int, k: int) -> bool:
        self._left -= 1
        here, u, v = self._corners[k], *self._directions(k)
        arc = self._rounded([here - _FAR_M * u, here, here + _FAR_M * v])
        if arc is None or not self._ground.fits(arc[1:-1]):
            return False
        around = self._around(first, k)
        return around is not None and self._ground.fits(around)

    def _directions(self, k: int) -> tuple[Floats, Floats]:
        corners = self._corners
        return _unit(corners[k] - corners[k - 1]), _unit(corners[k + 1] - corners[k])

    def _around(self, first: int, k: int) -> Floats | None:
        """Return the way around corner ``k`` and the one before it, as far as their arcs or half their pieces."""
        corners = self._corners
        is_first = k - 1 <= first
        here = corners[first : k + 1] if is_first else corners[k - 1 : k + 1]
        u = None if is_first else _unit(corners[k - 1] - corners[k - 2])
        before = [] if u is None else [corners[k - 1] - u * self._reach_m(corners[k - 2], corners[k - 1], corners[k])]
        v = _unit(corners[k + 1] - corners[k])
        after = corners[k] + v * self._reach_m(corners[k + 1], corners[k], corners[k - 1])
        return self._rounded([*before, *here, after])

    def _reach_m(self, outer: Floats, corner: Floats, inner: Floats) -> float:
        """Return how far an arc at a corner reaches toward ``outer``, half its piece at the least."""
        bend = abs(_angle(_unit(corner - inner), _unit(outer - corner)))
        half_m = float(np.hypot(*(outer - corner))) / 2
        return max(half_m, self._radius * math.tan(bend / 2) + _STEP_M) if bend < _MOST_RAD else half_m

    def _rounded(self, corners: list[Floats]) -> Floats | None:
        """Return the corners as arcs, ``None`` if there is no room between two of them."""
        points = [corners[0]]
        room_m = 0.0  # of the piece before, taken by its arc
        for before, here, after in zip(corners, corners[1:], corners[2:], strict=False):
            u, v = _unit(here - before), _unit(after - here)
            bend = _angle(u, v)
            if abs(bend) < _STRAIGHT_RAD:
                points.append(here)
                room_m = 0.0
                continue
            cut_m = self._radius * math.tan(abs(bend) / 2) if abs(bend) < _MOST_RAD else math.inf
            if room_m + cut_m > float(np.hypot(*(here - before))) or cut_m > float(np.hypot(*(after - here))):
                return None
            points.extend(self._arc(here - cut_m * u, u, bend))
            room_m = cut_m
        points.append(corners[-1])
        return distinct(np.array(points))

    def _arc(self, start: Floats, u: Floats, bend: float) -> Floats:
        """Return an arc of the turning radius that begins at ``start`` with heading ``u``."""
        parts = np.linspace(0.0, abs(bend), max(2, math.ceil(abs(bend) / _STEP_RAD) + 1))
        turned = dubins.along("L" if bend > 0 else "R", 0.0, 0.0, math.atan2(u[1], u[0]), parts)
        return np.asarray(start + self._radius * turned[:, :2])

    def _merged(self, way: Floats) -> list[Floats]:
        """Return the corners, two of a bend too near to each other as the one in which their outer pieces meet."""
        corners = [np.asarray(one, dtype=float) for one in way]
        k = 1
        while k + 2 < len(corners):
            met = self._met(*corners[k - 1 : k + 3])
            if met is None:
                k += 1
            else:
                corners[k : k + 2] = [met]
                k = max(1, k - 1)
        return corners

    def _met(self, a: Floats, b: Floats, c: Floats, d: Floats) -> Floats | None:
        u, v, w = _unit(b - a), _unit(c - b), _unit(d - c)
        one, two = _angle(u, v), _angle(v, w)
        together = one + two
        if one * two <= 0 or abs(together) >= _MOST_RAD or abs(together) < _STRAIGHT_RAD:
            return None
        cuts_m = self._radius * (math.tan(abs(one) / 2) + math.tan(abs(two) / 2))
        if cuts_m <= float(np.hypot(*(c - b))):
            return None
        cross = u[0] * w[1] - u[1] * w[0]
        along_m = ((c[0] - b[0]) * w[1] - (c[1] - b[1]) * w[0]) / cross
        return None if along_m < 0 else b + along_m * u


def _unit(way: Floats) -> Floats:
    return way / max(float(np.hypot(*way)), 1e-9)


def _angle(u: Floats, v: Floats) -> float:
    return math.atan2(u[0] * v[1] - u[1] * v[0], float(u @ v))

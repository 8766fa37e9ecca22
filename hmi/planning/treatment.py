"""Where the tool works and how much: rows and laps are cut at the borders of areas with a dose of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from hmi.planning.plan import Leg
from hmi.planning.projection import Floats

SLIVER_M = 0.1  # pieces shorter than this are the rounding of two borders, not a wish
USUAL = 1.0

Span = tuple[float, float, float]
"""From and to in metres along a line, and the dose there."""


@dataclass(frozen=True)  # no slots: the zones are worked out once
class DoseMap:
    """The doses of a field, in the plan's plane.

    Args:
        areas: ground with a dose of its own, later ones win.
        rest: dose of all other ground.
        lead_in_m, lead_out_m: the tool is on so long before it enters treated ground and after it leaves it.
    """

    areas: tuple[tuple[BaseGeometry, float], ...] = ()
    rest: float = USUAL
    lead_in_m: float = 0.0
    lead_out_m: float = 0.0

    @property
    def is_plain(self) -> bool:
        """Whether all ground gets the usual dose."""
        return not self.areas and self.rest == USUAL

    def wanted(self, field: BaseGeometry) -> BaseGeometry:
        """Return the part of a field that is to be treated."""
        off = [zone for zone, dose in self._zones if dose == 0]
        if self.rest == 0:
            return field.intersection(shapely.union_all([zone for zone, dose in self._zones if dose > 0]))
        return field.difference(shapely.union_all(off)) if off else field

    def zone(self, field: BaseGeometry, dose: float) -> BaseGeometry:
        """Return the part of a field that gets one dose."""
        zones = [zone for zone, own in self._zones if own == dose]
        if self.rest == dose:
            zones.append(field.difference(shapely.union_all([zone for zone, _ in self._zones])))
        return field.intersection(shapely.union_all(zones))

    def is_wanted_along(self, points: Floats) -> bool:
        """Say whether anything along a line is to be treated."""
        return self.is_plain or any(dose > 0 for _, _, dose in self._spans(points))

    def cut(self, legs: Sequence[Leg]) -> list[Leg]:
        """Return the legs with those that work cut where the dose changes; the tool is off where it is 0."""
        if self.is_plain:
            return list(legs)
        return [piece for leg in legs for piece in (self._pieces(leg) if leg.tool_on else [leg])]

    @cached_property
    def _zones(self) -> list[tuple[BaseGeometry, float]]:
        """The areas without what later ones cover."""
        zones: list[tuple[BaseGeometry, float]] = []
        taken: BaseGeometry = shapely.Polygon()
        for area, dose in reversed(self.areas):
            zones.append((area.difference(taken), dose))
            taken = taken.union(area)
        return zones

    def _pieces(self, leg: Leg) -> list[Leg]:
        spans = self._led(_merged(self._spans(leg.points)))
        pieces = []
        for number, (begin, end, dose) in enumerate(spans):
            piece = replace(
                leg,
                points=between(leg.points, begin, end),
                # more than the usual dose takes more time on each metre
                speed_mps=leg.speed_mps / max(1.0, dose),
                tool_on=dose > 0,
                dose=dose if dose > 0 else USUAL,
                pivot=leg.pivot and number == 0,
                is_continued=leg.is_continued or number > 0,
            )
            pieces.append(piece)
        return pieces

    def _spans(self, points: Floats) -> list[Span]:
        """Return the doses along a line in order, without gaps."""
        steps = np.hypot(*np.diff(points, axis=0).T)
        starts = np.append(0.0, np.cumsum(steps))
        lines = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
        found: list[Span] = []
        for zone, dose in self._zones:
            parts, owner = shapely.get_parts(shapely.intersection(lines, zone), return_index=True)
            for part, k in zip(parts, owner, strict=True):
                if part.geom_type != "LineString" or part.is_empty:
                    continue
                ends = np.hypot(*(shapely.get_coordinates(part)[[0, -1]] - points[k]).T)
                found.append((float(starts[k] + ends.min()), float(starts[k] + ends.max()), dose))
        return _filled(sorted(found), float(starts[-1]), self.rest)

    def _led(self, spans: list[Span]) -> list[Span]:
        """Let the tool begin before treated ground and end after it; a gap shorter than both is worked through."""
        led: list[Span] = []
        for number, (begin, end, dose) in enumerate(spans):
            if dose > 0:
                led.append((led[-1][1] if led else begin, end, dose))
                continue
            first = begin + (self.lead_out_m if number > 0 else 0.0)
            last = end - (self.lead_in_m if number + 1 < len(spans) else 0.0)
            if first > last - SLIVER_M and 0 < number < len(spans) - 1:
                first = last = min(max((first + last) / 2, begin), end)
            first, last = min(first, end), max(last, begin)
            if led:
                led[-1] = (led[-1][0], first, led[-1][2])
            if last - first > SLIVER_M:
                led.append((first, last, 0.0))
            elif not led:
                led.append((begin, begin, spans[1][2] if len(spans) > 1 else 0.0))
        return [span for span in _joined(led) if span[1] - span[0] > 1e-3]


def _filled(found: list[Span], length_m: float, rest: float) -> list[Span]:
    spans: list[Span] = []
    here = 0.0
    for begin, end, dose in found:
        if begin > here + 1e-9:
            spans.append((here, begin, rest))
        spans.append((max(begin, here), max(end, here), dose))
        here = max(here, end)
    if length_m > here:
        spans.append((here, length_m, rest))
    return _joined(spans)


def _joined(spans: list[Span]) -> list[Span]:
    """Join neighbours of one dose."""
    joined: list[Span] = []
    for begin, end, dose in spans:
        if joined and joined[-1][2] == dose:
            joined[-1] = (joined[-1][0], end, dose)
        else:
            joined.append((begin, end, dose))
    return joined


def _merged(spans: list[Span]) -> list[Span]:
    """Give slivers to their neighbours."""
    kept = [span for span in spans if span[1] - span[0] > SLIVER_M] or spans[:1]
    edges = [spans[0][0], *((a[1] + b[0]) / 2 for a, b in pairwise(kept)), spans[-1][1]]
    return _joined([(edges[k], edges[k + 1], span[2]) for k, span in enumerate(kept)])


def between(points: Floats, begin_m: float, end_m: float) -> Floats:
    """Return the part of a polyline between two distances along it."""
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    if begin_m <= 1e-9 and end_m >= along[-1] - 1e-9:
        return points
    inside = (along > begin_m + 1e-6) & (along < end_m - 1e-6)
    ends = np.array([[np.interp(s, along, points[:, 0]), np.interp(s, along, points[:, 1])] for s in (begin_m, end_m)])
    return np.vstack([ends[:1], points[inside], ends[1:]])


EVERYWHERE = DoseMap()

"""Where the tool works and how much: rows and laps are cut at the borders of areas with a dose of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import shapely
from shapely.geometry.base import BaseGeometry

from hmi.planning.plan import Leg
from hmi.planning.projection import Floats
from hmi.planning.spans import SLIVER_M, Span, Zone, between, joined, merged, spans_along, without_later

USUAL = 1.0


@dataclass(frozen=True)  # no slots: the zones are worked out once
class DoseMap:
    """The doses of a field, in the plan's plane.

    Args:
        areas: ground with a dose of its own, later ones win.
        rest: dose of all other ground.
        lead_in_m, lead_out_m: the tool is on so long before it enters treated ground and after it leaves it.
    """

    areas: tuple[Zone, ...] = ()
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
    def _zones(self) -> list[Zone]:
        """The areas without what later ones cover."""
        return without_later(self.areas)

    def _pieces(self, leg: Leg) -> list[Leg]:
        spans = self._led(merged(self._spans(leg.points)))
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
        return spans_along(points, self._zones, self.rest)

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
        # a sliver without treatment at the end is worked: the line goes on to where it ended
        led[-1] = (led[-1][0], spans[-1][1], led[-1][2])
        return [span for span in joined(led) if span[1] - span[0] > 1e-3]


EVERYWHERE = DoseMap()

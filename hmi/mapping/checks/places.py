"""Features in a place on earth where they cannot be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from hmi.mapping.checks.finding import BLOCKS, Finding, Fix
from hmi.mapping.coordinates import paths
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import distance_m
from hmi.mapping.operations.cut_antimeridian import can_cut

FAR_M = 200_000.0


def crosses_antimeridian(feature: MapFeature) -> bool:
    """Say whether an edge jumps from one side of longitude 180 to the other."""
    for path in paths(feature.geometry):
        lons = [p[0] for p in path]
        if max(lons) - min(lons) > 180 and any(abs(b - a) > 180 for a, b in pairwise(lons)):
            return True
    return False


def antimeridian(features: Sequence[MapFeature]) -> Iterator[Finding]:
    """Find features that cross longitude 180."""
    for one in features:
        if crosses_antimeridian(one):
            yield Finding(
                "antimeridian",
                BLOCKS,
                one.id,
                "Shape crosses the line of longitude 180.",
                "Check its corners. If it lies there, it must be one feature on each side.",
                at=list(paths(one.geometry)[0][0]),
                fix=Fix("Cut at 180°", "cut_antimeridian", (one.id,)) if can_cut(one) else None,
            )


def swapped(features: Sequence[MapFeature], groups: Sequence[Sequence[int]]) -> Iterator[Finding]:
    """Find groups of features far from all others that would lie among others with latitude and longitude exchanged.

    ``groups`` are indices of ``features`` (``hmi.mapping.checks.site.grouped``).
    Of two groups that mirror each other the smaller is wrong, of two as large the one added later.
    """
    middles = [_middle([features[n] for n in group]) for group in groups]
    for k, group in enumerate(groups):
        others = [n for n in range(len(groups)) if n != k]
        lon, lat = middles[k]
        if not others or abs(lon) > 90 or min(distance_m(middles[n], middles[k]) for n in others) <= FAR_M:
            continue
        near = [n for n in others if distance_m(middles[n], (lat, lon)) < FAR_M]
        if not any((len(groups[n]), -groups[n][0]) > (len(group), -group[0]) for n in near):
            continue
        ids = tuple(features[n].id for n in group if _can_swap(features[n]))
        for n in group:
            yield Finding(
                "swapped",
                BLOCKS,
                features[n].id,
                "Latitude and longitude look exchanged.",
                "It lies far from everything else, and beside it when they are exchanged back.",
                at=list(paths(features[n].geometry)[0][0]),
                fix=Fix("Exchange", "swap_axes", ids),
            )


def _middle(features: Sequence[MapFeature]) -> tuple[float, float]:
    places = [paths(one.geometry)[0][0] for one in features]
    return sum(p[0] for p in places) / len(places), sum(p[1] for p in places) / len(places)


def _can_swap(feature: MapFeature) -> bool:
    return all(abs(lon) <= 90 for path in paths(feature.geometry) for lon, _ in path)

"""Checks of a map: what blocks publishing, and what to look at."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from hmi.mapping.checks.finding import BLOCKS, LOOK, Finding, Fix
from hmi.mapping.checks.holes import holes
from hmi.mapping.checks.neighbours import overlaps, slivers
from hmi.mapping.checks.outlines import crossings, needless_corners, unsound, winding
from hmi.mapping.checks.places import antimeridian, crosses_antimeridian, swapped
from hmi.mapping.checks.site import Site, grouped, site_of
from hmi.mapping.checks.sizes import areas, narrow
from hmi.mapping.checks.ways import closed, gaps, unreachable
from hmi.mapping.feature import MapFeature

__all__ = ["BLOCKS", "LOOK", "Finding", "Fix", "check"]


def check(features: Iterable[MapFeature], machine_width_m: float | None = None) -> list[Finding]:
    """Return what is wrong with a map, what blocks first, then in the order of the features.

    Args:
        features: the whole map; each by itself has passed ``parse_feature``.
        machine_width_m: of the widest machine that works here; without it no parcel is too narrow.
    """
    every = list(features)
    found = list(antimeridian(every))
    placed = [one for one in every if not crosses_antimeridian(one)]
    groups = grouped(placed)
    found += swapped(placed, groups)
    has_roads = any(one.kind == "road" for one in every)
    for group in groups:
        found += _of_site(site_of([placed[n] for n in group]), machine_width_m, has_roads=has_roads)
    order = {one.id: n for n, one in enumerate(every)}
    return sorted(found, key=lambda one: (one.level, order[one.feature_id]))


def _of_site(site: Site, machine_width_m: float | None, *, has_roads: bool) -> Iterator[Finding]:
    shaped = [*crossings(site), *needless_corners(site), *holes(site)]
    yield from shaped
    yield from unsound(site, {one.feature_id for one in shaped if one.level == BLOCKS})
    yield from winding(site)
    yield from overlaps(site)
    yield from slivers(site)
    yield from gaps(site)
    yield from closed(site)
    yield from areas(site)
    if has_roads:
        yield from unreachable(site)
    if machine_width_m is not None and machine_width_m > 0:
        yield from narrow(site, machine_width_m)

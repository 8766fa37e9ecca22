"""Roads that do not meet or run through closed ground, and parcels no road leads to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import STRtree
from shapely.geometry.base import BaseGeometry

from hmi.domain.map_ground import CLOSED_KINDS, CROSSED_KINDS
from hmi.mapping.checks.finding import LOOK, Finding, Fix
from hmi.mapping.checks.site import Site
from hmi.mapping.ground import widened
from hmi.mapping.kinds import LINE
from hmi.mapping.operations.snap_end import ON_ROAD_M

GAP_M = 3.0  # further apart nobody meant them to meet
REACH_M = 30.0
BARELY_M = 1.0  # a road that ends at a building or passes its corner
SHUT_KINDS = tuple(kind for kind in CLOSED_KINDS if kind not in CROSSED_KINDS)


def gaps(site: Site) -> Iterator[Finding]:
    """Find road ends within 3 m of another road that are on none."""
    of = site.of_kind("road")
    lines = [n for n in of if site.features[n].geometry["type"] == LINE]
    if not lines or len(of) < 2:
        return
    ends = shapely.points([site.shapes[n].coords[k] for n in lines for k in (0, -1)])
    end, road = STRtree(site.shapes[of]).query(ends, predicate="dwithin", distance=GAP_M)
    other = of[road] != np.asarray(lines)[end // 2]
    end, road = end[other], road[other]
    distance = shapely.distance(ends[end], site.shapes[of[road]])
    said: set[tuple[frozenset[int], int]] = set()
    for k in np.unique(end):
        mine = np.flatnonzero(end == k)
        nearest = mine[np.argmin(distance[mine])]
        gap_m = float(distance[nearest])
        own, to = lines[int(k) // 2], int(of[road[nearest]])
        key = (frozenset((int(own), to)), round(gap_m * 100))  # two ends that miss each other are one gap
        if gap_m <= ON_ROAD_M or key in said:
            continue
        said.add(key)
        feature, target = site.features[own], site.features[to]
        yield Finding(
            "road_gap",
            LOOK,
            feature.id,
            f"Road ends {max(gap_m, 0.1):.1f} m short.",
            "Robots cannot route across the gap.",
            other_id=target.id,
            at=site.place(ends[k]),
            fix=Fix(f"Join to {target.title}", "snap_end", (feature.id,), {"to": target.id}),
        )


def closed(site: Site) -> Iterator[Finding]:
    """Find roads drawn through ground that no machine enters; yards have buildings on them."""
    lines = [int(n) for n in site.of_kind("road") if site.features[n].geometry["type"] == LINE]
    shut = _shut(site)
    if not lines or not shut:
        return
    grounds = np.array([ground for _, ground in shut], dtype=object)
    for road, k in STRtree(grounds).query(site.shapes[lines], predicate="intersects").T:
        inside = site.shapes[lines[road]].intersection(grounds[k])
        if inside.length < BARELY_M:
            continue
        own, other = site.features[lines[road]], site.features[shut[k][0]]
        yield Finding(
            "road_closed",
            LOOK,
            own.id,
            f"Road runs {inside.length:.0f} m through {other.title}.",
            "No robot drives in there. Lead the road around it.",
            other_id=other.id,
            at=site.place(inside.representative_point()),
        )


def unreachable(site: Site) -> Iterator[Finding]:
    """Find parcels without a road or home within 30 m, or whose roads lead to no home; for farms that have roads."""
    parcels, roads, homes = (site.of_kind(kind) for kind in ("parcel", "road", "home"))
    near = _near(site.shapes[parcels], site.shapes[[*roads, *homes]])
    led = near
    if len(homes):
        ground = shapely.union_all([_covered(site, int(n)).buffer(ON_ROAD_M) for n in roads])
        ground = shapely.difference(ground, shapely.union_all([shape for _, shape in _shut(site)]))
        ways = shapely.get_parts(ground)
        to_home = _near(ways, site.shapes[homes])
        led = _near(site.shapes[parcels], np.array([*ways[to_home], *site.shapes[homes]], dtype=object))
    lost = parcels[~led]
    places = site.places(shapely.point_on_surface(site.shapes[lost]))
    for n, at, is_near in zip(lost, places, near[~led], strict=True):
        what = "The road here leads to no home." if is_near else f"No road or home within {REACH_M:g} m of this parcel."
        way_out = "Join it to the road home." if is_near else "Draw a road to it."
        advice = f"Robots cannot drive there by themselves. {way_out}"
        yield Finding("unreachable", LOOK, site.features[n].id, what, advice, at=at)


def _near(shapes: NDArray[np.object_], others: NDArray[np.object_]) -> NDArray[np.bool_]:
    """Return which of N shapes have one of the others within 30 m."""
    is_near = np.zeros(len(shapes), dtype=bool)
    if len(shapes) and len(others):
        is_near[STRtree(others).query(shapes, predicate="dwithin", distance=REACH_M)[0]] = True
    return is_near


def _shut(site: Site) -> list[tuple[int, BaseGeometry]]:
    """Return index and ground of what no machine enters, and no road makes a gap in."""
    of = [int(n) for kind in SHUT_KINDS for n in site.of_kind(kind)]
    grounds = [(n, _covered(site, n)) for n in of]
    return [(n, ground) for n, ground in grounds if not ground.is_empty]


def _covered(site: Site, n: int) -> BaseGeometry:
    return widened(site.features[n], site.shapes[n])

"""Roads that do not meet, and parcels no road leads to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely import STRtree

from hmi.mapping.checks.finding import LOOK, Finding, Fix
from hmi.mapping.checks.site import Site
from hmi.mapping.kinds import LINE
from hmi.mapping.operations.snap_end import ON_ROAD_M

GAP_M = 3.0  # further apart nobody meant them to meet
REACH_M = 30.0


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


def unreachable(site: Site) -> Iterator[Finding]:
    """Find parcels without a road or home within 30 m; for farms that have roads."""
    parcels = site.of_kind("parcel")
    ways = np.concatenate([site.of_kind("road"), site.of_kind("home")])
    reached: set[int] = set()
    if len(ways) and len(parcels):
        hits = STRtree(site.shapes[ways]).query(site.shapes[parcels], predicate="dwithin", distance=REACH_M)[0]
        reached = set(parcels[hits].tolist())
    lost = [int(n) for n in parcels if int(n) not in reached]
    for n, at in zip(lost, site.places(shapely.point_on_surface(site.shapes[lost])), strict=True):
        yield Finding(
            "unreachable",
            LOOK,
            site.features[n].id,
            f"No road or home within {REACH_M:g} m of this parcel.",
            "Robots cannot drive there by themselves. Draw a road to it.",
            at=at,
        )

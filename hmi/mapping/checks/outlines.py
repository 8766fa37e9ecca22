"""Each outline by itself: crossing edges, needless corners, winding."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon

from hmi.mapping.checks.finding import BLOCKS, LOOK, Finding, Fix
from hmi.mapping.checks.site import Path, Site
from hmi.mapping.coordinates import is_ring
from hmi.mapping.operations.edges import DUPLICATE_M, SPIKE_RAD, crossing_edges, needless
from hmi.planning.projection import Floats

MOST_CROSSINGS = 5  # of one ring; who mends five looks again


def crossings(site: Site) -> Iterator[Finding]:
    """Find edges of one ring that cross; corners are numbered from 1, the loop lies between the two named.

    An outline that is only unsound because of needless corners is left to ``needless_corners``.
    """
    for n in np.flatnonzero(~site.is_valid):
        if _is_sound_when_clean(site, int(n)):
            continue
        feature = site.features[n]
        for path in _paths_of(site, int(n)):
            ring = site.corners_m[path.start : path.stop]
            kept = sorted(set(range(len(ring))) - set(needless(ring, is_closed=True)))
            where = f"Edge of hole {path.number}" if path.number else "Edge"
            for first, second in crossing_edges(ring[kept], MOST_CROSSINGS) if len(kept) > 2 else ():
                a, b = kept[(first + 1) % len(kept)] + 1, kept[second] + 1
                yield Finding(
                    "crosses_itself",
                    BLOCKS,
                    feature.id,
                    f"{where} crosses itself.",
                    f"Between corner {min(a, b)} and {max(a, b)}. Move one of them.",
                    at=site.place(_meeting(ring[kept], first, second)),
                    fix=Fix("Untangle", "untangle", (feature.id,)),
                )


def needless_corners(site: Site) -> Iterator[Finding]:
    """Find duplicate and spike corners; they block only where they make an outline unsound."""
    seen: dict[int, list[tuple[Path, int]]] = {}
    for path in _suspects(site):
        numbers = needless(site.corners_m[path.start : path.stop], is_closed=path.is_closed)
        if numbers:
            seen.setdefault(path.feature, []).extend((path, number) for number in numbers)
    for n, corners in seen.items():
        feature = site.features[n]
        path, number = corners[0]
        of = f" of hole {path.number}" if path.is_closed and path.number else ""
        more = f" and {len(corners) - 1} more" if len(corners) > 1 else ""
        blocks = not site.is_valid[n] and _is_sound_when_clean(site, n)
        yield Finding(
            "needless_corner",
            BLOCKS if blocks else LOOK,
            feature.id,
            f"Corner {number + 1}{of}{more} {'are' if more else 'is'} double or a spike.",
            "Remove it; the shape stays the same." if not more else "Remove them; the shape stays the same.",
            at=site.place(site.corners_m[path.start + number]),
            fix=Fix("Remove", "clean", (feature.id,)),
        )


def winding(site: Site) -> Iterator[Finding]:
    """Find rings that run the wrong way round: outlines run counter-clockwise, holes clockwise."""
    sound = np.array([n for n, one in enumerate(site.features) if is_ring(one.geometry) and site.is_valid[n]], np.intp)
    if not len(sound):
        return
    rings, of = shapely.get_rings(site.shapes[sound], return_index=True)
    is_outline = np.append(True, of[1:] != of[:-1])
    wrong = set(sound[of[shapely.is_ccw(rings) != is_outline]].tolist())
    for n in sorted(wrong):
        feature = site.features[n]
        yield Finding(
            "winding",
            LOOK,
            feature.id,
            "Outline runs the wrong way round.",
            "Turn its direction; the shape stays the same.",
            fix=Fix("Turn direction", "orient", (feature.id,)),
        )


def unsound(site: Site, blocked: set[str]) -> Iterator[Finding]:
    """Find what is unsound for a reason no other check names; ``blocked`` has a finding that blocks already."""
    for n in np.flatnonzero(~site.is_valid):
        feature = site.features[n]
        if feature.id not in blocked:
            yield Finding(
                "unsound",
                BLOCKS,
                feature.id,
                "Outline is not sound.",
                "Edges meet or lie on each other. Move the corners apart.",
                fix=Fix("Untangle", "untangle", (feature.id,)),
            )


def _suspects(site: Site) -> Iterator[Path]:
    """Yield the paths that have a duplicate or spike, all corners looked at in one go."""
    if not site.paths:
        return
    xy = site.corners_m
    before, after = np.arange(len(xy)) - 1, np.arange(len(xy)) + 1
    starts = np.array([path.start for path in site.paths])
    stops = np.array([path.stop for path in site.paths]) - 1
    closed = np.array([path.is_closed for path in site.paths])
    before[starts], after[stops] = np.where(closed, stops, starts), np.where(closed, starts, stops)
    back, on = xy[before] - xy, xy[after] - xy
    open_end = (before == np.arange(len(xy))) | (after == np.arange(len(xy)))
    near = (np.hypot(on[:, 0], on[:, 1]) < DUPLICATE_M) & (after != np.arange(len(xy)))
    turn = np.arctan2(np.abs(back[:, 0] * on[:, 1] - back[:, 1] * on[:, 0]), (back * on).sum(axis=1))
    flagged = near | ((turn < SPIKE_RAD) & ~open_end)
    counts = np.add.reduceat(flagged, starts)
    for path, count in zip(site.paths, counts, strict=True):
        if count and path.stop - path.start > 1:
            yield path


def _paths_of(site: Site, n: int) -> list[Path]:
    return [path for path in site.paths if path.feature == n]


def _is_sound_when_clean(site: Site, n: int) -> bool:
    rings = []
    for path in _paths_of(site, n):
        ring = site.corners_m[path.start : path.stop]
        ring = np.delete(ring, needless(ring, is_closed=True), axis=0)
        if len(ring) > 2:
            rings.append(ring)
        elif path.number == 0:
            return False
    return bool(rings) and bool(Polygon(rings[0], rings[1:]).is_valid)


def _meeting(ring: Floats, first: int, second: int) -> tuple[float, float]:
    edges = [LineString([ring[n], ring[(n + 1) % len(ring)]]) for n in (first, second)]
    x, y = shapely.shortest_line(*edges).coords[0]  # of edges that meet: where
    return (x, y)

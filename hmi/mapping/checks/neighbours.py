"""Parcels beside each other: overlaps, and slivers of nobody's land between them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import STRtree

from hmi.mapping.checks.finding import LOOK, Finding, Fix
from hmi.mapping.checks.site import Site
from hmi.mapping.ground import polygons_in
from hmi.mapping.measures import area_text
from hmi.mapping.operations.strips import SLIVER_M, strips_between

OVERLAP_M2 = 1.0
SLIVER_M2 = 1.0
TOUCH_M = 0.02  # nearer is the same edge


def overlaps(site: Site) -> Iterator[Finding]:
    """Find parcels that share more than 1 m²; the larger one would be cut back."""
    of = site.of_kind("parcel")
    first, second = _sharing(site.shapes[of])
    shared = shapely.intersection(site.shapes[of[first]], site.shapes[of[second]])
    areas = shapely.area(shared)
    for n in np.flatnonzero(areas > OVERLAP_M2):
        a, b = sorted((of[first[n]], of[second[n]]), key=lambda k: -float(shapely.area(site.shapes[k])))
        larger, smaller = site.features[a], site.features[b]
        is_same = shapely.area(site.shapes[a]) - areas[n] < OVERLAP_M2
        yield Finding(
            "overlap",
            LOOK,
            larger.id,
            f"Parcels overlap by {area_text(float(areas[n]))}.",
            f"{larger.title} and {smaller.title} are the same ground."
            if is_same
            else f"{larger.title} and {smaller.title} share ground; it would be worked twice.",
            other_id=smaller.id,
            at=site.place(polygons_in(shared[n])[0].representative_point()),
            fix=Fix("Make them one", "merge", (larger.id, smaller.id))
            if is_same
            else Fix(f"Cut back {larger.title}", "clip", (larger.id,), {"others": [smaller.id]}),
        )


def slivers(site: Site) -> Iterator[Finding]:
    """Find gaps narrower than 0.5 m along two parcels."""
    of = site.of_kind("parcel")
    shapes = site.shapes[of]
    for a, b in _gaping(shapes):
        gaps = [gap for gap in strips_between(shapes[a], shapes[b]) if gap.area > SLIVER_M2]
        if not gaps:
            continue
        one, other = (site.features[k] for k in sorted((of[a], of[b]), key=lambda k: -shapely.area(site.shapes[k])))
        yield Finding(
            "sliver",
            LOOK,
            one.id,
            f"A strip of {area_text(gaps[0].area)} lies between two parcels.",
            f"{one.title} and {other.title} are less than {SLIVER_M:g} m apart there. Nobody works the strip.",
            other_id=other.id,
            at=site.place(gaps[0].representative_point()),
            fix=Fix(f"Give it to {one.title}", "close_gap", (one.id,), {"to": other.id}),
        )


def _sharing(shapes: NDArray[np.object_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs that share ground, each once; those that only touch are sorted out cheaply."""
    first, second = STRtree(shapes).query(shapes, predicate="intersects")
    first, second = first[first < second], second[first < second]
    shapely.prepare(shapes)
    share = ~shapely.touches(shapes[first], shapes[second])
    return first[share], second[share]


def _gaping(shapes: NDArray[np.object_]) -> Iterator[tuple[int, int]]:
    """Yield pairs with a corner of one near the other and not on it: a strip is widest at a corner."""
    if len(shapes) < 2:
        return
    corners, of = shapely.get_coordinates(shapes, return_index=True)
    order = np.lexsort(corners.T)  # a corner that parcels share is looked at once
    corners, of = corners[order], of[order]
    starts = np.flatnonzero(np.append(True, (np.diff(corners, axis=0) != 0).any(axis=1)))
    points = shapely.points(corners[starts])
    at, to = STRtree(shapes).query(points, predicate="dwithin", distance=SLIVER_M)
    is_off = ~shapely.dwithin(shapes[to], points[at], TOUCH_M)
    stops = np.append(starts[1:], len(of))
    found = {
        (min(int(owner), int(b)), max(int(owner), int(b)))
        for a, b in zip(at[is_off], to[is_off], strict=True)
        for owner in of[starts[a] : stops[a]]
    }
    yield from sorted(found)

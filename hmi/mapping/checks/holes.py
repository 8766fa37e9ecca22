"""Holes: inside their outline, and clear of each other."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from shapely.geometry import Polygon
from shapely.ops import nearest_points

from hmi.mapping.checks.finding import BLOCKS, LOOK, Finding, Fix
from hmi.mapping.checks.site import Site
from hmi.mapping.operations.hole import APART_M


def holes(site: Site) -> Iterator[Finding]:
    """Find holes that leave or touch the outline, or touch or overlap another hole."""
    for n in sorted({path.feature for path in site.paths if path.is_closed and path.number}):
        rings = [site.corners_m[path.start : path.stop] for path in site.paths if path.feature == n]
        outline, *inner = map(Polygon, rings)
        numbered = [(number, hole) for number, hole in enumerate(inner, 1) if hole.is_valid]
        yield from _outside(site, n, outline, numbered)
        yield from _together(site, n, numbered)


def _outside(site: Site, n: int, outline: Polygon, numbered: list[tuple[int, Polygon]]) -> Iterator[Finding]:
    feature_id = site.features[n].id
    for number, hole in numbered if outline.is_valid else ():
        if outline.covers(hole):
            if outline.exterior.distance(hole) < APART_M:
                yield _touching(site, n, outline, number, hole)
            continue
        is_clear = not outline.intersects(hole)
        fix = (
            Fix("Remove hole", "remove_hole", (feature_id,), {"ring": number})
            if is_clear and site.features[n].kind == "parcel"
            else Fix("Cut at the edge", "untangle", (feature_id,))
        )
        yield Finding(
            "hole_outside",
            BLOCKS,
            feature_id,
            f"Hole {number} is outside." if is_clear else f"Hole {number} reaches across the edge.",
            "Remove it, or draw it inside." if is_clear else "Draw it inside, or cut the edge back at it.",
            at=site.place(hole.representative_point()),
            fix=fix,
        )


def _touching(site: Site, n: int, outline: Polygon, number: int, hole: Polygon) -> Finding:
    return Finding(
        "hole_touches",
        LOOK if site.is_valid[n] else BLOCKS,
        site.features[n].id,
        f"Hole {number} touches the edge.",
        "Draw it clear of the edge, or cut the edge back at it.",
        at=site.place(nearest_points(outline.exterior, hole)[0]),
        fix=Fix("Cut at the edge", "untangle", (site.features[n].id,)),
    )


def _together(site: Site, n: int, numbered: list[tuple[int, Polygon]]) -> Iterator[Finding]:
    feature_id = site.features[n].id
    for (first, a), (second, b) in combinations(numbered, 2):
        if a.intersects(b):
            yield Finding(
                "holes_meet",
                BLOCKS,
                feature_id,
                f"Hole {first} and hole {second} {'touch' if a.touches(b) else 'overlap'}.",
                "Make them one, or draw them apart.",
                at=site.place(nearest_points(a, b)[0]),
                fix=Fix("Make one", "untangle", (feature_id,)),
            )

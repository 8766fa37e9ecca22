"""Parcels of a size no parcel has, or too narrow for the machine."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from hmi.mapping.checks.finding import LOOK, Finding, Fix
from hmi.mapping.checks.site import Site
from hmi.mapping.measures import area_text

LEAST_M2 = 20.0
MOST_M2 = 5_000_000.0  # 500 ha


def areas(site: Site) -> Iterator[Finding]:
    """Find parcels smaller than 20 m² or larger than 500 ha."""
    of = site.of_kind("parcel")
    for n, area in zip(of, shapely.area(site.shapes[of]), strict=True):
        if LEAST_M2 <= area <= MOST_M2:
            continue
        size = "small" if area < LEAST_M2 else "large"
        yield Finding(
            "area",
            LOOK,
            site.features[n].id,
            f"Parcel has {area_text(float(area))}. That is very {size}.",
            "Check its corners, or remove it." if size == "small" else "Check its corners, or draw a farm instead.",
            at=site.place(site.shapes[n].representative_point()),
            fix=Fix("Remove it", "remove", (site.features[n].id,)) if size == "small" else None,
        )


def narrow(site: Site, machine_width_m: float) -> Iterator[Finding]:
    """Find parcels nowhere as wide as the machine: nothing is left half its width from every edge."""
    of = site.of_kind("parcel")
    shapes = site.shapes[of]
    # the largest circle in an area without holes is at least area by length of edge in radius
    sure = (shapely.get_num_interior_rings(shapes) == 0) & (
        shapely.area(shapes) >= machine_width_m / 2 * shapely.length(shapes)
    )
    of = of[~sure]
    inset = shapely.buffer(site.shapes[of], -machine_width_m / 2, join_style="mitre")
    for n in of[shapely.is_empty(inset)]:
        yield Finding(
            "too_narrow",
            LOOK,
            site.features[n].id,
            "Parcel is too narrow for the machine.",
            f"It needs {machine_width_m:.1f} m between the edges, and finds them nowhere.",
            at=site.place(np.asarray(site.shapes[n].representative_point().coords[0])),
        )

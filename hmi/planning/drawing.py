"""A plan as a compact drawing: the path with its times, and which ground is worked once, twice or not at all.

Metres east and north of the plan's datum, rounded to centimetres; seconds from the start.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from hmi.planning.estimate import timeline
from hmi.planning.figures import worked_strips
from hmi.planning.ground import polygons_of
from hmi.planning.job import Job
from hmi.planning.plan import Plan
from hmi.planning.projection import Floats, LocalFrame

SLIVER_M2 = 0.05  # smaller pieces of ground are rounding and cannot be seen
SLIT_M = 0.03  # RTK is no better
SMOOTH_M = 0.05
NEAR_M = 100.0
_GRID_M = 1e-3

Ring = list[list[float]]


def drawing(job: Job, plan: Plan, frame: LocalFrame) -> dict[str, Any]:
    """Return the drawing: ``legs`` in driving order, ``ground`` with its share of the field, ``places`` around.

    A leg is ``kind``, ``row``, ``on``, ``dose``, ``pivot``, ``t`` (from, to) and its points ``xy``, flat;
    ``back`` where it is driven backwards.
    ``frame`` says where on earth the metres are, see ``_frame``.
    """
    field = shapely.difference(job.parcel, shapely.union_all(job.obstacles)) if job.obstacles else job.parcel
    machine = job.machine
    return {
        "frame": _frame(job, frame),
        "legs": _legs(job, plan),
        "ground": _ground(job, plan, field),
        "places": {
            "parcel": [_ring(ring) for ring in (job.parcel.exterior, *job.parcel.interiors)],
            "obstacles": _polygons(shapely.union_all(job.obstacles)) if job.obstacles else [],
            "roads": [] if job.roads is None or machine.flies else _polygons(job.roads),
            "home": None if job.home is None else list(job.home),
            "lines": [np.round(line.points, 2).tolist() for line in job.lines],
            "doses": [{"dose": dose, "rings": _polygons(area)} for area, dose in job.doses.areas],
        },
        "machine": {
            "length_m": machine.length_m,
            "width_m": machine.width_m,
            "base_to_front_m": machine.base_to_front_m,
            "tool_width_m": job.treated_width_m,
        },
    }


def _frame(job: Job, frame: LocalFrame) -> dict[str, Any]:
    """Return a place in the middle of the field and the degrees per metre there.

    True to 0.03 m at 500 m from the middle: ``lon_lat + degrees_per_m @ (xy - xy_m)``.
    """
    x, y = (round(float(v), 2) for v in shapely.get_coordinates(job.parcel.centroid)[0])
    around = np.array([[x, y], [x + NEAR_M, y], [x - NEAR_M, y], [x, y + NEAR_M], [x, y - NEAR_M]])
    middle, east, west, north, south = frame.to_lon_lat(around)
    per_m = np.column_stack([east - west, north - south]) / (2 * NEAR_M)
    return {"xy_m": [x, y], "lon_lat": middle.tolist(), "degrees_per_m": per_m.tolist()}


def _legs(job: Job, plan: Plan) -> list[dict[str, Any]]:
    times = timeline(plan.legs, job.machine)
    return [
        {
            "kind": leg.kind.value,
            "row": leg.row,
            "on": leg.tool_on,
            "dose": leg.dose,
            "pivot": leg.pivot,
            "t": [round(begin, 1), round(end, 1)],
            "xy": np.round(leg.points, 2).ravel().tolist(),
            **({"back": True} if leg.is_backward else {}),
        }
        for leg, (begin, end) in zip(plan.legs, times, strict=True)
    ]


def _ground(job: Job, plan: Plan, field: BaseGeometry) -> dict[str, Any]:
    """Return the ground worked, worked twice, and wanted but not worked."""
    strips = worked_strips(plan.legs, job.treated_width_m)
    worked = shapely.intersection(shapely.union_all(strips, grid_size=_GRID_M), field)
    twice = _wide(shapely.intersection(_twice(strips), field))
    missed = _wide(shapely.difference(job.doses.wanted(field), worked))
    return {name: _polygons(area) for name, area in (("worked", worked), ("twice", twice), ("missed", missed))}


def _twice(strips: list[BaseGeometry]) -> BaseGeometry:
    """Return the ground that two strips or more lie on."""
    all_strips = np.array(strips)
    tree = shapely.STRtree(all_strips)
    a, b = tree.query(all_strips, predicate="intersects")
    pairs = a < b
    common = shapely.intersection(all_strips[a[pairs]], all_strips[b[pairs]])
    return shapely.union_all(common[shapely.area(common) > SLIVER_M2 / 10], grid_size=_GRID_M)


def _wide(area: BaseGeometry) -> BaseGeometry:
    """Leave out slits between neighbouring rows: they are rounding, and a line would make them look like ground."""
    return area.buffer(-SLIT_M / 2, join_style="mitre").buffer(SLIT_M / 2, join_style="mitre")


def _polygons(area: BaseGeometry) -> list[list[Ring]]:
    """Return polygons as rings, thinned to what can be seen."""
    parts = [part for part in polygons_of(area.simplify(SMOOTH_M)) if part.area > SLIVER_M2]
    return [[_ring(ring) for ring in (part.exterior, *part.interiors)] for part in parts]


def _ring(ring: BaseGeometry) -> Ring:
    points: Floats = shapely.get_coordinates(ring)
    rounded: Ring = np.round(points, 2).tolist()
    return rounded

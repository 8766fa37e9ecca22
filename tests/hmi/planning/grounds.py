"""Fields to plan on, and the questions every plan must answer."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import shapely
from hypothesis import strategies as st
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from hmi.demo import farm
from hmi.planning.job import Job
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import GENTLE_RAD, Leg, LegKind, Plan, headings, poses_along, turn_between
from hmi.planning.projection import Floats, LocalFrame

FOLDER = Path(__file__).parent / "fields"


def given_field(name: str) -> Polygon:
    """Return a field of the files in metres, its first corner at the origin."""
    folder = farm.FOLDER if name == "nl-parcel" else FOLDER
    collection = json.loads((folder / f"{name}.geojson").read_text("utf-8"))
    rings = collection["features"][0]["geometry"]["coordinates"]
    lon, lat = rings[0][0]
    frame = LocalFrame(lat, lon)
    return Polygon(frame.to_local(rings[0]), [frame.to_local(ring) for ring in rings[1:]])


def ground_of(job: Job) -> BaseGeometry:
    """Return the field without its obstacles."""
    return job.parcel.difference(shapely.union_all(job.obstacles)) if job.obstacles else job.parcel


def square(side_m: float) -> Polygon:
    """Return a square field with a corner at the origin."""
    return shapely.box(0, 0, side_m, side_m)


@st.composite
def convex_fields(draw: st.DrawFn) -> Polygon:
    """Draw convex fields from a garden to some hectares."""
    size = draw(st.floats(12, 70))
    coordinate = st.floats(-1, 1, allow_subnormal=False)
    corners = draw(st.lists(st.tuples(coordinate, coordinate), min_size=3, max_size=10, unique=True))
    hull = shapely.MultiPoint([(x * size, y * size) for x, y in corners]).convex_hull
    return hull if isinstance(hull, Polygon) and hull.area > 150 else square(size)


@st.composite
def crooked_fields(draw: st.DrawFn) -> Polygon:
    """Draw star-shaped fields, some with a hole."""
    size = draw(st.floats(25, 60))
    count = draw(st.integers(5, 11))
    radii = [draw(st.floats(0.45, 1.0)) * size for _ in range(count)]
    points = [
        (r * math.cos(2 * math.pi * k / count), r * math.sin(2 * math.pi * k / count)) for k, r in enumerate(radii)
    ]
    field = Polygon(points)
    if draw(st.booleans()):
        field = field.difference(shapely.Point(0, 0).buffer(draw(st.floats(0.5, 0.15 * size)), quad_segs=3))
    assert isinstance(field, Polygon)
    return field


def metres_outside(field: BaseGeometry, machine: RobotProfile, plan: Plan, step_m: float = 0.1) -> float:
    """Return how many metres of the path the machine's outline is partly outside."""
    pieces = np.concatenate([_nose_first(leg) for leg in plan.legs])
    far_inside = field.buffer(-1.05 * machine.reach_m)  # there the outline fits at any heading
    shapely.prepare(far_inside)
    shapely.prepare(field)
    near = pieces[~shapely.covers(far_inside, shapely.linestrings(pieces))]
    if not len(near):
        return 0.0
    outlines = machine.outline_polygons(np.concatenate([poses_along(piece, step_m) for piece in near]))
    return float((~shapely.covers(field, outlines)).sum()) * step_m


def _nose_first(leg: Leg) -> Floats:
    """Return the (N, 2, 2) pieces of a leg, each in the direction in which the machine looks."""
    points = leg.points[::-1] if leg.is_backward else leg.points
    return np.stack([points[:-1], points[1:]], axis=1)


def worked_strips(legs: Sequence[Leg], width_m: float) -> list[BaseGeometry]:
    """Return the ground that each leg with the tool in treats, not clipped to the field."""
    lines = [shapely.LineString(leg.points) for leg in legs if leg.tool_on]
    return list(shapely.buffer(lines, width_m / 2, quad_segs=12, cap_style="flat"))


def union_of(strips: Sequence[BaseGeometry]) -> BaseGeometry:
    """Return the union of strips with common edges, on a grid of 0.1 mm: without one, GEOS loses some of them."""
    return shapely.union_all(strips, grid_size=1e-4)


def undeclared_jumps(plan: Plan) -> list[float]:
    """Return every change of heading that is neither gentle nor a declared pivot, radians."""
    inside = [
        abs(math.remainder(float(turn), 2 * math.pi)) for leg in plan.legs for turn in np.diff(headings(leg.points))
    ]
    between = [abs(turn_between(a, b)) for a, b in zip(plan.legs, plan.legs[1:], strict=False) if not b.pivot]
    return [jump for jump in inside + between if jump > GENTLE_RAD + 1e-6]


def pivots_without_room(field: BaseGeometry, machine: RobotProfile, plan: Plan) -> list[tuple[float, float]]:
    """Return where the machine would turn on the spot with its outline leaving the field."""
    circle = machine.reach_m
    return [
        (float(leg.points[0][0]), float(leg.points[0][1]))
        for leg in plan.legs
        if leg.pivot and not field.covers(shapely.Point(leg.points[0]).buffer(circle))
    ]


def widest_gap_m(plan: Plan) -> float:
    """Return the largest distance between the end of a leg and the start of the next."""
    gaps = [math.dist(a.points[-1], b.points[0]) for a, b in zip(plan.legs, plan.legs[1:], strict=False)]
    return max(gaps, default=0.0)


def assert_drivable(job: Job, plan: Plan) -> None:
    """Assert everything that must hold for every plan."""
    field = ground_of(job)
    rows = [leg.row for leg in plan.legs if leg.kind is LegKind.ROW]
    assert metres_outside(field, job.machine, plan) == 0
    assert undeclared_jumps(plan) == []
    assert pivots_without_room(field, job.machine, plan) == []
    assert widest_gap_m(plan) < 1e-6
    assert rows == list(range(1, len(rows) + 1)), "each row once, counted as driven"
    work = (LegKind.ROW, LegKind.HEADLAND)
    assert all(leg.kind in work for leg in plan.legs if leg.tool_on)
    assert all(leg.kind is LegKind.TURN and not leg.tool_on for leg in plan.legs if leg.is_backward)
    loops = [leg for leg in plan.legs if leg.kind in work and not leg.tool_on]
    assert all(leg.kind is LegKind.HEADLAND and leg.is_continued for leg in loops)

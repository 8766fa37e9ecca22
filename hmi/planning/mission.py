"""From a field on the map to a mission a robot can take: projection, plan, wire document, numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from hmi.domain.family import Family
from hmi.domain.ids import is_id
from hmi.domain.mission_document import Document, canonical, mission_sha256
from hmi.domain.mission_plan import Candidate, Geometry, PlannedMission, PlanRefused, PlanWish, Tell, nobody
from hmi.planning.coverage import plan_coverage
from hmi.planning.drawing import drawing
from hmi.planning.flight import flight_notes
from hmi.planning.job import Job
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import Leg, Plan
from hmi.planning.polyline import in_millimetres
from hmi.planning.projection import LocalFrame
from hmi.planning.recorded import CropRow
from hmi.planning.statistics import statistics
from hmi.planning.surroundings import area_of, closed_areas, limits_of, rings_of, way_areas
from hmi.planning.treatment import DoseMap

MAX_SEGMENTS = 20_000  # of the edge contract
MAX_EXTENT_M = 20_000.0  # a plane at the datum is true over this distance; no field is larger
MAX_POINTS_IN = 200_000
MAX_POINTS_OUT = 300_000  # some 23 bytes each: the edge contract takes missions of 8 MB
MAX_OVERLAP = 0.5
MAX_DOSE = 2.0
MAX_LEAD_M = 10.0
YARD_RADIUS_M = 4.0  # ground around home where a robot can turn


def plan_mission(wish: PlanWish, machine: RobotProfile | None = None, tell: Tell = nobody) -> PlannedMission:
    """Plan a mission over a field of the map; blocks for up to seconds.

    Args:
        machine: instead of the one the wish's factsheet describes.
        tell: hears how far it is.

    Raises:
        PlanRefused: the input is unusable or the field cannot be worked like this; says why.
    """
    job = job_of(wish, machine)
    return mission_of(wish, job, plan_coverage(job, tell))


def plan_candidate(wish: PlanWish, tell: Tell = nobody) -> Candidate:
    """Plan a mission to look at: its numbers and a drawing, no document; raises as ``plan_mission``."""
    job = job_of(wish)
    return candidate_of(wish, job, plan_coverage(job, tell))


def mission_of(wish: PlanWish, job: Job, plan: Plan) -> PlannedMission:
    """Return a plan as a mission; raises ``PlanRefused`` if it is too long for a robot."""
    document = canonical(_document(wish, job, plan))
    return PlannedMission(document, mission_sha256(document), statistics(wish, job, plan))


def candidate_of(wish: PlanWish, job: Job, plan: Plan) -> Candidate:
    """Return a plan to look at; raises as ``mission_of``."""
    _check_length(plan)
    return Candidate(statistics(wish, job, plan), drawing(job, plan, _frame(wish)))


def job_of(wish: PlanWish, machine: RobotProfile | None = None) -> Job:
    """Return what is to be planned, in metres on the plane of the wish's datum; raises ``PlanRefused``."""
    _check_names(wish)
    _check_numbers(wish)
    return _job(wish, _frame(wish), machine or machine_of(wish))


def _job(wish: PlanWish, frame: LocalFrame, machine: RobotProfile) -> Job:
    parcel = _polygon(wish.parcel, frame)
    obstacles = closed_areas(wish.surroundings, frame, machine)
    near = [area for area in obstacles if area.intersects(parcel)]
    home = None
    ways = way_areas(wish.surroundings, frame)
    if wish.home is not None:
        x, y = frame.to_local([wish.home])[0]
        home = (round(float(x), 3), round(float(y), 3))
        ways.append(shapely.Point(home).buffer(YARD_RADIUS_M))
    roads = shapely.union_all(ways).difference(shapely.union_all(obstacles)) if ways else None
    return Job(
        parcel=parcel,
        width_m=wish.width_m * (1 - wish.overlap),
        tool_width_m=wish.width_m,
        machine=machine,
        obstacles=tuple(polygon for area in near for polygon in _parts(area)),
        angle_rad=wish.angle_rad,
        headland_passes=_laps(wish, machine),
        home=home,
        roads=roads,
        returns_home=wish.returns_home,
        pattern=wish.pattern,
        corner=wish.corner,
        doses=_doses(wish, frame, machine),
        limits=limits_of(wish.surroundings, frame, machine),
        rows=wish.rows,
        lines=_crop_rows(wish, frame),
        crop_spacing_m=wish.row_spacing_m,
        flight_notes=flight_notes(wish.surroundings, frame, machine, parcel, home),
    )


def _laps(wish: PlanWish, machine: RobotProfile) -> int | None:
    """Return the laps asked for; in the air none is needed to turn where it can stand."""
    needs_none = machine.flies and machine.can_pivot
    return 0 if wish.headland_passes is None and needs_none else wish.headland_passes


def _crop_rows(wish: PlanWish, frame: LocalFrame) -> tuple[CropRow, ...]:
    if sum(len(line.points) for line in wish.row_lines) > MAX_POINTS_IN:
        raise PlanRefused("too_many_points", f"The rows have more than {MAX_POINTS_IN} points.", "rows")
    try:
        found = [CropRow(line.name, frame.to_local(_positions(line.points))) for line in wish.row_lines]
    except (TypeError, ValueError) as error:
        raise PlanRefused("bad_rows", "The rows on the map have points that are not numbers.", "rows") from error
    if any(not (np.abs(row.points) <= MAX_EXTENT_M).all() for row in found):
        raise PlanRefused("bad_rows", "The rows on the map lie far from the robot's site.", "rows")
    return tuple(found)


def _doses(wish: PlanWish, frame: LocalFrame, machine: RobotProfile) -> DoseMap:
    given = wish.treatment
    lead_in = machine.lead_in_m if given.lead_in_m is None else given.lead_in_m
    lead_out = machine.lead_out_m if given.lead_out_m is None else given.lead_out_m
    areas = tuple((area_of(area.geometry, 0.0, frame), area.dose) for area in given.areas)
    return DoseMap(areas, given.rest_dose, lead_in, lead_out)


def is_planter(wish: PlanWish) -> bool:
    """Say whether it is a planter that shall work."""
    return wish.robot is not None and wish.robot.family is Family.PLANTER


def machine_of(wish: PlanWish) -> RobotProfile:
    """Return the machine of a wish with the speed and tool it asks for; raises ``PlanRefused``."""
    usual = RobotProfile() if wish.robot is None else RobotProfile.from_factsheet(wish.robot)
    if is_planter(wish):
        usual = usual.planting(wish.width_m, wish.plant_spacing_m)
    if wish.row_speed_mps is None:
        return usual
    top = usual.transit_speed_mps if wish.robot is None else wish.robot.max_speed_mps
    if not 0 < wish.row_speed_mps <= top:
        text = f"A speed of {wish.row_speed_mps:g} m/s is not possible; this robot drives up to {top:g} m/s."
        raise PlanRefused("bad_speed", text, "row_speed_mps")
    return replace(usual, row_speed_mps=wish.row_speed_mps)


def _document(wish: PlanWish, job: Job, plan: Plan) -> Document:
    _check_length(plan)
    segments = [_segment(leg) for leg in plan.legs]
    is_home_at_end = bool(plan.legs) and plan.legs[-1].kind.value == "exit"
    # left out where nobody entered one: a planter that knows no such field takes the mission too
    planting = {} if wish.plant_spacing_m is None or not is_planter(wish) else {"plant_spacing_m": wish.plant_spacing_m}
    return {
        **planting,
        "robot": wish.robot_id,
        "mission_id": wish.mission_id,
        "revision": wish.revision,
        "name": wish.name,
        "field_name": wish.field_name,
        "datum": {"lat_deg": wish.datum_lat_deg, "lon_deg": wish.datum_lon_deg, "height_m": 0.0},
        "width_m": wish.width_m,
        "area_m2": round(plan.figures.covered_m2, 1),
        "parcel": rings_of(wish.parcel),
        "segments": segments,
        "note": " ".join(plan.notes)[:400],
        "at_end": "return_home" if is_home_at_end else "stay",
        "home": None if job.home is None else list(job.home),
    }


def _segment(leg: Leg) -> Document:
    points = in_millimetres(leg.points)
    keep = np.append(True, np.any(np.diff(points, axis=0) != 0, axis=1))
    kept = points[keep] if keep.sum() > 1 else points[[0, -1]]
    segment = {
        "kind": leg.kind.value,
        "points": kept.tolist(),
        "speed_mps": round(leg.speed_mps, 3),
        "tool_on": leg.tool_on,
        "row": leg.row,
        "pivot": leg.pivot,
    }
    if leg.is_backward:
        segment["backward"] = True
    # left out where it is the usual one: robots that know no doses take such missions too
    return segment if leg.dose == 1.0 else {**segment, "dose": round(leg.dose, 3)}


def _check_length(plan: Plan) -> None:
    if len(plan.legs) > MAX_SEGMENTS:
        text = f"The plan has {len(plan.legs)} pieces; a robot takes {MAX_SEGMENTS}. Choose a larger row distance."
        raise PlanRefused("too_many_rows", text, "width_m")
    points = sum(len(leg.points) for leg in plan.legs)
    if points > MAX_POINTS_OUT:
        text = f"The path has {points} points; a robot takes {MAX_POINTS_OUT}. Choose a larger row distance."
        raise PlanRefused("too_many_points", text, "width_m")


def _frame(wish: PlanWish) -> LocalFrame:
    try:
        return LocalFrame(wish.datum_lat_deg, wish.datum_lon_deg)
    except ValueError as error:
        raise PlanRefused("bad_datum", f"The site's origin is wrong: {error}.", "datum") from error


def _check_names(wish: PlanWish) -> None:
    for name in ("mission_id", "robot_id"):
        if not is_id(getattr(wish, name)):
            raise PlanRefused("bad_id", f"{getattr(wish, name)!r} cannot be a {name}.", name)
    for name in ("name", "field_name"):
        if not 1 <= len(getattr(wish, name)) <= 80:
            raise PlanRefused("bad_name", "A name has 1 to 80 characters.", name)


def _check_numbers(wish: PlanWish) -> None:
    if not 0 <= wish.overlap <= MAX_OVERLAP:
        raise PlanRefused("bad_overlap", f"Choose an overlap of 0 to {MAX_OVERLAP:.0%}.", "overlap")
    spacing = wish.plant_spacing_m
    if spacing is not None and not 0.05 <= spacing <= 100:
        raise PlanRefused("bad_spacing", "Choose a plant spacing of 0.05 to 100 m.", "plant_spacing_m")
    if wish.row_spacing_m is not None and not 0 <= wish.row_spacing_m <= MAX_EXTENT_M:
        raise PlanRefused("bad_rows", "The row distance of the field on the map is not one.", "rows")
    treatment = wish.treatment
    if any(not 0 <= dose <= MAX_DOSE for dose in (treatment.rest_dose, *(area.dose for area in treatment.areas))):
        raise PlanRefused("bad_dose", f"A dose is 0 (off) to {MAX_DOSE:g} times the usual one.", "treatment")
    leads = (treatment.lead_in_m, treatment.lead_out_m)
    if any(lead is not None and not 0 <= lead <= MAX_LEAD_M for lead in leads):
        raise PlanRefused("bad_lead", f"The tool may be on 0 to {MAX_LEAD_M:g} m before and after.", "lead_in_m")


def _polygon(geometry: Geometry, frame: LocalFrame) -> Polygon:
    kind = geometry.get("type")
    coordinates: Any = geometry.get("coordinates")
    if kind == "MultiPolygon" and isinstance(coordinates, Sequence) and len(coordinates) == 1:
        coordinates = coordinates[0]
    elif kind != "Polygon":
        raise PlanRefused("bad_field", f"A field is one polygon, not a {kind}.", "field_id")
    try:
        rings = [frame.to_local(_positions(ring)) for ring in coordinates]
    except (TypeError, ValueError) as error:
        raise PlanRefused("bad_field", "The field has corners that are not numbers.", "field_id") from error
    if not rings or any(len(ring) < 4 for ring in rings):
        raise PlanRefused("bad_field", "The field has too few corners.", "field_id")
    if sum(map(len, rings)) > MAX_POINTS_IN:
        raise PlanRefused("too_many_points", f"The field has more than {MAX_POINTS_IN} corners.", "field_id")
    if not all(np.isfinite(ring).all() for ring in rings):
        raise PlanRefused("bad_field", "The field has corners that are not on earth.", "field_id")
    if max(float(np.abs(ring).max()) for ring in rings) > MAX_EXTENT_M:
        text = f"The field is more than {MAX_EXTENT_M / 1000:.0f} km from the robot's site."
        raise PlanRefused("field_too_far", text, "field_id")
    return Polygon(rings[0], rings[1:])


def _positions(ring: Sequence[Sequence[float]]) -> list[tuple[float, float]]:
    points = [(float(p[0]), float(p[1])) for p in ring]
    if any(not (math.isfinite(lon) and abs(lon) <= 180 and abs(lat) <= 90) for lon, lat in points):
        raise ValueError("not a place on earth")
    return points


def _parts(area: BaseGeometry) -> list[Polygon]:
    return [part for part in shapely.get_parts(area) if isinstance(part, Polygon)]

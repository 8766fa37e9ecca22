"""What is to be planned, and whether it can be: every refusal says what to change."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from hmi.domain.mission_plan import Corner, Pattern, PlanRefused, Rows
from hmi.planning.ground import erode, polygons_of
from hmi.planning.headland import Headland, divide
from hmi.planning.machine import RobotProfile
from hmi.planning.recorded import CropRow
from hmi.planning.speed_limits import UNLIMITED, SpeedLimits
from hmi.planning.treatment import EVERYWHERE, DoseMap

MIN_WIDTH_M, MAX_WIDTH_M = 0.05, 50.0
MAX_POINTS = 200_000  # corners of the field as given
MAX_CORNERS = 5_000  # and after thinning: ways around n corners take n * n looks
THIN_FROM, THIN_M = 500, 0.02  # a recorded edge has a point every few centimetres; the margin is wider than this
MAX_ROWS = 9_000  # the wire contract takes 20,000 segments: a row and a turn each


@dataclass(frozen=True, slots=True)
class Job:
    """What to plan. Geometry in metres on one plane.

    Args:
        parcel: the field with its holes; the machine's outline never leaves it while it works.
        width_m: distance of the rows.
        machine: whose outline and speeds count.
        obstacles: ground inside the field where the machine may not be.
        angle_rad: direction of the rows, 0 east; ``None`` searches the best.
        headland_passes: laps around the field; ``None`` takes as many as turning needs.
        home: where the machine stands; ``None`` begins at the first row.
        roads: ground outside the field it may use to get there.
        returns_home: drive back at the end.
        pattern: order of the rows.
        corner: where the rows begin.
        tool_width_m: the width one pass is to treat; ``None`` is the distance of the rows.
        doses: where the tool works, and how much.
        limits: where it drives slower than it could.
        rows: what the rows run along; ``angle_rad`` counts unless they follow an edge or lines.
        lines: the guide lines or recorded rows to follow.
        crop_spacing_m: distance of the recorded rows; ``None`` measures it.
        flight_notes: what of the map is flown over and around, in words.
    """

    parcel: Polygon
    width_m: float
    machine: RobotProfile
    obstacles: tuple[Polygon, ...] = ()
    angle_rad: float | None = None
    headland_passes: int | None = None
    home: tuple[float, float] | None = None
    roads: BaseGeometry | None = None
    returns_home: bool = False
    pattern: Pattern = Pattern.SHORTEST
    corner: Corner | None = None
    tool_width_m: float | None = None
    doses: DoseMap = EVERYWHERE
    limits: SpeedLimits = UNLIMITED
    rows: Rows | None = None
    lines: tuple[CropRow, ...] = ()
    crop_spacing_m: float | None = None
    flight_notes: tuple[str, ...] = ()

    @property
    def treated_width_m(self) -> float:
        """Width that one pass treats: what it is to, as far as the tool takes it."""
        return min(self.pass_width_m, self.machine.tool_width_m or math.inf)

    @property
    def pass_width_m(self) -> float:
        """Width that one pass is to treat: it takes as many rows of the field as that holds."""
        return self.tool_width_m or self.width_m


def checked_field(job: Job) -> BaseGeometry:
    """Return the ground of a job, obstacles cut out.

    Raises:
        PlanRefused: width, angle, headland, home or field are unusable.
    """
    width, parcel = job.width_m, job.parcel
    if not math.isfinite(width) or width <= 0:
        raise PlanRefused("width_not_positive", f"The row distance is {width}; it must be above 0 m.", "width_m")
    if not MIN_WIDTH_M <= width <= MAX_WIDTH_M:
        text = f"A row distance of {width:g} m makes no sense; use {MIN_WIDTH_M:g} to {MAX_WIDTH_M:g} m."
        raise PlanRefused("width_absurd", text, "width_m")
    if job.angle_rad is not None and not math.isfinite(job.angle_rad):
        raise PlanRefused("bad_angle", "The row direction is not a number.", "angle_rad")
    if job.headland_passes is not None and not 0 <= job.headland_passes <= 50:
        raise PlanRefused("bad_headland", "Choose 0 to 50 headland passes.", "headland_passes")
    if job.home is not None and not all(map(math.isfinite, job.home)):
        raise PlanRefused("bad_home", "The home position is not a number.", "home")
    for polygon in (parcel, *job.obstacles):
        _check_polygon(polygon)
    field = parcel.difference(shapely.union_all(job.obstacles)) if job.obstacles else parcel
    if shapely.get_num_coordinates(field) > THIN_FROM:
        field = field.simplify(THIN_M)
    if shapely.get_num_coordinates(field) > MAX_CORNERS:
        raise PlanRefused("too_many_points", f"The field's edge has more than {MAX_CORNERS} real corners.", "field_id")
    parts = polygons_of(field)
    if not parts:
        raise PlanRefused(
            "field_blocked", " ".join(("Obstacles cover the whole field.", *job.flight_notes)), "field_id"
        )
    return parts[0] if len(parts) == 1 else MultiPolygon(parts)


def _check_polygon(polygon: Polygon) -> None:
    points = shapely.get_coordinates(polygon)
    if len(points) > MAX_POINTS:
        raise PlanRefused(
            "too_many_points", f"The field has {len(points)} corners; {MAX_POINTS} is the most.", "field_id"
        )
    if polygon.is_empty or not np.isfinite(points).all():
        raise PlanRefused("bad_field", "The field has corners that are not numbers.", "field_id")
    if not polygon.is_valid:
        why = shapely.is_valid_reason(polygon)
        raise PlanRefused(
            "bad_field", f"The field's edge crosses itself ({why}). Mend it on the map first.", "field_id"
        )


def _shallower(field: BaseGeometry, division: Headland, job: Job) -> str:
    """Say how a field that is all headland can be worked."""
    if job.headland_passes is None and not job.machine.can_pivot:
        return "This machine needs it to turn: choose another robot, or a smaller working width."
    for passes in range(len(division.offsets_m) - 1, -1, -1):
        if not erode(field, divide(job.machine, job.width_m, passes).depth_m).is_empty:
            return f"Choose {passes} headland pass{'' if passes == 1 else 'es'}."
    return "It is too narrow for this machine to turn in: choose another robot."


def inner_field(field: BaseGeometry, division: Headland, job: Job) -> BaseGeometry:
    """Return the field behind its headland.

    Raises:
        PlanRefused: it is too small, or would take too many rows.
    """
    machine = job.machine
    if erode(field, machine.width_m / 2 + machine.margin_m).is_empty:
        size = f"{machine.length_m:g} x {machine.width_m:g} m"
        raise PlanRefused("field_too_small", f"The machine ({size}) fits nowhere on this field.", "field_id")
    inner = erode(field, division.depth_m)
    if inner.is_empty:
        text = f"Nothing is left of the field behind a headland of {division.depth_m:.1f} m. "
        raise PlanRefused("field_too_small", text + _shallower(field, division, job), "headland_passes")
    least = math.sqrt(inner.minimum_rotated_rectangle.area) / job.width_m if inner.area > 0 else 0
    if least > MAX_ROWS:
        raise PlanRefused(
            "too_many_rows", f"That makes more than {MAX_ROWS} rows. Choose a larger row distance.", "width_m"
        )
    return inner

"""The rows of a job: straight ones side by side, parallels of a guide line, or the rows that were recorded."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from hmi.domain.mission_plan import PlanRefused, Rows
from hmi.planning import swaths
from hmi.planning.curved_rows import lay_along
from hmi.planning.guide import Parallels, parallels
from hmi.planning.job import Job
from hmi.planning.projection import Floats
from hmi.planning.recorded import CropRow, passes
from hmi.planning.swaths import Swath

_SLIT_M = 1.0  # nobody drives through what is narrower than twice this
_EDGE_M = 0.2
FOLLOWING = (Rows.GUIDE_LINE, Rows.RECORDED_ROWS)


@dataclass(frozen=True, slots=True, eq=False)
class Laid:
    """Rows in cells of neighbours, their (mean) direction, and sentences for the planner to read."""

    cells: list[list[Swath]]
    angle_rad: float
    notes: tuple[str, ...] = ()


def laid(job: Job, inner: BaseGeometry, room: BaseGeometry) -> Laid:
    """Return the rows of a job.

    Args:
        job: what is to be planned.
        inner: area that the rows must cover.
        room: where row ends may reach; contains ``inner``.

    Raises:
        PlanRefused: its lines cannot be followed, or no row fits.
    """
    found = _along_lines(job, inner, room) if job.rows in FOLLOWING else _straight(job, inner, room)
    if any(found.cells):
        return found
    if job.rows in FOLLOWING:
        text = "None of the lines lies over the field behind its headland. Choose another row direction."
        raise PlanRefused("no_rows", text, "rows")
    raise PlanRefused("field_too_small", "No row fits into this field. Choose a smaller width.", "width_m")


def crop_of(rows: list[list[Swath]], width_m: float) -> BaseGeometry:
    """Return the ground that rows stand on, as one area with plain edges: ways around it bend at its corners."""
    strips = swaths.strips([row for cell in rows for row in cell], 1.02 * width_m)
    area = shapely.union_all(strips, grid_size=1e-3)
    return area.buffer(_SLIT_M, join_style="mitre").buffer(-_SLIT_M, join_style="mitre").simplify(_EDGE_M)


def _straight(job: Job, inner: BaseGeometry, room: BaseGeometry) -> Laid:
    angle = job.angle_rad
    if job.rows is Rows.ALONG_EDGE:
        angle = swaths.edge_angle(job.parcel)
    if angle is None:
        angle = swaths.best_angle(inner, job.width_m)
    return Laid(swaths.lay_rows(inner, room, angle, job.width_m), angle)


def _along_lines(job: Job, inner: BaseGeometry, room: BaseGeometry) -> Laid:
    lines = [line for line in job.lines if len(line.points) > 1 and np.isfinite(line.points).all()]
    if not lines:
        what = "guide line" if job.rows is Rows.GUIDE_LINE else "recorded rows"
        raise PlanRefused("no_lines", f"The field has no {what} any more. Choose another row direction.", "rows")
    if job.rows is Rows.GUIDE_LINE:
        found, width = _beside_the_guide(job, lines, inner), job.width_m
    else:
        radius, width = job.machine.turning_radius_m, job.pass_width_m
        found = passes(lines, inner, width, radius, job.crop_spacing_m)
    cells = lay_along(found.lines, found.along, inner, room, width)
    return Laid(cells, _mean_angle([line.points for line in lines]), found.notes)


def _beside_the_guide(job: Job, lines: list[CropRow], inner: BaseGeometry) -> Parallels:
    guide = max(lines, key=lambda line: LineString(line.points).length)
    found = parallels(guide.points, inner, job.width_m, job.machine.turning_radius_m)
    if len(lines) == 1:
        return found
    note = f"The field has {len(lines)} guide lines; the rows follow the longest, {guide.name}."
    return Parallels(found.lines, found.along, (note, *found.notes))


def _mean_angle(lines: list[Floats]) -> float:
    """Return the mean direction of lines without a beginning: doubled angles of opposite directions are the same."""
    steps = np.concatenate([np.diff(points, axis=0) for points in lines])
    doubled = (np.hypot(*steps.T) * np.exp(2j * np.arctan2(steps[:, 1], steps[:, 0]))).sum()
    return float(np.angle(doubled)) / 2 % math.pi

"""The numbers of a path over a field, whoever planned it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import shapely
from shapely.geometry.base import BaseGeometry

from hmi.domain.mission_plan import Rows
from hmi.planning.estimate import effort
from hmi.planning.job import Job
from hmi.planning.plan import Figures, Leg

GRID_M = 1e-4  # without a grid, a union of many strips with common edges loses some of them
WIDTH_M = 0.005
TOLD_MISSED = 0.04  # a share of the field; sharp corners of small fields cost that much


def figures_of(
    job: Job,
    field: BaseGeometry,
    inner: BaseGeometry,
    legs: Sequence[Leg],
    strips: Sequence[BaseGeometry],
    *,
    rows: int,
    angle: float,
    passes: int,
) -> Figures:
    """Add a path up.

    Args:
        field: the ground of the job, obstacles cut out; ``inner`` what of it lies behind the headland.
        strips: the ground that the rows and laps work, see ``worked_strips``.
        angle: of the rows, radians.
        passes: headland laps.
    """
    work = effort(legs, job.machine)
    worked = shapely.union_all(strips, grid_size=GRID_M)
    covered = shapely.intersection(worked, field)
    wanted = job.doses.wanted(field)
    treated = covered if job.doses.is_plain else covered.intersection(wanted)
    return Figures(
        length_m=work.length_m,
        working_length_m=work.working_length_m,
        duration_s=work.duration_s,
        working_s=work.working_s,
        rows=rows,
        turns=work.turns,
        pivots=work.pivots,
        area_m2=float(field.area),
        covered_m2=float(covered.area),
        overlap_m2=max(0.0, float(shapely.area(strips).sum() - worked.area)),
        inner_m2=float(inner.area),
        inner_covered_m2=float(covered.intersection(inner).area),
        energy_j=work.energy_j,
        battery_share=work.energy_j / job.machine.battery_j,
        angle_rad=angle % math.pi,
        headland_passes=passes,
        wanted_m2=float(wanted.area),
        missed_m2=max(0.0, float(wanted.area - treated.area)),
        reversals=work.reversals,
    )


def missed_note(job: Job, figures: Figures) -> str:
    """Say how much stays untreated, empty where it is little."""
    missed = figures.missed_m2 / figures.wanted_m2
    if missed <= TOLD_MISSED:
        return ""
    ground = "field" if job.doses.is_plain else "ground to be treated"
    if job.treated_width_m < job.width_m - WIDTH_M:
        tool, rows = f"The tool takes {job.treated_width_m:.3g} m", f"rows are {job.width_m:.3g} m apart"
        return f"{tool}; {rows}: {missed:.0%} of the {ground} stays untreated."
    why = ", mostly where the robot cannot turn"
    if job.rows is Rows.RECORDED_ROWS:
        why = ": no recorded row runs there, or the robot cannot turn there"
    return f"{missed:.0%} of the {ground} stays untreated{why}."


def worked_strips(legs: Sequence[Leg], width_m: float) -> list[BaseGeometry]:
    """Return the ground that each leg with the tool on works, not clipped to the field."""
    lines = [shapely.LineString(leg.points) for leg in legs if leg.tool_on]
    return list(shapely.buffer(lines, width_m / 2, quad_segs=12, cap_style="flat"))

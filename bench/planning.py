"""Planning: what a plan of a whole field is worth and costs, beside Fields2Cover's published figures.

Prints one figure a field and row distance; its value is the CPU time of the plan. ``python -m bench.planning`` prints
a table. Whatever is said of a plan is measured on its path, not taken from the planner's own figures.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from hmi.planning.coverage import plan_coverage
from hmi.planning.ground import erode
from hmi.planning.headland import divide
from hmi.planning.job import Job
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import Leg, Plan
from tests.hmi.planning.grounds import (
    given_field,
    metres_outside,
    pivots_without_room,
    square,
    undeclared_jumps,
    union_of,
    worked_strips,
)

SOURCE = (
    "Fields2Cover 2.1.0, one core: best angle in 1 degree steps, or-tools route, Dubins turns, headland of two row "
    "distances (3 m at 0.5 m), turning radius 1.5 m at 3 m and 1.0 m at 0.5 m"
)
RADIUS_M = {3.0: 1.5, 0.5: 1.0}  # turning radius for a row distance, as in the source


@dataclass(frozen=True, slots=True)
class Published:
    """What Fields2Cover makes of a field; ``None`` where it did not finish within 15 minutes and 2 GB."""

    rows: int
    cpu_s: float | None
    path_m: float | None
    working_m: float | None
    inner_pct: float | None
    whole_pct: float | None
    outside_m: float | None
    outside_smooth_m: float | None
    jumps: int | None


PUBLISHED = {
    ("square", 3.0): Published(3, 0.013, 33, 24, 100, 18, 0, 0, 0),
    ("square", 0.5): Published(28, 0.094, 574, 392, 100, 49, 0, 220, 0),
    ("lshape", 3.0): Published(46, 0.225, 3_955, 3_648, 100, 76, 0, 0, 0),
    ("lshape", 0.5): Published(288, 8.309, 27_287, 25_272, 100, 87.8, 0, 2_312, 2),
    ("nc12", 3.0): Published(89, 0.911, 12_619, 11_700, 99.3, 85.0, 0, 255, 6),
    ("nc12", 0.5): Published(549, 33.634, 79_961, 76_221, 99.9, 92.3, 0, 3_283, 188),
    ("nl-parcel", 3.0): Published(132, 2.012, 54_959, 54_158, 99.8, 94.2, 0, 587, 2),
    ("nl-parcel", 0.5): Published(802, 72.09, 340_521, 334_747, 99.96, 97.0, 0, 6_082, 11),
    ("field100", 3.0): Published(478, 22.085, 328_230, 323_096, 99.9, 96.9, 34, 893, 39),
    ("field100", 0.5): Published(2_727, None, None, None, None, None, None, None, None),
}
"""By field and row distance; ``outside_smooth_m`` and not ``outside_m`` with continuous-curvature turns."""


def figure_name(field: str, width_m: float) -> str:
    """Return what a figure is called."""
    return f"plan_{field.replace('-', '_')}_{width_m:g}m_s".replace(".", "")


def run(wanted: str | None = None) -> Iterator[dict[str, Any]]:
    """Yield the figures, or the one called ``wanted``."""
    for field, width_m in PUBLISHED:
        if wanted in (None, figure_name(field, width_m)):
            yield measure(field, width_m)


def measure(name: str, width_m: float) -> dict[str, Any]:
    """Return the figure for one field and row distance."""
    field = square(20) if name == "square" else given_field(name)
    job = Job(field, width_m, RobotProfile(turning_radius_m=RADIUS_M[width_m]))
    started_s = time.process_time()
    plan = plan_coverage(job)
    cpu_s = time.process_time() - started_s
    published = PUBLISHED[name, width_m]
    return {
        "name": figure_name(name, width_m),
        "value": round(cpu_s, 2),
        "unit": "s",
        **_drawn(job, plan),
        "path_at_equal_coverage_m": _path_for(published, job, plan),
        "notes": list(plan.notes),
        "fields2cover": {**asdict(published), "source": SOURCE},
        "conditions": (
            f"{field.area / 1e4:.2f} ha, rows {width_m:g} m apart; machine {job.machine.length_m:g} x "
            f"{job.machine.width_m:g} m, turning radius {job.machine.turning_radius_m:g} m or on the spot, declared; "
            "CPU time of the plan without its document"
        ),
    }


def _drawn(job: Job, plan: Plan) -> dict[str, Any]:
    """Return what can be read off the path."""
    field, width_m = job.parcel, job.width_m
    strips = worked_strips(plan.legs, width_m)
    worked = union_of(strips)
    covered = shapely.intersection(worked, field)
    inner = erode(field, divide(job.machine, width_m, job.headland_passes).depth_m)
    return {
        "rows": sum(leg.row > 0 for leg in plan.legs),
        "path_m": round(sum(leg.length_m for leg in plan.legs)),
        "working_m": round(sum(leg.length_m for leg in plan.legs if leg.tool_on)),
        "inner_pct": _pct(covered, inner),
        "whole_pct": _pct(covered, field),
        "reach_pct": _pct(covered, reachable(field, job.machine, width_m)),
        "overlap_pct": round(100 * (float(shapely.area(strips).sum()) - worked.area) / field.area, 2),
        "outside_m": round(metres_outside(field, job.machine, plan), 1),
        "pivots_outside": len(pivots_without_room(field, job.machine, plan)),
        "jumps": len(undeclared_jumps(plan)),
        "pivots": sum(leg.pivot for leg in plan.legs),
        "duration_h": round(plan.figures.duration_s / 3600, 2),
    }


def reachable(field: Polygon, machine: RobotProfile, width_m: float) -> BaseGeometry:
    """Return the ground that a tool can treat: half a width around wherever the machine can drive or turn.

    It drives along a border no nearer than its outline and its tool allow, and rounds corners with its turning radius.
    """
    radius = machine.turning_radius_m
    driven = field.buffer(-(max(machine.border_m, width_m / 2) + radius)).buffer(radius)
    if machine.can_pivot:
        driven = driven.union(erode(field, machine.reach_m + machine.margin_m))
    return driven.buffer(width_m / 2).intersection(field)


def _path_for(published: Published, job: Job, plan: Plan) -> int | None:
    """Return the metres driven until as much is worked as Fields2Cover works in all."""
    if published.whole_pct is None:
        return None
    wanted_m2 = published.whole_pct / 100 * job.parcel.area
    legs, low, high = plan.legs, 0, len(plan.legs)
    while low < high:  # the least number of legs that work enough
        middle = (low + high) // 2
        low, high = (low, middle) if _worked_m2(legs[:middle], job) >= wanted_m2 else (middle + 1, high)
    if low == len(legs) and _worked_m2(legs, job) < wanted_m2:
        return None
    before_m2, after_m2 = _worked_m2(legs[: low - 1], job), _worked_m2(legs[:low], job)
    share = (wanted_m2 - before_m2) / (after_m2 - before_m2)
    length_m: float = sum(leg.length_m for leg in legs[: low - 1]) + share * legs[low - 1].length_m
    return round(length_m)


def _worked_m2(legs: Sequence[Leg], job: Job) -> float:
    return float(shapely.intersection(union_of(worked_strips(legs, job.width_m)), job.parcel).area)


def _pct(covered: BaseGeometry, area: BaseGeometry) -> float:
    return round(100 * float(shapely.area(shapely.intersection(covered, area))) / float(area.area), 2)


_COLUMNS = (
    ("rows", "rows"),
    ("path_m", "path m"),
    ("working_m", "working m"),
    ("path_at_equal_coverage_m", "path m, equal"),
    ("inner_pct", "inner %"),
    ("whole_pct", "whole %"),
    ("reach_pct", "reach %"),
    ("overlap_pct", "overlap %"),
    ("outside_m", "outside m"),
    ("pivots_outside", "pivots outside"),
    ("jumps", "jumps"),
    ("pivots", "pivots"),
    ("value", "CPU s"),
)
_THEIRS = {"value": "cpu_s"}


def table(figures: Iterator[dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of a table: of each field our figures, below them the published ones."""
    yield "  ".join(["figure".ljust(26), *(title.rjust(14) for _, title in _COLUMNS)])
    for figure in figures:
        theirs = figure["fields2cover"]
        yield _line(figure["name"], [figure[key] for key, _ in _COLUMNS])
        yield _line("  Fields2Cover", [theirs.get(_THEIRS.get(key, key)) for key, _ in _COLUMNS])
        for note in figure["notes"]:
            yield f"  note: {note}"


def _line(name: str, values: list[Any]) -> str:
    return "  ".join([name.ljust(26), *(("-" if v is None else f"{v:,}").rjust(14) for v in values)])


def main(arguments: list[str]) -> int:
    """Print the table, or with ``--json`` the figures as JSON lines; a name picks one."""
    wanted = next((a for a in arguments if not a.startswith("-")), None)
    figures = run(wanted)
    for line in map(json.dumps, figures) if "--json" in arguments else table(figures):
        print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

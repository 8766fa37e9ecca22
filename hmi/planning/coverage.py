"""Cover a field: rows over the inner field, laps around it, ways in between, home and back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import shapely
from shapely.geometry.base import BaseGeometry

from hmi.domain.mission_plan import Pattern, PlanRefused, Rows, Tell, nobody
from hmi.planning import headland as headlands
from hmi.planning import rows as rows_of
from hmi.planning.corners import Corners
from hmi.planning.dubins import Pose
from hmi.planning.figures import figures_of, missed_note, worked_strips
from hmi.planning.ground import Ground, erode
from hmi.planning.headland import Headland, Lap
from hmi.planning.job import Job, checked_field, inner_field
from hmi.planning.lanes import Lanes
from hmi.planning.links import Linker
from hmi.planning.machine import RobotProfile
from hmi.planning.patterns import driving_order, span_for
from hmi.planning.plan import GENTLE_RAD, Figures, Leg, LegKind, Plan, headings, turn_between
from hmi.planning.projection import Floats
from hmi.planning.swaths import Swath, strips
from hmi.planning.tour import by_part
from hmi.planning.turns import Turns, way_speed

_GAP_M = 0.04
_MORE_PASSES = "Choose more headland passes."
_NO_WAY_OUT = (
    "No known way leads from home to this field. Draw the road under Maps, choose another home, "
    "or let the robot start at the field: you drive it there."
)
_WIDEN = (
    "Draw it as wide as it is under Maps, choose another home, or let the robot start at the field: you drive it there."
)
_A_WAY_M = 0.2  # narrower is a seam between two areas, no way
_NO_FLIGHT_OUT = (
    "Home is more than 3 km away, or a keep-out zone or something that stands lies around home, this field or between. "
    "Choose another home, or let the robot start at the field."
)
_DEEPER_RADII = (0.0, 1.0, 2.0)  # a border that slants more than usual needs a deeper headland to turn in


def plan_coverage(job: Job, tell: Tell = nobody) -> Plan:
    """Return a path that treats the whole field once.

    Args:
        tell: hears how far it is.

    Raises:
        PlanRefused: the input is unusable, the field cannot be worked like this, or no way leads there from home;
            says why.
    """
    field = checked_field(job)
    is_wide = job.pattern is Pattern.SKIP_ROWS
    division = headlands.divide(job.machine, job.width_m, job.headland_passes, is_wide=is_wide)
    if job.headland_passes is not None or job.machine.can_pivot:
        return _cover(job, field, division, tell)
    refusals: list[PlanRefused] = []
    for radii in _DEEPER_RADII:
        deeper_by = math.ceil(radii * job.machine.turning_radius_m / job.width_m)
        try:
            return _cover(job, field, headlands.deepened(division, job.width_m, deeper_by), tell)
        except PlanRefused as refusal:
            refusals.append(refusal)
            if refusal.code != "turn_does_not_fit":
                break
    # as it was before the headland took ground for nothing; a home without a way stays one
    said = refusals[-1] if refusals[-1].code == "home_unreachable" else refusals[0]
    if said.code != "turn_does_not_fit":
        raise said
    text = said.text.replace(_MORE_PASSES, "Choose a larger working width, another row direction or row order.")
    raise PlanRefused(said.code, text, "width_m")


def _cover(job: Job, field: BaseGeometry, division: Headland, tell: Tell) -> Plan:
    tell(0.02, "Laying rows")
    inner = inner_field(field, division, job)
    is_crop_met = not job.machine.flies
    crop = erode(inner, min(job.width_m, 1.0) * 0.6) if is_crop_met else None
    ground = Ground(field, job.machine, crop=crop)
    rows = rows_of.laid(job, inner, ground.turning)
    cells = [[row for row in cell if job.doses.is_wanted_along(row.points)] for cell in rows.cells]
    if not any(cells):
        raise PlanRefused("nothing_to_treat", "No row crosses ground to be treated. Change the treatment.", "treatment")
    if job.rows is Rows.RECORDED_ROWS and is_crop_met:  # they may end anywhere: what lies beyond is free
        standing = rows_of.crop_of(rows.cells, job.pass_width_m)
        ground = Ground(field, job.machine, crop=erode(standing, min(job.width_m, 1.0) * 0.6))
    return _Course(job, ground, division, cells, field, inner, tell, rows.notes).run(rows.angle_rad)


class _Course:
    """Drives through the field once, collecting legs and what had to be left out."""

    def __init__(
        self,
        job: Job,
        ground: Ground,
        division: Headland,
        cells: list[list[Swath]],
        field: BaseGeometry,
        inner: BaseGeometry,
        tell: Tell,
        notes: Sequence[str] = (),
    ) -> None:
        self.tell = tell
        self.job, self.ground, self.division = job, ground, division
        self.field, self.inner = field, inner
        self.wanted = job.doses.wanted(field)
        self.linker = Linker(ground)
        self.turns = Turns(self.linker)
        self.cells = cells
        self.legs: list[Leg] = []
        self.notes: list[str] = list(notes)
        self.row = 0
        self.waiting = [lap for lap in headlands.laps(ground, division) if job.doses.is_wanted_along(lap.points)]
        self.corners = Corners(
            self.linker,
            self.waiting,
            inner,
            self.wanted,
            job.width_m,
            may_pivot=job.pattern is not Pattern.SKIP_ROWS,  # chosen for arcs in place of turns on the spot
        )
        self.done: list[Swath] = []

    def run(self, angle: float) -> Plan:
        """Make the plan."""
        self.tell(0.1, "Ordering rows")
        self._rows()
        self.tell(0.8, "Headland")
        self._headland()
        if self.job.home is not None:
            self._home()
        self.tell(0.9, "Adding up")
        legs = self.job.doses.cut(_with_pivots(self.legs, self.job.machine))
        worked = self._strips(legs)
        legs = self.job.limits.cut(legs)
        figures = self._figures(legs, worked, angle)
        self.notes += filter(None, (missed_note(self.job, figures), *self.job.flight_notes))
        return Plan(tuple(legs), figures, tuple(self.notes))

    # rows

    def _rows(self) -> None:
        groups = by_part([cell for cell in self.cells if cell], self.ground.turning)
        if self.job.home is not None:
            groups = self._from_home(groups, shapely.Point(self.job.home))
        job, span = self.job, span_for(self.job.machine, self.job.width_m)
        driven = [
            row
            for group in groups
            for cell in driving_order(job.pattern, group, self.inner, home=job.home, corner=job.corner, span=span)
            for row in cell
        ]
        around = headlands.after_rows(
            [lap for lap in self.waiting if lap.is_inner], driven, self.division, self.job.width_m
        )
        for number, swath in enumerate(driven):
            self.tell(0.1 + 0.7 * number / len(driven), f"Row {number + 1} of {len(driven)}")
            self._row(swath)
            self._laps(around.get(number, []))
        if self.row == 0:
            raise PlanRefused("no_way", "No row of this field can be reached.", "field_id")
        left_out = sum(len(cell) for cell in self.cells) - self.row
        if left_out and not self.job.machine.can_pivot:
            text = f"The robot's turning circle does not fit at {left_out} row ends. {_MORE_PASSES}"
            raise PlanRefused("turn_does_not_fit", text, "headland_passes")
        if left_out:
            self.notes.append(f"{left_out} rows cannot be reached from the others and are left out.")

    def _row(self, swath: Swath) -> None:
        """Drive to a row and along it; a row that cannot be reached is left out."""
        points = swath.points
        heading = float(headings(points)[0])
        if not self._go((*swath.a, heading), self.job.machine.turn_speed_mps):
            return
        self.row += 1
        self.done.append(swath)
        self.legs.append(Leg(LegKind.ROW, points, self.job.machine.row_speed_mps, tool_on=True, row=self.row))

    # headland

    def _headland(self) -> None:
        self._laps(list(self.waiting))
        if self.waiting:
            self.notes.append(f"{len(self.waiting)} headland laps cannot be reached and are left out.")

    def _laps(self, wanted: list[Lap]) -> None:
        """Drive laps, the nearest first; those that cannot be reached from here stay waiting."""
        while wanted and self.legs:
            here = shapely.Point(self._pose()[:2])
            lap = min(wanted, key=lambda lap: shapely.distance(shapely.LineString(lap.points), here))
            wanted = [other for other in wanted if other is not lap]
            if self._lap(lap):
                self.waiting = [other for other in self.waiting if other is not lap]

    def _lap(self, lap: Lap) -> bool:
        here = self._pose()
        # nearest first, but a start that needs no turning back beats one a machine's length nearer
        for points in sorted(headlands.beginnings(lap), key=lambda p: headlands.entry_cost(here, p)):
            pose = (float(points[0][0]), float(points[0][1]), float(headings(points)[0]))
            if self.linker.can_leave(pose) and self._go(pose, self.job.machine.turn_speed_mps):
                self.legs += self._around(lap, points)
                return True
        return False

    def _around(self, lap: Lap, points: Floats) -> list[Leg]:
        machine = self.job.machine
        return [
            Leg(
                LegKind.HEADLAND,
                stretch.points,
                machine.row_speed_mps if stretch.is_worked else machine.turn_speed_mps,
                tool_on=stretch.is_worked,
                is_continued=number > 0,
            )
            for number, stretch in enumerate(self.corners.stretches(lap, points))
        ]

    # ways

    def _pose(self) -> Pose:
        last = self.legs[-1]
        return float(last.points[-1][0]), float(last.points[-1][1]), last.last_heading_rad

    def _go(self, goal: Pose, speed_mps: float) -> bool:
        if not self.legs:
            return True
        legs = self.turns.between(self._pose(), goal, speed_mps)
        if legs is None:
            return False
        self.legs += legs
        return True

    def _with_roads(self) -> BaseGeometry:
        """Return the ground of the field and of the ways to it."""
        if self.job.roads is None:
            return self.ground.allowed
        together = shapely.union_all([self.ground.allowed, self.job.roads])
        # neighbouring features drawn by hand leave hairline gaps; closing them costs less than the margin
        return together.buffer(_GAP_M, join_style="mitre").buffer(-_GAP_M, join_style="mitre")

    def _from_home(self, groups: list[list[list[Swath]]], home: shapely.Point) -> list[list[list[Swath]]]:
        """Return the parts of the field with those first that are not cut off from home; narrow ways show later.

        Raises:
            PlanRefused: all of them are; said before seconds go into the rows.
        """
        around = shapely.union_all([one for one in shapely.get_parts(self._with_roads()) if one.intersects(home)])
        is_cut_off = [not around.intersects(shapely.LineString(group[0][0].points)) for group in groups]
        if all(is_cut_off):
            raise _cut_off(self.job)
        return [group for _, group in sorted(zip(is_cut_off, groups, strict=True), key=lambda one: one[0])]

    def _home(self) -> None:
        """Put the way from home before the path, and the way back after it if it is wanted."""
        assert self.job.home is not None
        machine = self.job.machine
        linker = Linker(Ground(self._with_roads(), machine, self.ground.crop))
        first = self.legs[0]
        start: Pose = (float(first.points[0][0]), float(first.points[0][1]), first.first_heading_rad)
        lanes = Lanes(linker)
        away = linker.link(_standing(self.job.home, start), start)
        if away is None:
            away = lanes.from_place(self.job.home, start)
        if away is None:
            raise self._no_way_out(lanes, start[:2])
        self.legs = [Leg(LegKind.APPROACH, p, way_speed(p, machine, machine.way_mps)) for p in away] + self.legs
        if not self.job.returns_home:
            return
        here = self._pose()
        back = linker.link(here, _standing(self.job.home, here))
        if back is None:
            back = lanes.to_place(here, self.job.home)
        if back is None:
            self.notes.append("No known way leads back home. The robot stays at the end.")
            return
        self.legs += [Leg(LegKind.EXIT, p, way_speed(p, machine, machine.way_mps)) for p in back]

    def _no_way_out(self, lanes: Lanes, entry: tuple[float, float]) -> PlanRefused:
        """Say what is wrong with the way from home: there is none, it is too narrow, or a bend is too tight."""
        machine, home = self.job.machine, self.job.home
        width_m = 0.0 if machine.flies or home is None else lanes.width_m(home, entry)
        if width_m < _A_WAY_M:
            return _cut_off(self.job)
        if width_m < lanes.needed_m:
            why = f"is {width_m:.1f} m wide where it is narrowest, and this machine needs {lanes.needed_m:.1f} m. "
        else:
            radius_m = machine.turning_radius_m
            why = f"has a bend or a corner too tight for this machine, which turns on a radius of {radius_m:.1f} m. "
        return PlanRefused("home_unreachable", f"The way from home to this field {why}{_WIDEN}", "home_id")

    def _figures(self, legs: list[Leg], worked: list[BaseGeometry], angle: float) -> Figures:
        passes = len(self.division.offsets_m)
        return figures_of(self.job, self.field, self.inner, legs, worked, rows=self.row, angle=angle, passes=passes)

    def _strips(self, legs: list[Leg]) -> list[BaseGeometry]:
        """Return the ground that each row, lap or treated piece of them works."""
        width = self.job.treated_width_m
        if self.job.doses.is_plain:
            around = [leg for leg in legs if leg.kind is LegKind.HEADLAND]
            return [*strips(self.done, width), *worked_strips(around, width)]
        return worked_strips(legs, width)


def _cut_off(job: Job) -> PlanRefused:
    text = " ".join((_NO_FLIGHT_OUT, *job.flight_notes)) if job.machine.flies else _NO_WAY_OUT
    return PlanRefused("home_unreachable", text, "home_id")


def _standing(home: tuple[float, float], other: Pose) -> Pose:
    """Return the pose at home; its heading is free, so it looks at the other place (or away from it)."""
    return home[0], home[1], math.atan2(other[1] - home[1], other[0] - home[0])


def _with_pivots(legs: Sequence[Leg], machine: RobotProfile) -> list[Leg]:
    """Declare every corner between legs; refuse corners for a machine that cannot turn on the spot."""
    result = list(legs[:1])
    for before, leg in pairwise(legs):
        angle = abs(turn_between(before, leg))
        if angle > GENTLE_RAD and not machine.can_pivot:
            raise PlanRefused("turn_does_not_fit", _no_turn(before, leg), "headland_passes")
        result.append(replace(leg, pivot=angle > GENTLE_RAD))
    return result


def _no_turn(before: Leg, after: Leg) -> str:
    where = f"after row {before.row}" if before.row else f"before row {after.row}" if after.row else "on the headland"
    return f"The robot's turning circle does not fit {where}. {_MORE_PASSES}"

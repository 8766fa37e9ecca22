"""The ground on which the rest of a mission is driven: the field as the map shows it now, and the roads to it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from hmi.domain.mission_document import Document
from hmi.domain.mission_plan import PlanRefused
from hmi.domain.mission_rest import LEAVE_OUT, OBSTACLE, DrawnArea, RestWish
from hmi.planning.dubins import Pose
from hmi.planning.ground import CHECK_STEP_M, Ground, erode, polygons_of
from hmi.planning.headland import Headland
from hmi.planning.lanes import Lanes
from hmi.planning.links import Linker
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import Leg, LegKind, poses_along
from hmi.planning.projection import Floats, LocalFrame
from hmi.planning.rest_laps import LEAST_LAP_M, RestLaps, has_moved, headland_of, worked_by
from hmi.planning.spans import between
from hmi.planning.surroundings import area_of, closed_areas, limits_of, rings_of, way_areas
from hmi.planning.treatment import DoseMap
from hmi.planning.turns import Turns, way_speed

YARD_RADIUS_M = 4.0  # ground around home where a robot can turn
GAP_M = 0.04  # neighbouring features drawn by hand leave hairline gaps
LEAST_PART_M = 1.0  # shorter remains of a row are not worth a turn
LEAST_DRAWN_M2 = 0.01
SLIT_M = 0.015
SAME_END_M = 0.005
SAME_EDGE_M = 0.01  # an edge that moved by less is the same one, rounded
TOUCH_M = 0.03  # an outline this far inside an obstacle touches it; paths from elsewhere are checked to 0.02 m
TOLD = "The obstacle, or the new edge of the field,"
WIDER_THAN_A_FIELD_M = 3e4
INSIDE_M = 0.01  # a row is cut this far inside the turning ground, so that rounding does not put its end outside


class RestGround:
    """Answers what can be driven.

    Args:
        wish: its base document has the field as it was planned, its surroundings what stands there now.
        frame: the document's plane.
        home: where home is on it, if there is one.
        lays_laps: rows end at the headland of an edge that moved, for laps that are laid anew along it.
    """

    def __init__(
        self,
        wish: RestWish,
        frame: LocalFrame,
        machine: RobotProfile,
        home: tuple[float, float] | None,
        *,
        lays_laps: bool = False,
    ) -> None:
        self._wish, self._frame, self._machine, self._home = wish, frame, machine, home
        rings = [frame.to_local([(p[0], p[1]) for p in ring]) for ring in wish.base["parcel"]]
        parcel = Polygon(rings[0], rings[1:])
        self.parcel = parcel if parcel.is_valid else parcel.buffer(0)
        self.lost = self._no_field_now()
        drawn = [self._drawn(area) for area in wish.areas if area.kind == OBSTACLE]
        left_out = [self._drawn(area) for area in wish.areas if area.kind == LEAVE_OUT]
        self._closed = shapely.union_all([*closed_areas(wish.surroundings, frame, machine), *drawn])
        self.obstacles = shapely.union_all([self._closed, self.lost])
        # left out is left out: no lead, unlike a border of treatment
        self.doses = DoseMap(tuple((area, 0.0) for area in left_out))
        self.limits = limits_of(wish.surroundings, frame, machine)
        self._told = shapely.union_all([*drawn, self.lost])
        self._reach_m = machine.reach_m + machine.margin_m
        self._near = self.obstacles.buffer(self._reach_m)
        shapely.prepare(self._near)
        self.field = self.parcel.difference(self.obstacles)
        self.headland = self._headland() if lays_laps and self.has_new_edge else None
        self._edge = self.lost.buffer(self.headland.depth_m) if self.headland else Polygon()

    @property
    def has_new_edge(self) -> bool:
        """Whether the field lost ground, more than rounding makes."""
        return not erode(self.lost, 2 * SAME_EDGE_M).is_empty

    @property
    def outline(self) -> list[list[list[float]]]:
        """Return the field's rings, longitude and latitude: those of the map that the rest was planned on."""
        now = self._wish.field_now
        if now is None or now["type"] != "Polygon":  # several parts have no one outline
            return [[list(p) for p in ring] for ring in self._wish.base["parcel"]]
        return rings_of(now)

    def turn(self, start: Pose, end: Pose) -> list[Leg] | None:
        """Return a turn on the field, or ``None``."""
        return self._turns.between(start, end, self._machine.turn_speed_mps)

    def approach(self, kind: LegKind, start: Pose, end: Pose, *, is_free: bool) -> list[Leg] | None:
        """Return a way over field, roads and yards, or ``None``; ``is_free``: it may turn before it sets off."""
        linker = self._wide_linker(start)
        if is_free and self._machine.can_pivot:
            start = (start[0], start[1], math.atan2(end[1] - start[1], end[0] - start[0]))
        pieces = linker.link(start, end)
        if pieces is None:
            pieces = Lanes(linker).between(start, end)
        if pieces is None:
            return None
        return [Leg(kind, piece, way_speed(piece, self._machine, self._machine.way_mps)) for piece in pieces]

    def is_clear(self, points: Floats, *, is_backward: bool = False) -> bool:
        """Say whether nothing that stands on the map now is in the way of a path that was planned before."""
        if not shapely.intersects(self._near, shapely.linestrings(points)):
            return True
        return self._open.fits(points, is_backward=is_backward)

    def can_turn(self, place: Floats, spare_m: float) -> bool:
        """Say whether nothing that stands on the map now is in the circle the outline sweeps, ``spare_m`` around it."""
        return not shapely.dwithin(shapely.points(place), self.obstacles, self._machine.reach_m + spare_m)

    def met(self, points: Floats, *, is_backward: bool = False, pivot: bool = False) -> str:
        """Return in words what is in the way of a path that stays, empty if nothing is; ``pivot``: it begins with one.

        That is what is new since it was planned, with the machine's margin, and whatever the outline itself touches:
        beside an obstacle that was there already a path may run as near as it was planned.
        """
        line = shapely.linestrings(points)
        if not shapely.intersects(self._near, line):
            return ""
        outlines = self._machine.outline_polygons(poses_along(points, CHECK_STEP_M, is_backward=is_backward))
        is_free = not shapely.intersects(self._near_new, line) or self._but_new.fits(points, is_backward=is_backward)
        if pivot:
            spot = shapely.points(points[0])
            outlines = np.append(outlines, spot.buffer(self._machine.reach_m))
            is_free = is_free and not shapely.dwithin(
                spot, self._new, self._machine.reach_m + self._machine.margin_m / 2
            )
        if is_free and not shapely.intersects(self._solid, outlines).any():
            return ""
        swept = shapely.union_all(outlines).buffer(2 * self._machine.margin_m)  # for sure more than has to stay free
        return self._name_of(swept.intersection(self._solid if is_free else self._new))

    def around(self, points: Floats, *, is_lap: bool = False) -> list[Floats] | None:
        """Return the parts of a row or lap that can still be driven, ``None`` if all of it can.

        A row ends where the machine can turn on the spot. ``is_lap``: it may lie nearer to the border than that, and
        ends where an arc still leads off it.
        """
        if not self.ends_at_edge(points) and self.is_clear(points) and (is_lap or self._turns_at_ends(points)):
            return None
        if is_lap:
            return self._parts_of_lap(points)
        free = LineString(points).intersection(erode(self._ground.turning, INSIDE_M)).difference(self._edge)
        parts = [np.asarray(p.coords) for p in shapely.get_parts(free) if p.geom_type == "LineString"]
        parts = [p for p in parts if float(np.hypot(*np.diff(p, axis=0).T).sum()) >= LEAST_PART_M]
        line = LineString(points)
        parts.sort(key=lambda p: line.project(shapely.Point(p[0])))
        # the pieces of an intersection may run either way; the row runs as it was planned
        parts = [np.round(p if _is_along(line, p) else p[::-1], 3) + 0.0 for p in parts]
        for part in parts:
            for end in (0, -1):  # cut by less than the ways to a row may leave open: it ends where it did
                if math.dist(part[end], points[end]) < SAME_END_M:
                    part[end] = points[end]
        return parts

    def _turns_at_ends(self, row: Floats) -> bool:
        """Say whether a machine that turns on the spot still can at both ends of a row."""
        spare_m = self._machine.margin_m / 2
        return not self._machine.can_pivot or all(self.can_turn(end, spare_m) for end in (row[0], row[-1]))

    def ends_at_edge(self, points: Floats) -> bool:
        """Say whether a row meets the headland of an edge that moved."""
        return bool(shapely.intersects(self._edge, shapely.linestrings(points)))

    def is_lost(self, pose: Pose) -> bool:
        """Say whether any of the machine stands on ground that is no field any more."""
        return bool(shapely.intersects(self._machine.outline_polygons(np.array([pose])), self.lost).any())

    def missing(
        self, segments: Sequence[Document], left_out: Sequence[Document], beside_m: float = 0.0
    ) -> BaseGeometry:
        """Return the field that the base was to work and ``segments`` do not, but for what somebody left out.

        Args:
            left_out: pieces that are not wanted any more.
            beside_m: areas to leave out are taken so much wider: the tool is off over its whole width.
        """
        width_m = self._wish.base["width_m"]
        areas = [area.buffer(beside_m) for area, _ in self.doses.areas]
        missing = self._worked.difference(shapely.union_all([worked_by([*segments, *left_out], width_m), *areas]))
        # slits that rounding leaves between two pieces of a row are no ground
        return missing.buffer(-SLIT_M, join_style="mitre").buffer(SLIT_M, join_style="mitre").intersection(missing)

    @cached_property
    def _worked(self) -> BaseGeometry:
        base = self._wish.base
        return worked_by(base["segments"], base["width_m"]).intersection(self.field)

    def is_moved(self, lap: Document) -> bool:
        """Say whether a lap of the base is to be laid anew: it is nearer to the new edge than it was to the old."""
        return self.headland is not None and has_moved(lap, self.parcel.boundary, self.lost, self.headland.depth_m)

    def laps_anew(self, missing: BaseGeometry) -> RestLaps:
        """Return laps along the edges of the field as it is now that work what is missing."""
        assert self.headland is not None
        rows = erode(self.field, self.headland.depth_m)
        base = self._wish.base
        return RestLaps(self._linker, self.headland, base["segments"], base["width_m"], rows=rows, wanted=missing)

    def _parts_of_lap(self, points: Floats) -> list[Floats]:
        along_m, is_free = self._open.fitting(points)
        short_m = self._reach_m + self._machine.turning_radius_m
        edges = np.flatnonzero(np.diff(np.concatenate([[0], is_free.astype(int), [0]])))
        spans = []
        for first, after in zip(edges[::2], edges[1::2], strict=True):
            start = 0.0 if first == 0 else along_m[first] + short_m
            end = along_m[-1] if after == len(along_m) else along_m[after - 1] - short_m
            if end - start >= LEAST_LAP_M:
                spans.append((float(start), float(end)))
        return [np.round(between(points, *span), 3) + 0.0 for span in spans]

    @cached_property
    def _open(self) -> Ground:
        """Everywhere but where something stands: borders were looked at when the path was planned."""
        return Ground(_all_but(self.obstacles), self._machine)

    @cached_property
    def _new(self) -> BaseGeometry:
        """What stands there and was not known when the path was planned; of an unknown map only what was told since."""
        before = self._wish.around_before
        if before is None:
            return self._told
        known = shapely.union_all(closed_areas(before, self._frame, self._machine)).buffer(
            SAME_EDGE_M, join_style="mitre"
        )
        return shapely.union_all([self._told, self._closed.difference(known)])

    @cached_property
    def _near_new(self) -> BaseGeometry:
        return self._new.buffer(self._reach_m)

    @cached_property
    def _but_new(self) -> Ground:
        return Ground(_all_but(self._new), self._machine)

    @cached_property
    def _solid(self) -> BaseGeometry:
        solid = self._closed.buffer(-TOUCH_M)
        shapely.prepare(solid)
        return solid

    def _name_of(self, hit: BaseGeometry) -> str:
        """Return what people call the obstacle that lies at a place."""
        around = self._wish.surroundings
        closed = (area_of(geometry, width, self._frame) for geometry, width in (*around.obstacles, *around.crossed))
        far_m = [(hit.distance(area), name) for area, name in zip(closed, around.names, strict=False)]
        told_m = math.inf if self._told.is_empty else hit.distance(self._told)
        return min([(told_m, TOLD), *far_m], key=lambda one: one[0])[1]

    @cached_property
    def _ground(self) -> Ground:
        return Ground(self.field, self._machine, self._crop())

    @cached_property
    def _linker(self) -> Linker:
        return Linker(self._ground)

    @cached_property
    def _turns(self) -> Turns:
        return Turns(self._linker)

    def _wide_linker(self, start: Pose) -> Linker:
        """Field, roads, the yard at home, and the spot on which the machine stands anyway."""
        ways = way_areas(self._wish.surroundings, self._frame)
        ways.append(shapely.Point(start[:2]).buffer(self._machine.reach_m + 3 * self._machine.margin_m))
        if self._home is not None:
            ways.append(shapely.Point(self._home).buffer(YARD_RADIUS_M))
        together = shapely.union_all([self.field, *ways])
        closed = together.buffer(GAP_M, join_style="mitre").buffer(-GAP_M, join_style="mitre")
        # ground that is no field any more may be a road now
        return Linker(Ground(closed.difference(self._closed), self._machine, self._crop()))

    def _crop(self) -> BaseGeometry:
        """Return the standing rows as one area, a little smaller than it is, so that row ends stay free."""
        if self._machine.flies:
            return Polygon()
        width = self._wish.base["width_m"]
        rows = [LineString(s["points"]) for s in self._wish.base["segments"] if s["kind"] == "row"]
        if self.headland is not None and all(len(row.coords) == 2 for row in rows):
            # as the planner sees straight rows: ways around a border with a step at each row end take minutes to find
            area = erode(self.field, self.headland.depth_m)
        else:
            strips = [row.buffer(0.51 * width, cap_style="flat") for row in rows if row.length > 0]
            area = shapely.union_all(strips, grid_size=1e-3).difference(self._edge) if strips else Polygon()
        return shapely.union_all(polygons_of(erode(area, min(width, 1.0) * 0.6)))

    def _headland(self) -> Headland | None:
        least_m = self._machine.reach_m + self._machine.margin_m + INSIDE_M
        base = self._wish.base
        return headland_of(base["segments"], self.parcel.boundary, base["width_m"], least_m)

    def _no_field_now(self) -> BaseGeometry:
        """Return the ground of the base that the field does not have any more: a new edge, or a new hole."""
        if self._wish.field_now is None:
            return Polygon()
        now = area_of(self._wish.field_now, 0.0, self._frame)
        return self.parcel.difference(now.buffer(SAME_EDGE_M, join_style="mitre"))

    def _drawn(self, area: DrawnArea) -> BaseGeometry:
        """Return drawn ground; mending a crossed outline would lose a part of it, so it is refused."""
        local = shapely.transform(shapely.geometry.shape(area.geometry), self._frame.to_local)
        if not local.is_valid or local.area < LEAST_DRAWN_M2:
            raise PlanRefused("bad_area", "The outline of an area crosses itself or is tiny. Draw it again.", "areas")
        return local.buffer(area.clearance_m) if area.kind == OBSTACLE else local


def _all_but(area: BaseGeometry) -> BaseGeometry:
    return area.envelope.buffer(WIDER_THAN_A_FIELD_M).difference(area)


def _is_along(line: LineString, part: Floats) -> bool:
    return bool(line.project(shapely.Point(part[0])) <= line.project(shapely.Point(part[-1])))

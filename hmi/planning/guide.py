"""Rows along a drawn line: its parallels over the field, no tighter than the machine can drive."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from hmi.domain.mission_plan import PlanRefused
from hmi.planning.bends import NoSide, Side, cleaned, drawn_on, furthest, is_gentle, sides_of, thinned
from hmi.planning.projection import Floats

LEAST_GUIDE_M = 1.0
SMOOTH_M = 0.05  # a drawn line has corners that nobody means: they are rounded as far as it moves no more than this
STRAIGHTENED = 0.5  # of the row distance: a row that must be laid further from its place is refused
_TOLD_M = 0.05  # less is not worth a word
_SMOOTHER = (32.0, 16.0, 8.0, 4.0, 2.0, 1.0)  # times the turning radius
_MOST_LINES = 9_000
_LEAST_RADIUS_M = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Parallels:
    """Lines side by side, from the left of the guide line to its right; each in pieces, (N, 2) metres.

    ``along`` is the guide line drawn on; places along it tell neighbours. ``notes`` are for the planner to read.
    """

    lines: tuple[tuple[Floats, ...], ...]
    along: LineString
    notes: tuple[str, ...] = ()


def parallels(guide: Floats, inner: BaseGeometry, width_m: float, radius_m: float) -> Parallels:
    """Return the parallels of a line over an area.

    Args:
        guide: (N, 2) metres, as it was drawn.
        inner: area that the rows must cover.
        width_m: distance of the rows; one of them is the line itself.
        radius_m: no row bends tighter.

    Raises:
        PlanRefused: the line is unusable, or a row would have to bend too tightly; says where and what to do.
    """
    radius = max(radius_m, _LEAST_RADIUS_M)
    points = cleaned(guide)
    if len(points) < 2 or LineString(points).length < LEAST_GUIDE_M:
        raise PlanRefused("bad_guide", "The guide line is shorter than 1 m. Draw it again on the map.", "rows")
    return _Fan(points, inner, width_m, radius).spread()


class _Fan:
    """The parallels of one line while they are made."""

    def __init__(self, points: Floats, inner: BaseGeometry, width_m: float, radius_m: float) -> None:
        self.inner, self.width_m, self.radius_m = inner, width_m, radius_m
        reach = width_m + 2 * radius_m
        self.window = Polygon(inner.envelope.buffer(reach, join_style="mitre").exterior)
        corners = shapely.points(shapely.get_coordinates(self.window))
        self.far_m = float(shapely.distance(corners, LineString(points)).max()) + reach
        self.points = points
        self.told: list[tuple[float, str]] = []

    def spread(self) -> Parallels:
        left, right = self._smoothed()
        base = self._base(left)
        self.along = LineString(drawn_on(base, self.far_m, self.far_m))
        on_left, on_right = self._numbers(left)
        lines = [self._line(left, k) for k in on_left][::-1]
        lines += [self._line(right, k) for k in on_right]
        return Parallels(tuple(map(tuple, lines)), self.along, self._notes())

    def _smoothed(self) -> tuple[Side, Side]:
        """Return both sides of the line with the corners rounded that nobody means."""
        margin = self.far_m + 2 * _SMOOTHER[0] * self.radius_m
        try:
            sides = sides_of(self.points, self.window, margin)
        except NoSide:
            text = (
                "The guide line crosses itself, or its ends do when they are drawn on straight. "
                "Draw one that runs from edge to edge of the field."
            )
            raise PlanRefused("bad_guide", text, "rows") from None
        given = sides[0].parallel(0.0)
        near = self.inner.buffer(self.width_m)
        for times in _SMOOTHER:
            lines = sides[0].gentle_parallel(0.0, times * self.radius_m)
            moved_m, place = furthest(given, lines, near)
            if moved_m <= SMOOTH_M:
                break
        if moved_m > SMOOTH_M:
            self._judge(moved_m, place, 0.0)
        if len(lines) != 1:  # it passes the field by, or leaves it and comes back
            return sides
        try:
            return sides_of(lines[0], self.window, margin)
        except NoSide:
            return sides

    def _base(self, left: Side) -> Floats:
        lines = left.parallel(0.0)
        return max(lines, key=lambda line: LineString(line).length) if lines else self.points

    def _numbers(self, left: Side) -> tuple[range, range]:
        """Return the numbers of the rows on each side; that on the line itself, 0, is counted to the left."""
        corners = shapely.points(shapely.get_coordinates(shapely.segmentize(self.inner, self.width_m)))
        signs = np.where(shapely.covers(left.area, corners), 1.0, -1.0)
        offsets = signs * shapely.distance(corners, left.along)
        low = math.ceil(float(offsets.min()) / self.width_m - 0.5)
        high = math.floor(float(offsets.max()) / self.width_m + 0.5)
        if high - low > _MOST_LINES:
            text = f"That makes more than {_MOST_LINES} rows. Choose a larger row distance."
            raise PlanRefused("too_many_rows", text, "width_m")
        return range(max(low, 0), high + 1), range(max(1, -high), -low + 1)

    def _line(self, side: Side, number: int) -> list[Floats]:
        offset = number * self.width_m
        exact = side.parallel(offset)
        if all(is_gentle(line, self.radius_m) for line in exact):
            return [thinned(line, self.radius_m) for line in exact]
        lines = side.gentle_parallel(offset, self.radius_m)
        moved_m, place = furthest(exact, lines, self.inner)
        self._judge(moved_m, place, offset)
        return [thinned(line, self.radius_m) for line in lines]

    def _judge(self, moved_m: float, place: Floats | None, offset_m: float) -> None:
        """Refuse a row that must be laid too far from its place; remember one that is laid a little off."""
        if place is None or moved_m <= _TOLD_M:
            return
        where = self._where(place, offset_m)
        if moved_m > STRAIGHTENED * self.width_m:
            text = (
                f"A row would bend tighter than the robot's turning radius of {self.radius_m:g} m: {where}. "
                "Draw the guide line straighter there, or choose another row direction."
            )
            raise PlanRefused("guide_too_tight", text, "rows")
        self.told.append((moved_m, where))

    def _where(self, place: Floats, offset_m: float) -> str:
        line = LineString(self.points)
        along = f"{line.project(shapely.Point(place)):.0f} m along the guide line"
        return f"{along}, some {offset_m:.0f} m beside it" if offset_m >= 1 else along

    def _notes(self) -> tuple[str, ...]:
        if not self.told:
            return ()
        moved_m, where = max(self.told)
        rows = "1 row is" if len(self.told) == 1 else f"{len(self.told)} rows are"
        return (f"{rows} laid up to {moved_m:.2f} m straighter than the guide line asks, most {where}.",)

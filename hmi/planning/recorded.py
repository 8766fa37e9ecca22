"""Rows along recorded crop rows: as many of them in one pass as the tool takes, what is wrong with them named."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import median

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import substring

from hmi.domain.mission_plan import PlanRefused
from hmi.planning.bends import (
    NoSide,
    cleaned,
    distinct,
    drawn_on,
    furthest,
    is_gentle,
    sides_of,
    thinned,
)
from hmi.planning.guide import Parallels
from hmi.planning.neighbours import beside
from hmi.planning.projection import Floats

LEAST_ROW_M = 1.0
DRAWN_ON_M = 5.0  # a row that ends so near to the headland is worked up to it
GAP_M = 10.0  # a row with a gap up to this is driven through
STRAIGHTENED = 0.25  # of the row distance: crop rows are not left by more
_TOLD_M = 0.05
_SAME = 0.5  # of the row distance: lines nearer than this are pieces of one row
_WIDE = 1.5  # of the row distance: more between two rows is a gap
_NEARLY = 0.02  # of a row distance that a tool may lack
_STEP_M = 1.0
_WHOLE = 0.95  # of the longest row beside it: a middle row shorter than this does not stand for all
_NAMED = 3
_PROBES = 100  # rows whose distance to the next is measured
_LEAST_RADIUS_M = 0.05
_MOST_ROWS = 9_000


@dataclass(frozen=True, slots=True, eq=False)
class CropRow:
    """A recorded row, (N, 2) metres, and what people call it."""

    name: str
    points: Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Level:
    """What lies beside one another along the field at the same distance from the longest row: one row in pieces."""

    beside_m: float
    pieces: tuple[CropRow, ...]

    @property
    def name(self) -> str:
        return self.pieces[0].name

    @property
    def length_m(self) -> float:
        return sum(float(LineString(one.points).length) for one in self.pieces)


def passes(
    rows: Sequence[CropRow], inner: BaseGeometry, tool_m: float, radius_m: float, spacing_m: float | None
) -> Parallels:
    """Return the lines to drive so that the tool works every recorded row.

    Args:
        rows: as they were recorded, in any order and direction.
        inner: area that the rows must cover; rows are drawn on up to its edge if they end near it.
        tool_m: width of the tool; it takes whole rows.
        radius_m: no line bends tighter.
        spacing_m: distance of the crop rows, as the field says; ``None`` measures it.

    Raises:
        PlanRefused: the rows are unusable, or bend too tightly; says which.
    """
    return _Field(rows, inner, tool_m, max(radius_m, _LEAST_RADIUS_M), spacing_m).passes()


class _Field:
    """The recorded rows of a field while passes are made of them."""

    def __init__(
        self,
        rows: Sequence[CropRow],
        inner: BaseGeometry,
        tool_m: float,
        radius_m: float,
        spacing_m: float | None,
    ) -> None:
        self.inner, self.tool_m, self.radius_m = inner, tool_m, radius_m
        self.notes: list[str] = []
        self.doubled: list[str] = []
        self.gaps: list[str] = []
        self.bent: list[str] = []
        kept = [CropRow(row.name, cleaned(row.points)) for row in rows]
        kept = [row for row in kept if len(row.points) > 1 and LineString(row.points).length >= LEAST_ROW_M]
        if not kept:
            raise PlanRefused("bad_rows", "No recorded row is longer than 1 m. Record them again.", "rows")
        if len(kept) > _MOST_ROWS:
            raise PlanRefused("too_many_rows", f"More than {_MOST_ROWS} rows are recorded in this field.", "rows")
        self.rows = self._without_crossing(kept)
        longest = max(self.rows, key=lambda row: LineString(row.points).length)
        far_m = float(inner.envelope.length) + LineString(longest.points).length
        self.along = LineString(drawn_on(longest.points, far_m, far_m))
        self.spacing_m = spacing_m or self._measured_m() or tool_m

    def passes(self) -> Parallels:
        levels = self._levels()
        self._name_gaps(levels)
        lines = [self._driven(group) for group in self._groups(levels)]
        if self.bent:
            self.notes.append(f"Driven straighter than recorded, for they bend tightly: {_listed(self.bent)}.")
        return Parallels(tuple(tuple(line) for line in lines), self.along, tuple(self.notes))

    # which rows there are

    def _without_crossing(self, rows: list[CropRow]) -> list[CropRow]:
        """Leave out rows that cross others, those that cross most first, and name them."""
        shapes = [LineString(row.points) for row in rows]
        tree = shapely.STRtree(shapes)
        a, b = tree.query(shapes, predicate="crosses")
        crossing: dict[int, set[int]] = {}
        for i, k in zip(a.tolist(), b.tolist(), strict=True):
            crossing.setdefault(i, set()).add(k)
        left_out: list[str] = []
        gone: set[int] = set()
        while any(crossing.values()):
            worst = max(crossing, key=lambda k: (len(crossing[k]), -shapes[k].length))
            others = sorted(crossing.pop(worst))
            for other in others:
                crossing[other].discard(worst)
            gone.add(worst)
            left_out.append(f"{rows[worst].name} crosses {rows[others[0]].name}")
        if left_out:
            self.notes.append(f"Left out: {_listed(left_out)}. Mend them on the map.")
        return [row for k, row in enumerate(rows) if k not in gone]

    def _measured_m(self) -> float | None:
        """Return the usual distance from a row to the next, ``None`` with one row only."""
        if len(self.rows) < 2:
            return None
        shapes = np.array([LineString(row.points) for row in self.rows], dtype=object)
        probes = range(0, len(shapes), max(1, len(shapes) // _PROBES))
        middles = [shape.interpolate(0.5, normalized=True) for shape in shapes]
        nearest = [shapely.distance(np.delete(shapes, k), middles[k]).min() for k in probes]
        return float(np.median(nearest))

    def _levels(self) -> list[_Level]:
        """Return the rows from the left of the longest to its right, those of one line together."""
        places = beside(self.along, [row.points for row in self.rows], 3 * self.spacing_m)
        ordered = sorted(zip(places, self.rows, strict=True), key=lambda one: -one[0])
        groups: list[list[tuple[float, CropRow]]] = []
        for place, row in ordered:
            if groups and groups[-1][0][0] - place < _SAME * self.spacing_m:
                groups[-1].append((place, row))
            else:
                groups.append([(place, row)])
        levels = [self._level(group) for group in groups]
        if self.doubled:
            self.notes.append(f"Left out, for it lies on another row: {_listed(self.doubled)}.")
        if self.gaps:
            self.notes.append(f"Gaps in rows are driven through: {_listed(self.gaps)}.")
        return levels

    def _level(self, group: list[tuple[float, CropRow]]) -> _Level:
        """Return the pieces of one row in order; those that lie on one another are named and left out."""
        pieces = sorted((row for _, row in group), key=lambda row: self._span(row.points)[0])
        pieces = [CropRow(row.name, self._forward(row.points)) for row in pieces]
        kept: list[CropRow] = []
        for row in pieces:
            if kept and self._span(row.points)[0] < self._span(kept[-1].points)[1] - LEAST_ROW_M:
                shorter, longer = sorted((kept[-1], row), key=lambda one: LineString(one.points).length)
                kept[-1] = longer
                self.doubled.append(f"{shorter.name} on {longer.name}")
            elif kept and self._can_join(kept[-1].points, row.points):
                gap_m = math.dist(kept[-1].points[-1], row.points[0])
                if gap_m > LEAST_ROW_M:
                    self.gaps.append(f"{gap_m:.0f} m in {kept[-1].name}")
                kept[-1] = CropRow(kept[-1].name, distinct(np.vstack([kept[-1].points, row.points])))
            else:
                kept.append(row)
        return _Level(float(np.mean([place for place, _ in group])), tuple(kept))

    def _can_join(self, before: Floats, after: Floats) -> bool:
        joined = distinct(np.vstack([before, after]))
        return math.dist(before[-1], after[0]) <= GAP_M and is_gentle(joined, self.radius_m)

    def _span(self, points: Floats) -> tuple[float, float]:
        first, last = sorted(float(self.along.project(shapely.Point(p))) for p in points[[0, -1]])
        return first, last

    def _forward(self, points: Floats) -> Floats:
        first, last = (self.along.project(shapely.Point(p)) for p in points[[0, -1]])
        return points if first <= last else points[::-1]

    def _name_gaps(self, levels: Sequence[_Level]) -> None:
        apart = [(a.beside_m - b.beside_m, f"between {a.name} and {b.name}") for a, b in pairwise(levels)]
        usual_m = median(gap_m for gap_m, _ in apart) if apart else 0.0
        rest = "what the tool does not reach from them is not worked."
        if usual_m <= _WIDE * self.spacing_m:
            usual_m = self.spacing_m
        elif usual_m > (1 + _NEARLY) * self.tool_m:  # else one line was recorded for each pass, and nothing is missed
            said = f"The recorded rows lie {usual_m:.2g} m apart, and the tool is {self.tool_m:.2g} m wide"
            self.notes.append(f"{said}: {rest}")
        gaps = [f"{gap_m:.1f} m {where}" for gap_m, where in apart if gap_m > _WIDE * usual_m]
        if gaps:
            self.notes.append(f"The rows lie {usual_m:.2g} m apart, but there are {_listed(gaps)}: {rest}")

    # how they are driven

    def _groups(self, levels: Sequence[_Level]) -> list[list[_Level]]:
        """Return the rows that one pass works: as many whole ones as the tool is wide."""
        most = max(1, math.floor(self.tool_m / self.spacing_m + _NEARLY))
        groups: list[list[_Level]] = []
        for level in levels:
            last = groups[-1] if groups else []
            is_near = bool(last) and last[0].beside_m - level.beside_m < (most - 1 + _SAME) * self.spacing_m
            if is_near and len(last) < most:
                last.append(level)
            else:
                groups.append([level])
        return groups

    def _driven(self, group: Sequence[_Level]) -> list[Floats]:
        """Return the line of a pass, in pieces: its middle row, or the middle of its rows where none lies there."""
        middle, longest = group[len(group) // 2], max(group, key=lambda level: level.length_m)
        spans = [self._span(one.points) for level in group for one in level.pieces]
        whole = (min(a for a, _ in spans), max(b for _, b in spans))
        if len(group) % 2 and middle.length_m >= _WHOLE * longest.length_m:
            lines = [one.points for one in middle.pieces]
        else:
            lines = [self._centred(one.points, group) for one in longest.pieces]
        last = len(lines) - 1
        return [
            self._drivable(line, longest.name, whole, is_first=k == 0, is_last=k == last)
            for k, line in enumerate(lines)
        ]

    def _centred(self, points: Floats, group: Sequence[_Level]) -> Floats:
        """Return a row moved to the middle of the rows beside it; where one of them lacks, as far as next to that."""
        line = LineString(points)
        places = line.interpolate(np.linspace(0.0, line.length, max(2, math.ceil(line.length / _STEP_M) + 1)))
        moved = shapely.get_coordinates(places)
        for level in (group[0], group[-1]):
            outer = shapely.MultiLineString([one.points for one in level.pieces])
            nearest = shapely.get_coordinates(shapely.shortest_line(places, outer)).reshape(-1, 2, 2)
            steps = nearest[:, 1] - nearest[:, 0]
            beside = np.flatnonzero(np.hypot(*steps.T) < (len(group) + _SAME) * self.spacing_m)
            if len(beside):
                every = np.arange(len(steps))
                moved += np.column_stack([np.interp(every, beside, steps[beside, k]) for k in (0, 1)]) / 2
        found = cleaned(moved)
        return found if len(found) > 1 else points

    def _drivable(
        self, points: Floats, name: str, whole: tuple[float, float], *, is_first: bool, is_last: bool
    ) -> Floats:
        """Return a line drawn on to the edge of the area if that is near, with its tight bends rounded."""
        begin, end = self._span(points)
        before_m = self._lacking_m(points[::-1], max(0.0, begin - whole[0]) if is_first else 0.0)
        after_m = self._lacking_m(points, max(0.0, whole[1] - end) if is_last else 0.0)
        line = drawn_on(points, before_m, after_m)
        if is_gentle(line, self.radius_m):
            return thinned(line, self.radius_m)
        return self._rounded(distinct(line), name)

    def _lacking_m(self, points: Floats, others_m: float) -> float:
        """Return by how much to draw a line on at its end: to the edge of the area, or as far as its neighbours go."""
        reach_m = DRAWN_ON_M + others_m
        tip = drawn_on(points, 0.0, reach_m)[-2:]
        inside = LineString(tip).intersection(self.inner)
        if not self.inner.covers(shapely.Point(tip[1])):
            return reach_m if not inside.is_empty else self.tool_m  # beyond the edge it is cut
        return others_m

    def _rounded(self, line: Floats, name: str) -> Floats:
        window = Polygon(LineString(line).envelope.buffer(1.0 + 4 * self.radius_m, join_style="mitre").exterior)
        try:
            left, _ = sides_of(line, window, 10 * self.radius_m)
        except NoSide:
            raise PlanRefused("bad_rows", f"{_capital(name)} crosses itself. Mend it on the map.", "rows") from None
        rounded = left.gentle_parallel(0.0, self.radius_m)
        moved_m, place = furthest([line], rounded, self.inner)
        if moved_m > STRAIGHTENED * self.spacing_m and place is not None:
            at_m = LineString(line).project(shapely.Point(place))
            text = (
                f"{_capital(name)} bends tighter than the robot's turning radius of {self.radius_m:g} m, {at_m:.0f} m "
                "from its beginning. Mend it on the map, or choose another row direction."
            )
            raise PlanRefused("rows_too_tight", text, "rows")
        if moved_m > _TOLD_M:
            self.bent.append(f"{name} by up to {moved_m:.2f} m")
        # the rounded line runs on to the window's edge
        whole = max(rounded, key=lambda one: LineString(one).length)
        first, last = sorted(LineString(whole).project(shapely.Point(p)) for p in line[[0, -1]])
        cut = substring(LineString(whole), first, last)
        return thinned(shapely.get_coordinates(cut), self.radius_m)


def _capital(name: str) -> str:
    return name[:1].upper() + name[1:]


def _listed(texts: Iterable[str]) -> str:
    found = list(texts)
    shown = "; ".join(found[:_NAMED])
    return shown if len(found) <= _NAMED else f"{shown}; and {len(found) - _NAMED} more"

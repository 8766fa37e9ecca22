"""Headland laps of a rest laid anew along an edge of the field that moved since the mission was planned.

Of the laps that fit the field as it is now those stretches are driven that work ground which nothing else of the
mission works; where nothing of a lap is done yet that is the whole of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise, product

import numpy as np
import shapely
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from hmi.domain.mission_document import Document
from hmi.domain.mission_rest import WORK_KINDS
from hmi.planning import headland as headlands
from hmi.planning.corners import Corners
from hmi.planning.dubins import Pose
from hmi.planning.figures import GRID_M, worked_strips
from hmi.planning.headland import Headland, Lap
from hmi.planning.links import Linker
from hmi.planning.plan import Leg, LegKind, headings
from hmi.planning.polyline import length_m
from hmi.planning.projection import Floats
from hmi.planning.rest_work import leg_of
from hmi.planning.spans import between
from hmi.planning.treatment import EVERYWHERE, DoseMap

LEAST_LAP_M = 5.0  # a shorter stretch is not worth the arcs onto and off it; so short a gap is driven through
_STEP_M = 0.5
_ACROSS = (-0.4, -0.2, 0.0, 0.2, 0.4)  # of the width: where a lap is asked what it works
_WORTH = 0.4  # of these
_WHOLE = 0.9  # of a lap worth driving: it is driven whole
_BEYOND_M = (0.0, 4.0, 8.0, 14.0)  # driven of a lap before and after what is worked of it, where arcs need that
_SAME_M = 0.1  # laps so much further from the border are others
_MOVED_M = 0.05


class Laps(Enum):
    """What becomes of headland laps that something new stands in the way of, the best first."""

    ANEW = "anew"  # laid along the edge of the field as it is now
    ALL_ANEW = "all_anew"  # so are those that the new edge leaves alone: they are joined elsewhere, and last
    CUT = "cut"
    WHOLE = "whole"  # left out: nothing leads to or from a piece of one

    LEAVING = "leaving"  # laid anew, and any piece left out that no way leads to

    @property
    def lays(self) -> bool:
        """Whether laps are laid that the mission did not have."""
        return self not in (Laps.CUT, Laps.WHOLE)


Way = Callable[[Pose, Pose], list[Leg] | None]


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """A line to work along, and what of its lap is driven before and after it with the tool off, if anything."""

    points: Floats
    before: Floats | None = None
    after: Floats | None = None

    @property
    def first(self) -> Pose:
        """Where it is joined."""
        line = self.points if self.before is None else self.before
        return _pose(line[0], line[:2])

    @property
    def last(self) -> Pose:
        """Where it is left."""
        line = self.points if self.after is None else self.after
        return _pose(line[-1], line[-2:])

    def reversed(self) -> _Line:
        """Return the line driven the other way round."""
        before, after = (None if one is None else one[::-1].copy() for one in (self.after, self.before))
        return _Line(self.points[::-1].copy(), before, after)


@dataclass(frozen=True, slots=True, eq=False)
class _Stretch:
    """A lap, or what of ``ring`` lies between two places.

    Args:
        lap: what is worked; closed where it is driven whole.
        ring: the whole of the lap, twice.
        begin_m, end_m: along the ring.
    """

    lap: Lap
    ring: Floats | None = None
    begin_m: float = 0.0
    end_m: float = 0.0

    def lines(self, here: Pose) -> Iterator[_Line]:
        """Yield the lines it can be driven along, the nearest first.

        Where one cannot be joined or left at its end, in a corner, it is joined or left sooner or later on its lap.
        """
        if self.ring is None:
            for points in sorted(headlands.beginnings(self.lap), key=lambda line: headlands.entry_cost(here, line)):
                yield _Line(points)
            return
        whole_m = length_m(self.ring) / 2
        for before_m, after_m in sorted(product(_BEYOND_M, repeat=2), key=sum):
            if self.end_m - self.begin_m + before_m + after_m > whole_m:
                continue
            before = self._beyond(self.begin_m - before_m, self.begin_m, whole_m) if before_m else None
            after = self._beyond(self.end_m, self.end_m + after_m, whole_m) if after_m else None
            line = _Line(self.lap.points, before, after)
            yield from sorted((line, line.reversed()), key=lambda one: headlands.entry_cost(here, one.points))

    def _beyond(self, from_m: float, to_m: float, whole_m: float) -> Floats:
        assert self.ring is not None
        shift_m = whole_m if from_m < 0 else -whole_m if to_m > 2 * whole_m else 0.0
        return between(self.ring, from_m + shift_m, to_m + shift_m)


class RestLaps:
    """The laps of a rest on the field as it is now.

    Args:
        linker: finds ways on the field as it is now.
        headland: of the mission, see ``headland_of``.
        base: the mission's segments.
        width_m: that a pass works.
        rows: ground behind the headland as it is now.
        wanted: ground that only laps can work now.
    """

    def __init__(
        self,
        linker: Linker,
        headland: Headland,
        base: Sequence[Document],
        width_m: float,
        *,
        rows: BaseGeometry,
        wanted: BaseGeometry,
    ) -> None:
        self._linker, self._width_m = linker, width_m
        self._doses = doses_of(base, width_m)
        speeds = [s["speed_mps"] for s in base if s["kind"] == "headland" and s.get("tool_on")]
        self._work_mps = max(speeds, default=linker.machine.row_speed_mps)
        self._waiting = [*self._laid(headland, wanted)]
        self._driven_m = 0.0
        laps = [one.lap for one in self._waiting]
        self._corners = Corners(linker, laps, rows, wanted, width_m, may_pivot=any(s.get("pivot") for s in base[1:]))

    @property
    def is_done(self) -> bool:
        """Whether all of them were driven."""
        return not self._waiting

    @property
    def notes(self) -> list[str]:
        """What became of them, in words."""
        left_m = sum(length_m(one.lap.points) for one in self._waiting)
        laid = f"{self._driven_m:.0f} m of headland laps are laid anew along the edge of the field as it is now."
        left = f"{left_m:.0f} m of headland laps are left out, no way leads there."
        return [*([laid] if self._driven_m else []), *([left] if left_m else [])]

    def drive(self, here: Pose, way: Way) -> list[Leg]:
        """Drive the laps, the nearest first, and return the legs; those that no way leads to stay for another time.

        Args:
            way: finds the way from one pose to another.
        """
        legs: list[Leg] = []
        wanted, self._waiting = self._waiting, []
        while wanted:
            spot = shapely.Point(here[:2])
            lap = min(wanted, key=lambda one: float(LineString(one.lap.points).distance(spot)))
            wanted.remove(lap)
            new = self._driven(lap, here, way)
            if not new:
                self._waiting.append(lap)
                continue
            self._driven_m += length_m(lap.lap.points)
            legs += new
            x, y = legs[-1].points[-1]
            here = float(x), float(y), legs[-1].last_heading_rad
        return legs

    def _driven(self, one: _Stretch, here: Pose, way: Way) -> list[Leg]:
        for line in one.lines(here):
            there = way(here, line.first) if self._linker.can_leave(line.last) else None
            if there is not None:
                before, after = self._idle(line.before), self._idle(line.after)
                return [*there, *before, *self._doses.cut(self._legs(one.lap, line.points)), *after]
        return []

    def _idle(self, points: Floats | None) -> list[Leg]:
        return [] if points is None else [Leg(LegKind.TURN, points, self._linker.machine.turn_speed_mps)]

    def _legs(self, lap: Lap, points: Floats) -> list[Leg]:
        return [
            Leg(
                LegKind.HEADLAND,
                part.points,
                self._work_mps if part.is_worked else self._linker.machine.turn_speed_mps,
                tool_on=part.is_worked,
                is_continued=number > 0,
            )
            for number, part in enumerate(self._corners.stretches(lap, points))
        ]

    def _laid(self, headland: Headland, wanted: BaseGeometry) -> list[_Stretch]:
        found: list[_Stretch] = []
        for lap in headlands.laps(self._linker.ground, headland):
            stretches = self._worth(lap, wanted)
            if stretches:
                found += stretches
                taken = headlands.strips([one.lap for one in stretches], self._width_m)
                wanted = wanted.difference(shapely.union_all(taken))
        return found

    def _worth(self, lap: Lap, wanted: BaseGeometry) -> list[_Stretch]:
        """Return what of a closed lap works ground that is wanted."""
        shapely.prepare(wanted)
        whole_m = length_m(lap.points)
        count = max(4, round(whole_m / _STEP_M))
        is_worth = self._is_worth(lap.points, count, wanted)
        if is_worth.mean() >= _WHOLE:
            return [_Stretch(lap)]
        if not is_worth.any():
            return []
        first = int(np.flatnonzero(~is_worth)[0])  # the ring is cut where nothing is lost
        step_m = whole_m / count
        runs = _runs(np.roll(is_worth, -first), LEAST_LAP_M / step_m)
        twice = np.vstack([lap.points, lap.points[1:]])
        spans = [((first + a) * step_m, (first + b) * step_m) for a, b in runs]
        return [_Stretch(Lap(between(twice, a, b), lap.offset_m, lap.is_inner), twice, a, b) for a, b in spans]

    def _is_worth(self, ring: Floats, count: int, wanted: BaseGeometry) -> np.ndarray:
        along = np.append(0.0, np.cumsum(np.hypot(*np.diff(ring, axis=0).T)))
        places = (np.arange(count) + 0.5) / count * along[-1]
        x, y = (np.interp(places, along, ring[:, k]) for k in (0, 1))
        heading = headings(ring)[np.searchsorted(along, places) - 1]
        aside = np.array(_ACROSS)[:, None] * self._width_m
        inside = shapely.contains_xy(wanted, x - aside * np.sin(heading), y + aside * np.cos(heading))
        return np.asarray(inside.mean(axis=0) >= _WORTH - 1e-9)


def headland_of(
    base: Sequence[Document], border: BaseGeometry, width_m: float, least_depth_m: float
) -> Headland | None:
    """Return how the headland of a mission was divided, read off its laps; ``None`` if it has none.

    Args:
        base: the mission's segments.
        border: the edges of its field, as it was planned.
        least_depth_m: the inner field begins no nearer to the border.
    """
    laps = [LineString(s["points"]) for s in base if s["kind"] == "headland" and s.get("tool_on")]
    laps = [lap for lap in laps if lap.length >= LEAST_LAP_M]
    if not laps:
        return None
    far_m = sorted(_far_m(lap, border) for lap in laps)
    offsets = [far_m[0]]
    # laps around obstacles lie anywhere: only such as follow one another at the border count
    for far in far_m[1:]:
        if _SAME_M < far - offsets[-1] <= width_m + _SAME_M and far - offsets[-1] >= width_m / 2:
            offsets.append(far)
    apart_m = min((b - a for a, b in pairwise(offsets)), default=width_m)
    return Headland(tuple(offsets), max(offsets[-1] + apart_m / 2, least_depth_m))


def has_moved(segment: Document, border: BaseGeometry, lost: BaseGeometry, depth_m: float) -> bool:
    """Say whether a lap is nearer to ground that the field lost than it was to its border."""
    lap = LineString(segment["points"])
    return bool(lap.distance(lost) < min(_far_m(lap, border), depth_m) - _MOVED_M)


def worked_by(segments: Sequence[Document], width_m: float) -> BaseGeometry:
    """Return the ground that segments with the tool on work."""
    return shapely.union_all(worked_strips([leg_of(one) for one in segments], width_m), grid_size=GRID_M)


def doses_of(base: Sequence[Document], width_m: float) -> DoseMap:
    """Return the doses of a mission by the ground that got them; off where it drove rows or laps with the tool off."""
    legs = [leg_of(one) for one in base]
    zones = []
    for dose in sorted({leg.dose for leg in legs if leg.tool_on}):
        area = shapely.union_all(
            worked_strips([leg for leg in legs if leg.tool_on and leg.dose == dose], width_m), grid_size=GRID_M
        )
        zones.append((area.buffer(width_m / 4).buffer(-width_m / 4), dose))
    worked = shapely.union_all([area for area, _ in zones])
    idle = [LineString(leg.points) for leg in legs if leg.kind.value in WORK_KINDS and not leg.tool_on]
    # the loops in corners run over ground that others work
    is_plain = all(dose == 1.0 for _, dose in zones) and shapely.covers(worked, idle).all()
    return EVERYWHERE if is_plain else DoseMap(tuple(zones), rest=0.0)


def _far_m(lap: LineString, border: BaseGeometry) -> float:
    places = shapely.points(shapely.get_coordinates(shapely.segmentize(lap, 1.0)))
    return float(np.median(shapely.distance(places, border)))


def _pose(place: Floats, piece: Floats) -> Pose:
    return float(place[0]), float(place[1]), float(headings(piece)[0])


def _runs(is_worth: np.ndarray, least: float) -> list[tuple[int, int]]:
    """Return where runs begin and end, short gaps filled and short runs left out."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], is_worth.astype(int), [0]])))
    joined: list[list[int]] = []
    for first, after in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if joined and first - joined[-1][1] < least:
            joined[-1][1] = after
        else:
            joined.append([first, after])
    return [(first, after) for first, after in joined if after - first >= least]

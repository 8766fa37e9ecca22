"""The path of a mission as one line with distances: where am I, what comes next, how fast may I be.

Frame: the robot's ENU, metres. ``s_m`` is the distance along the whole line.
"""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from backend_clients.edge.messages_down import Segment
from backend_clients.simulator.kinematics import TRACKED, Motion, wrap_rad

Point = tuple[float, float]
PIVOT_RAD = math.radians(35)  # sharper corners are turned on the spot; sampled arcs are far flatter
SMOOTH_M = 0.3  # a vertex is felt over this length, so that sampled arcs give a steady curvature
MIN_CORNER_MPS = 0.25
SEARCH_BACK_M, SEARCH_AHEAD_M = 1.0, 3.0
SAME_POINT_M = 1e-4
MAX_GAP_M = 2.0  # a planner's rounding is far smaller; more is a broken path


class RouteError(ValueError):
    """The path cannot be driven: no length, or broken numbers."""


@dataclass(frozen=True, slots=True)
class Leg:
    """One segment of the mission on the line."""

    index: int
    kind: str
    row: int
    is_tool_on: bool
    speed_mps: float
    start_m: float
    end_m: float
    own_start_m: float  # where its first point lies; before it is the way over from the segment before
    is_jump: bool = False  # nobody drives that way over
    dose: float = 1.0
    is_backward: bool = False

    @property
    def drive_from_m(self) -> float:
        """Where driving this segment begins on the line."""
        return self.own_start_m if self.is_jump else self.start_m

    def is_tool_wanted(self, s_m: float) -> bool:
        """Whether the tool works at ``s_m`` on this segment."""
        return self.is_tool_on and s_m >= self.own_start_m


class Reference(NamedTuple):
    """The line near the robot: pose, curvature, and how far left of it the robot is."""

    s_m: float
    heading_rad: float
    curvature_1pm: float
    left_m: float


class Route:
    """A line through all segments with its corners, speed limits and remaining time.

    Args:
        segments: in driving order, in the robot's ENU frame.
        motion: what the machine can do.
    """

    def __init__(self, segments: Sequence[Segment], motion: Motion = TRACKED) -> None:
        self.motion = motion
        _check_backward(segments, motion)
        points, bounds = _join(segments)
        if len(points) < 2:
            raise RouteError("the path has no length")
        xy = np.asarray(points, dtype=np.float64)
        steps = np.diff(xy, axis=0)
        s = np.concatenate(([0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))))
        self._x, self._y, self._s = array("d", xy[:, 0]), array("d", xy[:, 1]), array("d", s)
        self.length_m = float(s[-1])
        self.legs = [
            _leg(i, seg, motion.max_speed_mps, (float(s[a]), float(s[own]), float(s[b])))
            for i, (seg, (a, own, b)) in enumerate(zip(segments, bounds, strict=True))
        ]
        self._leg_ends = array("d", [leg.end_m for leg in self.legs])
        declared = [entry for seg, (entry, _, _) in zip(segments, bounds, strict=True) if seg.pivot and entry > 0]
        for seg, (entry, own, _) in zip(segments, bounds, strict=True):
            declared += [i for i in (entry, own) if seg.jump is True and i > 0]
        back = np.repeat([seg.backward is True for seg in segments], [b - a for a, _, b in bounds])
        cusps = (np.flatnonzero(np.diff(back)) + 1).tolist()
        self._cusps = array("d", s[cusps])
        pivots, slow_s, slow_v = _corners(steps, s, back, [*declared, *cusps], motion)
        self.pivots = array("d", pivots)
        self._slow_s, self._slow_v = array("d", slow_s), array("d", slow_v)
        self._times = self._leg_times()
        self.rows = max((leg.row for leg in self.legs), default=0)
        self.has_jump = any(leg.is_jump for leg in self.legs)
        self.tool_m = sum(leg.end_m - leg.own_start_m for leg in self.legs if leg.is_tool_on)

    def leg_at(self, s_m: float) -> Leg:
        """Return the segment under ``s_m``; at a joint, the one that begins there."""
        return self.legs[min(bisect_right(self._leg_ends, s_m), len(self.legs) - 1)]

    def next_leg(self, leg: Leg) -> Leg | None:
        """Return the segment after ``leg``."""
        return self.legs[leg.index + 1] if leg.index + 1 < len(self.legs) else None

    def point_at(self, s_m: float) -> Point:
        """Return the point at a distance along the line."""
        i = min(max(bisect_right(self._s, s_m) - 1, 0), len(self._s) - 2)
        a, b = self._s[i], self._s[i + 1]
        t = (min(max(s_m, 0.0), self.length_m) - a) / (b - a)
        return self._x[i] + t * (self._x[i + 1] - self._x[i]), self._y[i] + t * (self._y[i + 1] - self._y[i])

    def part(self, from_m: float, until_m: float) -> list[Point]:
        """Return the points of the line between two distances, its own corners among them."""
        first, last = bisect_right(self._s, from_m), bisect_left(self._s, until_m)
        corners = [(self._x[i], self._y[i]) for i in range(first, last)]
        return [self.point_at(from_m), *corners, self.point_at(until_m)]

    def heading_after(self, s_m: float) -> float:
        """Return how the machine looks just after ``s_m``: along the line, or against it."""
        x0, y0 = self.point_at(s_m)
        x1, y1 = self.point_at(min(s_m + SMOOTH_M / 2, self.next_pivot(s_m + 1e-6)))
        return wrap_rad(math.atan2(y1 - y0, x1 - x0) + math.pi * self.leg_at(s_m).is_backward)

    def is_cusp(self, s_m: float) -> bool:
        """Say whether the machine stops there to drive the other way."""
        i = bisect_left(self._cusps, s_m - 1e-6)
        return i < len(self._cusps) and self._cusps[i] <= s_m + 1e-6

    def next_cusp(self, s_m: float) -> float:
        """Return where it next drives the other way, or the end of the line."""
        i = bisect_right(self._cusps, s_m)
        return self._cusps[i] if i < len(self._cusps) else self.length_m

    def next_pivot(self, s_m: float) -> float:
        """Return where it next turns on the spot or drives the other way, or the end of the line."""
        i = bisect_left(self.pivots, s_m)
        return self.pivots[i] if i < len(self.pivots) else self.length_m

    def previous_pivot(self, s_m: float) -> float:
        """Return the newest such place at or before ``s_m``, or the start of the line."""
        i = bisect_right(self.pivots, s_m)
        return self.pivots[i - 1] if i else 0.0

    def locate(self, x_m: float, y_m: float, from_m: float, until_m: float) -> float:
        """Return the distance along the line of the nearest point in ``from_m..until_m``."""
        low, high = max(from_m, 0.0), min(until_m, self.length_m)
        first = min(max(bisect_right(self._s, low) - 1, 0), len(self._s) - 2)
        best, best_d2 = low, math.inf
        for i in range(first, len(self._s) - 1):
            a = self._s[i]
            if a > high:
                break
            ax, ay = self._x[i], self._y[i]
            dx, dy = self._x[i + 1] - ax, self._y[i + 1] - ay
            length = self._s[i + 1] - a
            t = ((x_m - ax) * dx + (y_m - ay) * dy) / (length * length)
            s = min(max(a + min(max(t, 0.0), 1.0) * length, low), high)
            t = (s - a) / length
            d2 = (x_m - ax - t * dx) ** 2 + (y_m - ay - t * dy) ** 2
            if d2 < best_d2:
                best, best_d2 = s, d2
        return best

    def reference(self, x_m: float, y_m: float, last_s_m: float) -> Reference:
        """Return the line at the robot, looking only near ``last_s_m`` and between two pivots."""
        low, high = self.previous_pivot(last_s_m), self.next_pivot(last_s_m + 1e-6)
        s = self.locate(x_m, y_m, max(low, last_s_m - SEARCH_BACK_M), min(high, last_s_m + SEARCH_AHEAD_M))
        bx, by = self.point_at(max(s - SMOOTH_M, low))
        px, py = self.point_at(s)
        fx, fy = self.point_at(min(s + SMOOTH_M, high))
        heading = math.atan2(fy - by, fx - bx)
        curvature = 0.0
        if s - low > SMOOTH_M and high - s > SMOOTH_M:
            bend = wrap_rad(math.atan2(fy - py, fx - px) - math.atan2(py - by, px - bx))
            curvature = bend / SMOOTH_M
        left = -(x_m - px) * math.sin(heading) + (y_m - py) * math.cos(heading)
        return Reference(s, heading, curvature, left)

    def speed_limit(self, s_m: float, decel_mps2: float) -> float:
        """Return the fastest speed at ``s_m`` that can still keep every limit ahead."""
        leg = self.leg_at(s_m)
        limit = leg.speed_mps
        after = self.next_leg(leg)
        if after is not None and after.speed_mps < limit:
            limit = min(limit, _before(after.speed_mps, leg.end_m - s_m, decel_mps2))
        reach = s_m + limit * limit / (2 * decel_mps2)
        for i in range(bisect_left(self._slow_s, s_m - SMOOTH_M), len(self._slow_s)):
            if self._slow_s[i] > reach:
                break
            limit = min(limit, _before(self._slow_v[i], self._slow_s[i] - SMOOTH_M - s_m, decel_mps2))
        return limit

    def remaining_s(self, s_m: float) -> float:
        """Return the expected driving time from ``s_m`` to the end."""
        leg = self.leg_at(s_m)
        share = (leg.end_m - s_m) / max(leg.end_m - leg.drive_from_m, 1e-9)
        duration = self._times[leg.index] - self._times[leg.index + 1]
        return self._times[leg.index + 1] + duration * min(max(share, 0.0), 1.0)

    def _leg_times(self) -> list[float]:
        """Return for each segment, and for the end, the time from its start to the end of the line."""
        times, total = [0.0], 0.0
        for leg in reversed(self.legs):
            low, high = bisect_left(self.pivots, leg.drive_from_m), bisect_left(self.pivots, leg.end_m)
            slow = self._slow_v[bisect_left(self._slow_s, leg.drive_from_m) : bisect_left(self._slow_s, leg.end_m)]
            speed = min(leg.speed_mps, *slow) if len(slow) and leg.kind == "turn" else leg.speed_mps
            total += (leg.end_m - leg.drive_from_m) / speed + (high - low) * 4.0  # brake, pivot, speed up
            times.append(total)
        return times[::-1]


def straight(points: Sequence[Point], speed_mps: float, motion: Motion = TRACKED) -> Route:
    """Return a plain route through ``points`` with the tool off, e.g. the way home."""
    return Route([Segment(kind="approach", points=list(points), speed_mps=speed_mps)], motion)


def _leg(index: int, segment: Segment, top_mps: float, bounds_m: tuple[float, float, float]) -> Leg:
    start_m, own_start_m, end_m = bounds_m
    return Leg(
        index,
        segment.kind,
        segment.row,
        segment.tool_on,
        min(segment.speed_mps, top_mps),
        start_m,
        end_m,
        own_start_m,
        is_jump=segment.jump is True,
        dose=segment.dose if isinstance(segment.dose, float) else 1.0,
        is_backward=segment.backward is True,
    )


def _check_backward(segments: Sequence[Segment], motion: Motion) -> None:
    for number, segment in enumerate(segments, 1):
        if segment.backward is not True:
            continue
        if motion.path_reverse_mps is None:
            raise RouteError("this machine follows no path backwards")
        if segment.tool_on or segment.kind != "turn" or segment.speed_mps > motion.path_reverse_mps + 1e-6:
            raise RouteError(f"segment {number} is driven backwards, with the tool on, too fast, or where no turn is")


def _join(segments: Sequence[Segment]) -> tuple[list[Point], list[tuple[int, int, int]]]:
    """Return all points without repeats; for each segment where the line enters it, its own first and its last."""
    points: list[Point] = []
    bounds: list[tuple[int, int, int]] = []
    for segment in segments:
        entry = max(len(points) - 1, 0)
        own = None
        if points and segment.jump is not True and math.dist(points[-1], segment.points[0]) > MAX_GAP_M:
            raise RouteError(f"segment {len(bounds) + 1} does not begin where the one before it ends")
        for point in segment.points:
            if not points or math.dist(points[-1], point) > SAME_POINT_M:
                points.append(point)
            own = len(points) - 1 if own is None else own
        bounds.append((entry, own or 0, len(points) - 1))
    return points, bounds


def _corners(
    steps: NDArray[np.float64],
    s: NDArray[np.float64],
    back: NDArray[np.bool_],
    declared: Sequence[int],
    motion: Motion,
) -> tuple[list[float], list[float], list[float]]:
    """Return pivots (found and ``declared`` by point index), and places with their speed limit where the line bends.

    ``back``: which steps are driven backwards.
    """
    headings = np.arctan2(steps[:, 1], steps[:, 0]) + np.pi * back
    turns = (np.diff(headings) + np.pi) % (2 * np.pi) - np.pi
    bends = np.abs(turns)
    at = s[1:-1]
    # arcs come as many small bends: what counts is the turn over the length the tracker looks at
    total = np.concatenate(([0.0], np.cumsum(turns)))
    first, last = np.searchsorted(at, at - SMOOTH_M), np.searchsorted(at, at + SMOOTH_M, side="right")
    turned = np.maximum(np.abs(total[last] - total[first]), bends)
    limits = np.maximum(0.85 * motion.yaw_rate_radps * 2 * SMOOTH_M / np.maximum(turned, 1e-9), MIN_CORNER_MPS)
    is_pivot = bends > PIVOT_RAD
    is_pivot[[i - 1 for i in declared if i - 1 < len(bends)]] = True
    is_slow = ~is_pivot & (limits < motion.max_speed_mps)
    return at[is_pivot].tolist(), at[is_slow].tolist(), limits[is_slow].tolist()


def _before(speed_mps: float, distance_m: float, decel_mps2: float) -> float:
    return math.sqrt(speed_mps * speed_mps + 2 * decel_mps2 * max(distance_m, 0.0))

"""An outline or line from walking or driving along it with a receiver."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from shapely.geometry import LineString, Polygon

from hmi.mapping.coordinates import Position
from hmi.mapping.errors import BadWalk
from hmi.mapping.ground import frame_at, line_geometry, polygon_geometry, polygons_in, sound
from hmi.planning.projection import Floats

FASTEST_MPS = 12.0  # a quick tractor; a receiver that jumps is faster
MOST_JUMPS = 5  # after so many "jumps" in a row it was the place before that was wrong
LOST_FACTOR = 4.0  # a point this much worse than the usual one is left out
LEAST_STEP_M, MOST_STEP_M = 0.2, 2.0  # points nearer than the step are one place, weighed by accuracy
LEAST_ACCURACY_M, WORST_ACCURACY_M = 0.01, 100.0  # better is not believed, worse is no position
MOST_TOLERANCE_M = 50.0
LEAST_M2 = 1.0
GAP_S, GAP_M = 5.0, 5.0  # longer without a position nobody knows where the edge went
MISSED_S = 2.0  # receivers tell once a second and miss one now and then: no gap, however fast one drives


@dataclass(frozen=True, slots=True)
class WalkPoint:
    """One position of the receiver.

    Args:
        lon, lat: WGS84 degrees.
        accuracy_m: one standard deviation as the receiver tells.
        at_s: seconds from any start.
    """

    lon: float
    lat: float
    accuracy_m: float
    at_s: float


@dataclass(frozen=True, slots=True)
class Gap:
    """A stretch without usable positions; the outline is straight there.

    Args:
        start, end: the last position before it and the first after it, ``[longitude, latitude]``.
        seconds: how long there was none.
        metres: from start to end.
    """

    start: Position
    end: Position
    seconds: float
    metres: float


@dataclass(frozen=True, slots=True)
class Walked:
    """What the walk comes to.

    Args:
        coordinates: ``[longitude, latitude]``; a closed ring, counter-clockwise, or an open line.
        kept, dropped: points that were used, and jumps, unusable ones and overlap that were not.
        accuracy_m: of the usual point used (median).
        tolerance_m: how far the outline may be from the points: as asked, and never finer than the accuracy.
        gaps: where positions were missing, in the order walked.
    """

    coordinates: list[Position]
    kept: int
    dropped: int
    accuracy_m: float
    tolerance_m: float
    gaps: list[Gap]


def outline(points: Sequence[WalkPoint], is_closed: bool, tolerance_m: float) -> Walked:
    """Return the outline or line walked: without jumps and standing, weighed by accuracy, simplified.

    Raises:
        BadWalk: tolerance out of range, or too few good points for an outline or line.
    """
    if not (math.isfinite(tolerance_m) and 0 < tolerance_m <= MOST_TOLERANCE_M):
        raise BadWalk("bad_tolerance", f"The tolerance must be above 0 and at most {MOST_TOLERANCE_M:g} m.")
    usable = sorted((one for one in points if _is_usable(one)), key=lambda one: one.at_s)
    if len(usable) < 2:
        raise BadWalk("too_few_points", "The receiver gave no usable positions. Wait for a fix and walk again.")
    frame = frame_at((one.lon, one.lat) for one in usable)
    xy = frame.to_local([(one.lon, one.lat) for one in usable])
    accuracy = np.maximum([one.accuracy_m for one in usable], LEAST_ACCURACY_M)
    at_s = np.array([one.at_s for one in usable])
    good = _without_jumps(xy, accuracy, at_s)
    usual_m = float(np.median(accuracy[good]))
    step_m = min(max(usual_m, LEAST_STEP_M), MOST_STEP_M)
    if is_closed:
        good = _without_overlap(xy, good, step_m)
    gaps = [_gap(usable, xy, a, b) for a, b in pairwise(good) if _is_gap(xy, accuracy, at_s, a, b)]
    places = _weighed(xy[good], accuracy[good], step_m)
    tolerance_m = max(tolerance_m, usual_m)
    if is_closed:
        geometry = polygon_geometry(_polygon(places, tolerance_m), frame)
        if geometry is None:
            raise _no_area()
        coordinates = geometry["coordinates"][0]
    else:
        coordinates = line_geometry(_line(places, tolerance_m), frame)["coordinates"]
    return Walked(coordinates, len(good), len(points) - len(good), usual_m, tolerance_m, gaps)


def _is_usable(one: WalkPoint) -> bool:
    return (
        all(map(math.isfinite, (one.lon, one.lat, one.accuracy_m, one.at_s)))
        and abs(one.lon) <= 180
        and abs(one.lat) <= 90
        and 0 < one.accuracy_m <= WORST_ACCURACY_M
    )


def _without_jumps(xy: Floats, accuracy: Floats, at_s: Floats) -> list[int]:
    """Return the numbers of points that one could have got to; points far worse than the usual one go first."""
    candidates = np.flatnonzero(accuracy <= LOST_FACTOR * np.median(accuracy)).tolist()
    runs: list[list[int]] = [[]]
    jumped: list[int] = []
    for n in candidates:
        if runs[-1] and not _can_reach(xy, accuracy, at_s, runs[-1][-1], n):
            is_together = not jumped or _can_reach(xy, accuracy, at_s, jumped[-1], n)
            jumped = [*jumped, n] if is_together else [n]
            if len(jumped) > MOST_JUMPS:
                runs.append(jumped)
                jumped = []
            continue
        jumped = []
        runs[-1].append(n)
    # a first point that was a jump is a run of its own that all others were far from
    longest = max(map(len, runs))
    return [n for run in runs if len(run) > MOST_JUMPS or len(run) == longest for n in run]


def _can_reach(xy: Floats, accuracy: Floats, at_s: Floats, a: int, b: int) -> bool:
    way_m = math.dist(xy[a], xy[b])
    noise_m = 3 * math.hypot(accuracy[a], accuracy[b])
    return way_m <= noise_m + FASTEST_MPS * max(float(at_s[b] - at_s[a]), 0.0)


def _is_gap(xy: Floats, accuracy: Floats, at_s: Floats, a: int, b: int) -> bool:
    missed_s = float(at_s[b] - at_s[a])
    if missed_s > GAP_S:
        return True
    return math.dist(xy[a], xy[b]) > GAP_M and (missed_s > MISSED_S or not _can_reach(xy, accuracy, at_s, a, b))


def _gap(usable: Sequence[WalkPoint], xy: Floats, a: int, b: int) -> Gap:
    start, end = usable[a], usable[b]
    return Gap([start.lon, start.lat], [end.lon, end.lat], end.at_s - start.at_s, math.dist(xy[a], xy[b]))


def _without_overlap(xy: Floats, good: list[int], step_m: float) -> list[int]:
    """Cut off what was walked twice: the end runs on past the start."""
    start = xy[good[0]]
    far = np.hypot(*(xy[good] - start).T)
    if far.max() < 4 * step_m:
        return good
    left = int(np.argmax(far))
    back = left + np.flatnonzero(far[left:] <= 2 * step_m)
    if not len(back):
        return good
    first = back[: 1 + int(np.argmax(np.append(np.diff(back) > 1, True)))]  # the first time around only
    return good[: int(first[np.argmin(far[first])]) + 1]


def _weighed(xy: Floats, accuracy: Floats, step_m: float) -> Floats:
    """Return one place for each stretch shorter than ``step_m``: the mean, better points weighing more."""
    weights = accuracy**-2
    places: list[Floats] = []
    total, weight, anchor = np.zeros(2), 0.0, xy[0]
    for at, w in zip(xy, weights, strict=True):
        if weight and math.dist(at, anchor) >= step_m:
            places.append(total / weight)
            total, weight, anchor = np.zeros(2), 0.0, at
        total, weight = total + at * w, weight + float(w)
    places.append(total / weight)
    return np.array(places)


def _line(places: Floats, tolerance_m: float) -> Floats:
    if len(places) < 2:
        raise BadWalk("too_few_points", "All positions are in one place. Walk along the line.")
    found: Floats = np.array(LineString(places).simplify(tolerance_m, preserve_topology=False).coords)
    return found


def _polygon(places: Floats, tolerance_m: float) -> Polygon:
    if len(places) < 3:
        raise BadWalk("too_few_points", "An outline needs three different places. Walk all around the field.")
    # begin at a corner for sure: the first point stays, however the rest is simplified
    start = int(np.argmax(np.hypot(*(places - places.mean(axis=0)).T)))
    ring = np.roll(places, -start, axis=0)
    corners = LineString([*ring, ring[0]]).simplify(tolerance_m, preserve_topology=False).coords
    if len(corners) < 4:
        raise _no_area()
    polygon = Polygon(corners)
    if not polygon.is_valid:  # a noisy receiver draws small loops
        parts = polygons_in(sound(polygon))
        polygon = Polygon(parts[0].exterior) if parts else Polygon()
    if polygon.area < LEAST_M2:
        raise _no_area()
    return polygon


def _no_area() -> BadWalk:
    return BadWalk("no_area", "The way walked encloses nothing. Walk all around the field, or draw a line.")

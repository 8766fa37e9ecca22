"""Headland passes: closed laps around the field and around every hole, worked like rows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LinearRing, Polygon
from shapely.geometry.base import BaseGeometry

from hmi.planning.bends import SLACK_RAD, turned_beyond
from hmi.planning.dubins import Pose
from hmi.planning.ground import Ground, polygons_of
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import GENTLE_RAD, headings
from hmi.planning.projection import Floats
from hmi.planning.swaths import Swath

_ARC_STEPS = 12  # per quarter circle: 7.5 degrees a piece
_FINE_STEPS = (
    48  # circles that touch, as chords, miss each other by the bulge of a chord: their seam moves by decimetres
)
_BULGE = 0.002  # of the radius: what a chord over 7.5 degrees cuts off
_BULGE_M = 0.003
_KINK_M = 0.05  # where circles touch, growing and shrinking leave corners so far beside the way
_MOST_KINKS = 20
_EVEN_RAD = math.radians(0.5)
_MOST_PLACES = 12  # of a lap where joining it is tried
_NEARLY = 0.99
_LONG_M = 25.0  # pieces longer than this are joined near their ends too


@dataclass(frozen=True, slots=True, eq=False)
class Lap:
    """A closed lap; first and last of the (N, 2) ``points`` are the same. ``offset_m`` from the border.

    ``is_inner``: it goes around a hole, not around the field.
    """

    points: Floats
    offset_m: float
    is_inner: bool = False


@dataclass(frozen=True, slots=True)
class Headland:
    """How the border strip is divided: offsets of the laps, and the depth after which the inner field begins."""

    offsets_m: tuple[float, ...]
    depth_m: float


def divide(machine: RobotProfile, width_m: float, passes: int | None, *, is_wide: bool = False) -> Headland:
    """Choose the laps.

    Args:
        machine: needs room to turn at the end of the rows.
        width_m: working width.
        passes: number of laps; ``None`` takes as many as turning needs.
        is_wide: rows are skipped, and even a machine that could turn on the spot shall turn in an arc.
    """
    first = max(width_m / 2, machine.border_m)
    if passes is None:
        wanted = machine.reach_m + machine.margin_m + _turn_depth(machine, width_m, is_wide=is_wide)
        passes = max(1, math.ceil((wanted - first - width_m / 2) / width_m - 1e-9) + 1)
    offsets = tuple(first + k * width_m for k in range(passes))
    # with few passes the inner field still begins where the machine can turn; the laps then cover less
    depth = max(first + (passes - 0.5) * width_m, machine.reach_m + machine.margin_m + 0.01)
    return Headland(offsets, depth)


def deepened(headland: Headland, width_m: float, passes: int) -> Headland:
    """Return a headland with more laps on its inner side."""
    last = headland.offsets_m[-1]
    more = tuple(last + (k + 1) * width_m for k in range(passes))
    return Headland((*headland.offsets_m, *more), headland.depth_m + passes * width_m)


def _turn_depth(machine: RobotProfile, width_m: float, *, is_wide: bool) -> float:
    """Return how far beyond the row ends a turn into the next row reaches, the border slanting by some 25 degrees.

    A half circle where the rows are two radii apart; nearer than that, a bulb, which a machine that can turn on
    the spot does without, and one that may back up in a turn too.
    """
    is_half_circle = width_m >= 2 * machine.turning_radius_m or (is_wide and machine.can_pivot)
    backs_up = machine.reverse_mps > 0 and not machine.can_pivot
    if is_half_circle or backs_up:
        return machine.turning_radius_m + 0.5 * width_m
    return 0.0 if machine.can_pivot else 3.2 * machine.turning_radius_m


def laps(ground: Ground, headland: Headland) -> list[Lap]:
    """Return the laps that the machine's outline can drive without leaving the ground."""
    radius = max(ground.machine.turning_radius_m, 0.05)
    found: list[Lap] = []
    for offset in headland.offsets_m:
        room = ground.allowed.buffer(-(offset + radius), quad_segs=_FINE_STEPS)
        # one part at a time: parts that meet when grown again would make a lap with a cusp
        for part in polygons_of(room):
            for polygon in polygons_of(part.buffer(radius, quad_segs=_FINE_STEPS)):
                for number, ring in enumerate(_wide(polygon, radius - offset, radius)):
                    points = _clean(shapely.get_coordinates(ring), radius)
                    if len(points) >= 4 and _is_smooth(points) and ground.outside_m(points) == 0.0:
                        found.append(Lap(points, offset, is_inner=number > 0))
    return found


def _wide(polygon: Polygon, lacking_m: float, radius_m: float) -> list[LinearRing]:
    """Return the rings of a lap's ground, the outer one first, bent no tighter than the turning radius.

    Around a corner that juts in, a lap bends with its distance from the border; ``lacking_m`` is what that lacks.
    Around a hole the lap is laid so much wider; the outer one cuts such corners, on the machine's inner side.
    """
    if lacking_m <= 0:
        return [polygon.exterior, *polygon.interiors]
    outer = _rounded(Polygon(polygon.exterior), 0.0, radius_m)
    holes = [_rounded(Polygon(ring), lacking_m, radius_m) for ring in polygon.interiors]
    return [outer.exterior if outer else polygon.exterior, *(hole.exterior for hole in holes if hole)]


def _rounded(area: Polygon, wider_m: float, radius_m: float) -> Polygon | None:
    """Return an area grown by ``wider_m`` with its bays filled and its spikes cut, so that its edge bends gently.

    Growing narrows a bay by as much, and rounds a spike, where two branches of a lap meet, to a curve that is too
    tight but smooth.
    """
    filled = area.buffer(wider_m + radius_m, quad_segs=_FINE_STEPS).buffer(-radius_m, quad_segs=_FINE_STEPS)
    spike_m = _NEARLY * radius_m  # arcs of the radius itself are sampled and must stay
    cut = polygons_of(filled.buffer(-spike_m, quad_segs=_FINE_STEPS).buffer(spike_m, quad_segs=_FINE_STEPS))
    found = cut or polygons_of(filled)
    return found[0] if found else None


def after_rows(
    laps_around: Sequence[Lap], rows: Sequence[Swath], headland: Headland, width_m: float
) -> dict[int, list[Lap]]:
    """Return for each row the laps to drive after it: each lap when the last row that ends at it is done.

    The headland of a hole has no way to the others but across the crop; this saves coming back to it.
    """
    found: dict[int, list[Lap]] = {}
    ends = shapely.points([row.b for row in rows])
    for lap in laps_around:
        ring = shapely.LineString(lap.points)
        near = np.flatnonzero(shapely.distance(ends, ring) <= headland.depth_m - lap.offset_m + width_m)
        if len(near):
            found.setdefault(int(near[-1]), []).append(lap)
    return found


def beginnings(lap: Lap) -> list[Floats]:
    """Return the lap from every place where it is straight enough to swing onto it, in both directions."""
    lengths = np.hypot(*np.diff(lap.points, axis=0).T)
    straight = np.flatnonzero(lengths >= 0.4 * lengths.max())[:_MOST_PLACES]
    places = [(int(k), f) for k in straight for f in ((0.12, 0.5, 0.88) if lengths[k] > _LONG_M else (0.5,))]
    return [_from(lap, edge, share, is_forward=d) for edge, share in places for d in (True, False)]


def entry_cost(here: Pose, line: Floats) -> float:
    """Return how dear it is to come from a pose to the beginning of a line, in metres or so."""
    dx, dy = line[0][0] - here[0], line[0][1] - here[1]
    turn = abs(math.remainder(float(headings(line)[0]) - here[2], 2 * math.pi))
    behind = dx * math.cos(here[2]) + dy * math.sin(here[2]) < 0
    return math.hypot(dx, dy) + 3 * turn + (5 if behind else 0)


def _from(lap: Lap, edge: int, share: float, *, is_forward: bool) -> Floats:
    """Return the lap beginning and ending part way along one of its pieces."""
    ring = lap.points[:-1]
    place = lap.points[edge] + share * (lap.points[edge + 1] - lap.points[edge])
    points = np.vstack([place, np.roll(ring, -(edge + 1), axis=0), place])
    return points if is_forward else points[::-1].copy()


def strips(all_laps: list[Lap], width_m: float) -> list[BaseGeometry]:
    """Return the ground each lap treats."""
    lines = [shapely.LineString(lap.points) for lap in all_laps]
    return list(shapely.buffer(lines, width_m / 2, quad_segs=_ARC_STEPS, cap_style="flat"))


def _is_smooth(points: Floats) -> bool:
    """Say whether a closed lap can be driven without stopping, its closing corner included."""
    directions = headings(np.vstack([points, points[1]]))
    return bool((np.abs(np.angle(np.exp(1j * np.diff(directions)))) <= GENTLE_RAD).all())


def _clean(points: Floats, radius_m: float) -> Floats:
    """Drop points that add nothing: closer than a millimetre, or nearly on the line of their neighbours."""
    line = shapely.simplify(shapely.LineString(points), min(_BULGE * radius_m, _BULGE_M))
    kept = shapely.get_coordinates(line)
    steps = np.hypot(*np.diff(kept, axis=0).T)
    return without_kinks(np.asarray(kept[np.append(True, steps > 1e-3)], dtype=np.float64), radius_m)


def without_kinks(points: Floats, radius_m: float) -> Floats:
    """Straighten a closed (N, 2) ring where it winds by five centimetres and less, tighter than a radius allows.

    Args:
        points: metres; first and last are the same, and of what is returned as well.
    """
    tightest = _tightest_rad(points, radius_m)
    for _ in range(_MOST_KINKS):
        if tightest <= SLACK_RAD:
            break
        found = [(_tightest_rad(one, radius_m), one) for one in _straightened(points, radius_m)]
        best = min(found, key=lambda one: one[0], default=None)
        if best is None or best[0] >= tightest:  # an arc is as tight as it is
            break
        tightest, points = best
    return points


def _tightest_rad(ring: Floats, radius_m: float) -> float:
    excess = (turned_beyond(line, radius_m) for line in _opened(ring))
    return max(float((one - np.minimum.accumulate(one)).max()) for one in excess)


def _straightened(ring: Floats, radius_m: float) -> Iterator[Floats]:
    """Yield the ring without the corners of its tightest stretch, as long as they lie near the line between its ends.

    Arcs of the radius itself before and after are neither tight nor gentle: they are tried as part of it and not.
    """
    for line in _opened(ring):
        excess = turned_beyond(line, radius_m)
        over = excess - np.minimum.accumulate(excess)
        for last in {int(over.argmax()), int(np.flatnonzero(over >= over.max() - _EVEN_RAD)[0])}:
            before = excess[: last + 1]
            for first in {int(before.argmin()), int(np.flatnonzero(before <= before.min() + _EVEN_RAD)[-1])}:
                dropped = line[first + 1 : last + 1]
                if not 0 < len(dropped) <= len(ring) - 4:
                    continue
                chord = shapely.LineString(line[[first, last + 1]])
                if shapely.distance(shapely.points(dropped), chord).max() <= _KINK_M:
                    rest = np.roll(line[:-2], -first, axis=0)
                    yield np.vstack([rest[:1], rest[1 + len(dropped) :], rest[:1]])


def _opened(ring: Floats) -> Iterator[Floats]:
    """Yield a closed ring as lines that begin at opposite places, the closing corner included."""
    for shift in (0, len(ring) // 2):
        begun = np.roll(ring[:-1], -shift, axis=0)
        yield np.vstack([begun, begun[:2]])

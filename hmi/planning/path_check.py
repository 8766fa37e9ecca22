"""The rules that every plan keeps, asked of a path that somebody else planned.

Our own plans keep them with room to spare: ``tests/hmi/planning`` asks the same questions more sharply. The slack
here is for coordinates told in millimetres.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from hmi.domain.mission_plan import PathUnfit
from hmi.planning.figures import GRID_M, worked_strips
from hmi.planning.ground import CHECK_STEP_M, erode
from hmi.planning.job import Job
from hmi.planning.plan import GENTLE_RAD, Leg, LegKind, is_cusp, poses_along, turn_between
from hmi.planning.projection import Floats

SLACK_M = 0.02  # millimetres told, centimetres known; the machine's own margin is wider
SLACK_RAD = math.radians(4)  # half a piece of an arc that is sampled each 8 degrees
SAME_M = 0.05  # millimetres told over less than this make degrees of direction
CHORD = 0.15  # of the radius: an arc that is sampled each 8 degrees has no longer ones
CUT_RAD = math.radians(0.5)
HOME_M = 0.5
GAP_M = 0.04  # hairline gaps between road and field, as our own plans close them
TWICE = 0.02  # share of the rows' ground that may lie under two rows
MOST_OUTLINES = 500_000
WORK = (LegKind.ROW, LegKind.HEADLAND)


def check_path(job: Job, field: BaseGeometry, legs: Sequence[Leg]) -> None:
    """Return if the machine may drive this path over ``field``, the ground of the job.

    Raises:
        PathUnfit: it may not; says why.
    """
    _one_line(legs)
    _steerable(job, legs)
    _speeds(job, legs)
    _order(legs)
    _home(job, legs)
    _inside(job, field, legs)
    _tool(job, field, legs)
    _once(job, legs)


def _one_line(legs: Sequence[Leg]) -> None:
    gap = max((math.dist(a.points[-1], b.points[0]) for a, b in pairwise(legs)), default=0.0)
    if gap > SLACK_M:
        raise PathUnfit("gap", f"It has a gap of {gap:.2f} m.")


def _steerable(job: Job, legs: Sequence[Leg]) -> None:
    machine = job.machine
    if not machine.can_pivot and any(leg.pivot for leg in legs[1:]):
        raise PathUnfit("pivot", "It turns on the spot, which this robot cannot.")
    _backwards(job, legs)
    most = max((abs(turn_between(a, b)) for a, b in pairwise(legs) if not b.pivot), default=0.0)
    pieces = _drives(legs)
    most = max([most, *(_sharpest(points) for points in pieces)])
    if most > GENTLE_RAD + SLACK_RAD:
        raise PathUnfit("corner", f"It has a corner of {math.degrees(most):.0f} degrees where the robot drives on.")
    excess = max(_bend_excess(points, machine.turning_radius_m) for points in pieces)
    if excess > SLACK_RAD:
        raise PathUnfit("bend", f"It bends tighter than the robot's turning radius of {machine.turning_radius_m:g} m.")


def _backwards(job: Job, legs: Sequence[Leg]) -> None:
    backward = [leg for leg in legs if leg.is_backward]
    if backward and job.machine.reverse_mps <= 0:
        raise PathUnfit("backward", "It drives backwards, which this robot does on no path.")
    if any(leg.kind is not LegKind.TURN or leg.tool_on for leg in backward):
        raise PathUnfit("backward", "It drives backwards where no turn is, or with the tool on.")
    if any(leg.is_backward for leg in (legs[0], legs[-1])):
        raise PathUnfit("backward", "It begins or ends backwards.")


def _drives(legs: Sequence[Leg]) -> list[Floats]:
    """Return the path in pieces as they are driven without a stop to turn, corners some centimetres apart."""
    pieces: list[list[Floats]] = []
    for number, leg in enumerate(legs):
        if not pieces or leg.pivot or is_cusp(legs[number - 1], leg):
            pieces.append([leg.points])
        else:
            pieces[-1].append(leg.points[1:])
    return [_thinned(np.vstack(parts)) for parts in pieces]


def _thinned(points: Floats) -> Floats:
    """Return a polyline without corners nearer than ``SAME_M`` to the one before; its ends stay."""
    if np.hypot(*np.diff(points, axis=0).T).min() >= SAME_M:
        return points
    kept = [0]
    for number, (x, y) in enumerate(points.tolist()):
        if math.dist(points[kept[-1]], (x, y)) >= SAME_M:
            kept.append(number)
    last = len(points) - 1
    if kept[-1] != last:
        kept = [*kept[: max(1, len(kept) - 1)], last]
    return points[kept]


def _turns(points: Floats) -> Floats:
    steps = np.diff(points, axis=0)
    angles = np.diff(np.arctan2(steps[:, 1], steps[:, 0]))
    return np.asarray(np.abs(np.angle(np.exp(1j * angles))), dtype=np.float64)


def _sharpest(points: Floats) -> float:
    return float(_turns(points).max(initial=0.0))


def _bend_excess(points: Floats, radius_m: float) -> float:
    """Return by how much the path turns, over any stretch of it, more than its radius allows; radians."""
    if len(points) < 3 or radius_m <= 0:
        return 0.0
    points = _whole_chords(points, CHORD * radius_m)
    lengths = np.hypot(*np.diff(points, axis=0).T)
    middles = np.cumsum(lengths) - lengths / 2
    excess = np.append(0.0, np.cumsum(_turns(points))) - middles / radius_m
    return float((excess - np.minimum.accumulate(excess)).max())


def _whole_chords(points: Floats, most_m: float) -> Floats:
    """Return a polyline without the places where a border cut a chord of an arc: half of one allows half its turn."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    is_cut = (_turns(points) < CUT_RAD) & (lengths[:-1] + lengths[1:] <= most_m)
    kept: Floats = points[np.concatenate([[True], ~is_cut, [True]])]
    return kept


def _speeds(job: Job, legs: Sequence[Leg]) -> None:
    machine = job.machine
    in_bends = min(machine.transit_speed_mps, machine.yaw_rate_radps * machine.turning_radius_m)
    bent = max(machine.turn_speed_mps, machine.way_mps, in_bends, machine.reverse_mps)
    straight = max(bent, machine.transit_speed_mps)
    for leg in legs:
        most = machine.reverse_mps if leg.is_backward else straight if len(leg.points) == 2 else min(straight, bent)
        if leg.tool_on:
            most = machine.row_speed_mps / max(1.0, leg.dose)
        elif leg.kind in WORK:
            most = max(most, machine.row_speed_mps)
        if leg.speed_mps > most * 1.001 + 1e-3:
            raise PathUnfit("speed", f"It drives {leg.speed_mps:.2f} m/s where {most:.2f} m/s is the most.")


def _order(legs: Sequence[Leg]) -> None:
    """Rows are counted as driven, ways from and to home lie at the ends, and the tool works on rows and laps only."""
    row = 0
    for number, leg in enumerate(legs):
        is_new = leg.kind is LegKind.ROW and not leg.is_continued
        row += is_new
        if leg.row != (row if leg.kind is LegKind.ROW else 0) or (leg.kind is LegKind.ROW and row == 0):
            raise PathUnfit("rows", f"Its rows are not counted as they are driven (piece {number + 1}).")
        if leg.tool_on and leg.kind not in WORK:
            raise PathUnfit("tool", "The tool is on where no row and no lap is.")
    kinds = [leg.kind for leg in legs]
    first = next((k for k, kind in enumerate(kinds) if kind is not LegKind.APPROACH), len(kinds))
    last = next((k for k in range(len(kinds), 0, -1) if kinds[k - 1] is not LegKind.EXIT), 0)
    if {LegKind.APPROACH, LegKind.EXIT} & set(kinds[first:last]) or row == 0:
        raise PathUnfit("rows", "It has no row, or a way home in the middle.")


def _home(job: Job, legs: Sequence[Leg]) -> None:
    ends = [(leg, point) for leg, point in ((legs[0], legs[0].points[0]), (legs[-1], legs[-1].points[-1]))]
    for leg, point in ends:
        if leg.kind not in (LegKind.APPROACH, LegKind.EXIT):
            continue
        if job.home is None or math.dist(job.home, point) > HOME_M:
            raise PathUnfit("home", "Its way home does not lead to the robot's home.")
    if job.home is not None and math.dist(job.home, legs[0].points[0]) > HOME_M:
        raise PathUnfit("home", "It does not begin at the robot's home.")
    if legs[-1].kind is LegKind.EXIT and not job.returns_home:
        raise PathUnfit("home", "It drives home, which was not asked for.")


def _inside(job: Job, field: BaseGeometry, legs: Sequence[Leg]) -> None:
    """The outline stays on the field, and on roads and yards on the way from and to home."""
    ways = (LegKind.APPROACH, LegKind.EXIT)
    at_work = [leg for leg in legs if leg.kind not in ways]
    on_way = [leg for leg in legs if leg.kind in ways]
    _stays(job, field, at_work, [leg for leg in at_work[1:] if leg.pivot], "the field")
    if on_way:
        together = field if job.roads is None else shapely.union_all([field, job.roads])
        closed = together.buffer(GAP_M, join_style="mitre").buffer(-GAP_M, join_style="mitre")
        pivots = [leg for leg in [*on_way, at_work[0]] if leg.pivot and leg is not legs[0]]
        _stays(job, closed, on_way, pivots, "the field and its roads")


def _stays(job: Job, ground: BaseGeometry, legs: Sequence[Leg], pivots: Sequence[Leg], name: str) -> None:
    machine, allowed = job.machine, ground.buffer(SLACK_M, join_style="mitre")
    pieces = np.concatenate([_pieces_nose_first(leg) for leg in legs])
    far_inside = erode(allowed, machine.reach_m)  # there the outline fits at any heading
    for area in (allowed, far_inside):
        shapely.prepare(area)
    near = pieces[~shapely.covers(far_inside, shapely.linestrings(pieces))]
    length_m = float(np.hypot(*(near[:, 1] - near[:, 0]).T).sum()) if len(near) else 0.0
    if length_m / CHECK_STEP_M + len(near) > MOST_OUTLINES:
        raise PathUnfit("size", "It is too long near the border to be checked.")
    if len(near):
        outlines = machine.outline_polygons(np.concatenate([poses_along(piece, CHECK_STEP_M) for piece in near]))
        outside = float((~shapely.covers(allowed, outlines)).sum()) * CHECK_STEP_M
        if outside > 0:
            raise PathUnfit("outside", f"The robot's outline would leave {name} over {outside:.1f} m.")
    spots = shapely.points([leg.points[0] for leg in pivots]) if pivots else np.array([])
    if len(pivots) and not shapely.covers(far_inside, spots).all():
        # the eroded ground gives up a little at corners; the circle itself decides, for which way round is not told
        circles = shapely.buffer(spots, machine.reach_m, quad_segs=32)
        swings_out = ~shapely.covers(allowed, circles)
        if swings_out.any():
            first = int(swings_out.argmax())
            raise PathUnfit("outside", _swing(job, allowed, pivots[first], name))


def _swing(job: Job, allowed: BaseGeometry, pivot: Leg, name: str) -> str:
    """Say where and how far the outline leaves the ground when it turns on the spot."""
    reach_m, spot = job.machine.reach_m, shapely.Point(pivot.points[0])
    out_m = reach_m - (spot.distance(allowed.boundary) if allowed.covers(spot) else 0.0)
    is_in_field = shapely.Polygon(job.parcel.exterior).buffer(SLACK_M).covers(spot.buffer(reach_m, quad_segs=32))
    what = f"swing into a hole of {name} or an obstacle" if is_in_field else f"leave {name}"
    kinds = {
        LegKind.ROW: f"before row {pivot.row}",
        LegKind.HEADLAND: "on a headland lap",
        LegKind.TURN: "between rows",
    }
    x, y = pivot.points[0]
    where = f"{kinds.get(pivot.kind, 'on the way from or to home')}, {x:.1f} m east and {y:.1f} m north of the origin"
    return f"The robot's outline would {what} by {out_m:.2f} m where it turns on the spot {where}."


def _pieces_nose_first(leg: Leg) -> Floats:
    """Return the (N, 2, 2) pieces of a leg, each in the direction in which the machine looks."""
    ends = (leg.points[1:], leg.points[:-1]) if leg.is_backward else (leg.points[:-1], leg.points[1:])
    return np.stack(ends, axis=1)


def _tool(job: Job, field: BaseGeometry, legs: Sequence[Leg]) -> None:
    """The tool is on, and gives its dose, where the treatment says so."""
    doses = job.doses
    working = [leg for leg in legs if leg.tool_on]
    if doses.is_plain:
        if any(leg.dose != 1.0 for leg in working):
            raise PathUnfit("dose", "It has doses that were not asked for.")
        return
    slack = max(doses.lead_in_m, doses.lead_out_m) + 0.5 * (doses.lead_in_m + doses.lead_out_m) + 0.25
    for dose in {leg.dose for leg in working}:
        zone = doses.zone(field, dose).buffer(slack)
        shapely.prepare(zone)
        lines = [shapely.LineString(leg.points) for leg in working if leg.dose == dose]
        if not shapely.covers(zone, lines).all():
            raise PathUnfit("dose", f"The tool works at {dose:g} times the usual dose where that was not asked for.")


def _once(job: Job, legs: Sequence[Leg]) -> None:
    rows = worked_strips([leg for leg in legs if leg.kind is LegKind.ROW], job.width_m)
    if not rows:
        raise PathUnfit("rows", "The tool is on in no row.")
    together = float(shapely.union_all(rows, grid_size=GRID_M).area)
    twice = float(shapely.area(rows).sum()) / together - 1
    if twice > TWICE:
        raise PathUnfit("twice", f"Its rows work {twice:.0%} of their ground twice.")

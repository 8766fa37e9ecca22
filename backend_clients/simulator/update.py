"""A mission that goes on with another one: what a robot keeps, and when it refuses.

VDA 5050 calls this an order update: what is released stays, the update joins at its last node, and one that comes
too late changes nothing. Here the path that stays stands in the document itself, so the robot can compare it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from msgspec.structs import replace

from backend_clients.edge.messages_down import Continues, Mission, Segment
from backend_clients.simulator.mission_run import MissionRun
from backend_clients.simulator.route import Point, RouteError
from backend_clients.simulator.verdict import OK, Verdict, refused

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain

SAME_M = 0.02  # a stitch point comes from a report in centimetres
KNOWN_M = 0.05  # how exactly a mission taken up again must begin where the robot left off
AHEAD_M = 2.0  # more than braking takes: a running robot must not reach the stitch point while it changes over
REACH_M = 2.0  # so near it may drive straight to the beginning of a planned way
JUST_PAST_M = 1e-5  # so that the joint before it is not looked at again


def continued(brain: Brain, order: Mission, continues: Continues) -> Verdict:
    """Take the mission if it keeps what was driven; change nothing otherwise."""
    try:
        fresh = MissionRun(order, brain.frame, (brain.config.x_m, brain.config.y_m), brain.profile)
    except RouteError as error:
        return refused("bad_mission", f"The path of this mission cannot be driven: {error}.")
    if continues.segments >= len(order.segments):
        return refused("not_an_update", "This document has nothing after the path that stays.")
    stitch_m = fresh.route.legs[continues.segments - 1].end_m if continues.segments else 0.0
    after = fresh.route.legs[continues.segments]
    run = brain.run
    if run is not None and run.sha256 == continues.base_sha256:
        verdict = _same(run, order, continues.segments)
        if not verdict.is_accepted:
            return verdict
        if after.is_jump and not _is_known(run, order, continues.segments):
            return _taken_up(brain, fresh, run, stitch_m, after.own_start_m)
        return _changed(brain, fresh, run, after.drive_from_m)
    if run is not None and run.is_open:
        return refused("mission_active")
    if not after.is_jump or (run is not None and run.mission.mission_id == order.mission_id):
        return refused("not_an_update")
    return _taken_up(brain, fresh, None, stitch_m, after.own_start_m)


def _same(run: MissionRun, order: Mission, kept: int) -> Verdict:
    """Compare the path that stays with what the robot has."""
    base = run.mission
    if order.mission_id != base.mission_id or order.revision <= base.revision or order.datum != base.datum:
        return refused("not_an_update")
    if kept > len(base.segments) or (kept and list(order.segments[: kept - 1]) != list(base.segments[: kept - 1])):
        return refused("not_an_update")
    if kept and not _begins(order.segments[kept - 1], base.segments[kept - 1]):
        return refused("not_an_update")
    return OK


def _is_known(run: MissionRun, order: Mission, number: int) -> bool:
    """Say whether the robot is on the way back of that jump already."""
    base = run.mission.segments
    return (
        number < len(base) and base[number].jump is True and base[number].points[0] == order.segments[number].points[0]
    )


def _begins(part: Segment, whole: Segment) -> bool:
    """Say whether ``part`` is the beginning of ``whole``, or all of it."""
    if replace(part, points=whole.points) != whole:
        return False
    shared = len(part.points) - 1
    if list(part.points[:shared]) != list(whole.points[:shared]):
        return False
    if shared >= len(whole.points):
        return False
    return _distance(part.points[shared], whole.points[shared - 1], whole.points[shared]) < SAME_M


def _distance(point: Point, a: Point, b: Point) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    length2 = dx * dx + dy * dy
    t = 0.0 if length2 == 0 else ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / length2
    t = min(max(t, 0.0), 1.0)
    return math.dist(point, (a[0] + t * dx, a[1] + t * dy))


def _changed(brain: Brain, fresh: MissionRun, run: MissionRun, stitch_m: float) -> Verdict:
    """Take a new rest from a place ahead; the robot runs, or stands, on as before."""
    if not run.is_open:
        return refused("not_an_update", "The mission on the robot has ended. Plan the way back, or start fresh.")
    ahead_m = stitch_m - run.tracker.s_m
    if ahead_m < (AHEAD_M if run.status == "running" else -SAME_M):
        return refused("update_too_late")
    fresh.take_over(run, min(run.tracker.s_m, stitch_m))
    brain.renew(fresh)
    return OK


def _taken_up(brain: Brain, fresh: MissionRun, run: MissionRun | None, stitch_m: float, begin_m: float) -> Verdict:
    """Take a mission up again from elsewhere: paused, before the way to where it was interrupted."""
    if brain.is_auto:
        return refused("mission_active")
    if not brain.machine.base.is_still:
        return refused("not_standing")
    if run is not None and run.tracker.s_m > stitch_m + KNOWN_M:
        return refused("update_too_late")
    if run is not None and run.tracker.s_m < stitch_m - KNOWN_M:
        return refused("not_an_update", "The robot has not come as far as this document says. Look at it again.")
    if math.dist(brain.place, fresh.route.point_at(begin_m)) > REACH_M:
        return refused("not_where_planned")
    if run is not None:
        fresh.take_over(run, begin_m)
    else:
        fresh.count_done(stitch_m)
    fresh.stand_at(begin_m + JUST_PAST_M, brain.place)
    brain.renew(fresh)
    return OK

"""Turns from one piece of work to the next: driven on in one go, or in pieces to and fro where that is quicker.

A machine that says it may follows a path backwards in a turn, and nowhere else: its tool is off there, and it stays
on the field.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hmi.planning import reeds_shepp
from hmi.planning.dubins import Pose
from hmi.planning.estimate import effort
from hmi.planning.links import Linker
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import GENTLE_RAD, Drive, Leg, LegKind
from hmi.planning.projection import Floats
from hmi.planning.reeds_shepp import ReedsSheppPath

LONG_WAY_M = 10.0
"""Ways longer than this are driven at transit speed."""
MOST_CUSPS = 2
"""A turn in three points; with more the soil is churned for a metre or two less of headland."""
LEAST_DRIVE_M = 0.5  # a shorter push forth or back is not worth the stop
_STEP_M = 2.0


class Turns:
    """Finds turns on one ground for its machine."""

    def __init__(self, linker: Linker) -> None:
        self._linker = linker
        self._machine = linker.machine

    def between(self, start: Pose, end: Pose, slow_mps: float) -> list[Leg] | None:
        """Return legs from start to end, ``None`` if there is no way; a gap in heading is a turn on the spot.

        Args:
            slow_mps: speed of short ways.
        """
        pieces = self._linker.link(start, end)
        if pieces == [] or self._machine.reverse_mps <= 0:
            return None if pieces is None else self._forwards(pieces, slow_mps)
        forwards = None if pieces is None else self._forwards(pieces, slow_mps)
        return self._to_and_fro(start, end, math.inf if forwards is None else self._time_s(forwards)) or forwards

    def _forwards(self, pieces: list[Floats], slow_mps: float) -> list[Leg]:
        return [Leg(LegKind.TURN, piece, way_speed(piece, self._machine, slow_mps)) for piece in pieces]

    def _to_and_fro(self, start: Pose, end: Pose, limit_s: float) -> list[Leg] | None:
        """Return the quickest turn in pieces that is quicker than ``limit_s`` and stays on the ground."""
        speed = max(self._machine.turn_speed_mps, self._machine.reverse_mps)
        hopeful = []
        for drives in self._paths(start, end):
            if sum(drive.length_m for drive in drives) / speed >= limit_s:
                continue
            legs = [self._leg(drive) for drive in drives]
            time_s = self._time_s(legs)
            if time_s < limit_s:
                hopeful.append((time_s, legs))
        for _, legs in sorted(hopeful, key=lambda one: one[0]):
            if all(self._fits(leg) for leg in legs):
                return legs
        return None

    def _paths(self, start: Pose, end: Pose) -> Iterator[list[Drive]]:
        """Yield turns in pieces, also such as begin after rolling out level with the row that follows."""
        radius = max(self._machine.turning_radius_m, 0.05)
        for out_m, from_pose, back_m, to_pose in _level(start, end):
            for path in reeds_shepp.candidates(from_pose, to_pose, radius):
                if _is_sensible(path):
                    yield _rolled(path.drives(_STEP_M), out_m, start, back_m, end)

    def _leg(self, drive: Drive) -> Leg:
        machine = self._machine
        speed = machine.reverse_mps if drive.is_backward else max(machine.turn_speed_mps, machine.reverse_mps)
        return Leg(LegKind.TURN, drive.points, speed, is_backward=drive.is_backward)

    def _fits(self, leg: Leg) -> bool:
        return self._linker.ground.fits(leg.points, is_crop_free=True, is_backward=leg.is_backward)

    def _time_s(self, legs: list[Leg]) -> float:
        return effort(legs, self._machine).duration_s


def way_speed(points: Floats, machine: RobotProfile, slow_mps: float) -> float:
    """Return the speed of a way: long ones go at transit speed, as far as their bends allow."""
    length = float(np.hypot(*np.diff(points, axis=0).T).sum())
    if length < LONG_WAY_M:
        return slow_mps
    bend_mps = machine.transit_speed_mps if len(points) == 2 else machine.yaw_rate_radps * machine.turning_radius_m
    return max(slow_mps, min(machine.transit_speed_mps, bend_mps))


def _is_sensible(path: ReedsSheppPath) -> bool:
    drives = path.drives_m
    if not 2 <= len(drives) <= MOST_CUSPS + 1:
        return False
    # it leaves a row and comes to the next one with its nose ahead: the tool's lead-in is driven forwards
    return drives[0] > 0 and drives[-1] > 0 and min(map(abs, drives)) >= LEAST_DRIVE_M


def _level(start: Pose, end: Pose) -> Iterator[tuple[float, Pose, float, Pose]]:
    """Yield how far to roll out and in, and the poses between; as they stand, and for rows that run back also level."""
    yield 0.0, start, 0.0, end
    if abs(math.remainder(end[2] + math.pi - start[2], 2 * math.pi)) > GENTLE_RAD:
        return
    ahead = (end[0] - start[0]) * math.cos(start[2]) + (end[1] - start[1]) * math.sin(start[2])
    out, back = max(ahead, 0.0), max(-ahead, 0.0)
    if abs(ahead) >= 0.05:
        yield out, _moved(start, out), back, _moved(end, -back)


def _moved(pose: Pose, metres: float) -> Pose:
    return pose[0] + metres * math.cos(pose[2]), pose[1] + metres * math.sin(pose[2]), pose[2]


def _rolled(drives: list[Drive], out_m: float, start: Pose, back_m: float, end: Pose) -> list[Drive]:
    """Return the drives with the straight pieces before and after them."""
    if out_m > 0:
        drives[0] = replace(drives[0], points=np.vstack([start[:2], drives[0].points]))
    if back_m > 0:
        drives[-1] = replace(drives[-1], points=np.vstack([drives[-1].points, end[:2]]))
    return drives

"""Time, energy and area of a path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from hmi.planning.machine import RobotProfile
from hmi.planning.plan import Leg, LegKind, is_cusp, turn_between

CUSP_S = 2.0
"""Seconds a machine stands to drive the other way: it comes to rest, and its drive is engaged anew."""


@dataclass(frozen=True, slots=True)
class Effort:
    """What driving a path takes, SI."""

    length_m: float
    working_length_m: float
    duration_s: float
    working_s: float
    turns: int
    pivots: int
    energy_j: float
    reversals: int = 0


def effort(legs: Sequence[Leg], machine: RobotProfile) -> Effort:
    """Add up a path: speeds change no faster than the machine accelerates; it stops to pivot and to turn back."""
    lengths = [leg.length_m for leg in legs]
    times = [*_times(legs, lengths, machine)]
    pivoting = [abs(turn_between(a, b)) for a, b in pairwise(legs) if b.pivot]
    reversals = sum(is_cusp(a, b) for a, b in pairwise(legs))
    duration = sum(times) + sum(pivot_time(angle, machine) for angle in pivoting) + reversals * CUSP_S
    working = sum(t for t, leg in zip(times, legs, strict=True) if leg.tool_on)
    # a lower dose takes less power; a higher one takes more time, and so the legs are slower
    dosed = sum(t * min(leg.dose, 1.0) for t, leg in zip(times, legs, strict=True) if leg.tool_on)
    length, energy = sum(lengths), machine.energy
    return Effort(
        length_m=length,
        working_length_m=sum(m for m, leg in zip(lengths, legs, strict=True) if leg.tool_on),
        duration_s=duration,
        working_s=working,
        turns=_turns(legs),
        pivots=len(pivoting),
        energy_j=length * energy.drive_j_per_m + duration * energy.idle_w + dosed * energy.tool_w,
        reversals=reversals,
    )


def timeline(legs: Sequence[Leg], machine: RobotProfile) -> list[tuple[float, float]]:
    """Return when each leg begins and ends, seconds from the start; a turn on the spot or stop lies before its leg."""
    times = _times(legs, [leg.length_m for leg in legs], machine)
    found: list[tuple[float, float]] = []
    now = 0.0
    for number, (leg, time) in enumerate(zip(legs, times, strict=True)):
        if leg.pivot and number > 0:
            now += pivot_time(turn_between(legs[number - 1], leg), machine)
        if number > 0 and is_cusp(legs[number - 1], leg):
            now += CUSP_S
        found.append((now, now + time))
        now += time
    return found


def pivot_time(angle_rad: float, machine: RobotProfile) -> float:
    """Return the seconds of a turn on the spot, yaw ramped up and down within half a second each."""
    rate = max(machine.yaw_rate_radps, 0.05)
    return abs(angle_rad) / rate + 0.5


def _turns(legs: Sequence[Leg]) -> int:
    """Count changes from one row or lap to the next."""
    work = sum(leg.kind in (LegKind.ROW, LegKind.HEADLAND) and not leg.is_continued for leg in legs)
    return max(0, work - 1)


def _times(legs: Sequence[Leg], lengths: Sequence[float], machine: RobotProfile) -> list[float]:
    """Return the seconds of each leg, from a forward and a backward pass over the speeds at its ends."""
    accel = machine.accel_mps2
    n = len(legs)
    joints = [0.0] * (n + 1)
    for k in range(1, n):
        is_stop = legs[k].pivot or is_cusp(legs[k - 1], legs[k])
        joints[k] = 0.0 if is_stop else min(legs[k - 1].speed_mps, legs[k].speed_mps)
    for k in range(n):
        joints[k + 1] = min(joints[k + 1], math.sqrt(joints[k] ** 2 + 2 * accel * lengths[k]))
    for k in range(n - 1, -1, -1):
        joints[k] = min(joints[k], math.sqrt(joints[k + 1] ** 2 + 2 * accel * lengths[k]))
    return [
        _time(length, joints[k], joints[k + 1], leg.speed_mps, accel) + leg.tool_on * length * machine.stand_s_per_m
        for k, (leg, length) in enumerate(zip(legs, lengths, strict=True))
    ]


def _time(length_m: float, v0: float, v1: float, top: float, accel: float) -> float:
    """Return the seconds to drive a length from speed v0 to v1, never above ``top``."""
    peak = min(top, math.sqrt(max(0.0, (2 * accel * length_m + v0 * v0 + v1 * v1) / 2)))
    peak = max(peak, v0, v1)
    ramps = (2 * peak * peak - v0 * v0 - v1 * v1) / (2 * accel)
    return (2 * peak - v0 - v1) / accel + max(0.0, length_m - ramps) / peak if peak > 0 else 0.0

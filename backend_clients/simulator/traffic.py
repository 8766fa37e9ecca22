"""Machines that share the ground: each sees what stands before it and waits; nobody drives round another by itself."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable
from dataclasses import dataclass

from backend_clients.simulator.enu import EnuFrame, Point
from backend_clients.simulator.kinematics import wrap_rad
from backend_clients.simulator.machine import Neighbour
from backend_clients.simulator.world import SimRobot
from hmi.clock import Clock

LOOK_EVERY_S = 0.25  # at 1.7 m/s that is 0.4 m, a tenth of the protective field
SIDE_M = 0.3  # of free ground beside the machine
LARGE_M = 2.0  # a machine is seen from farther than a person: there has to be room to pass it
FREE_AGAIN_M = 1.5  # more than the protective field, so that it does not start and stop by turns
NEAR_M = 20.0  # farther machines are not looked at
PASSED_M, BESIDE_M = 4.0, 15.0  # behind it, and the line is its own again; so far apart, and both see each other again
OVERLAP_M = 1.0  # so near two middles are in one place: they can only drive apart
IN_BAY_M = 1.5  # so near to where it is at home it stands in its bay, and bays are off the way
WALK_S = (45.0, 120.0)  # until somebody of the farm is there and leads it past
EDGE = [(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)]


@dataclass(slots=True)
class _Member:
    """One machine on the ground; ``shift`` is its frame against the common one, metres east and north."""

    robot: SimRobot
    shift: Point
    waits_until_s: float | None = None

    @property
    def place(self) -> tuple[float, float, float]:
        base = self.robot.machine.base
        return base.x_m + self.shift[0], base.y_m + self.shift[1], base.theta_rad

    @property
    def is_parked(self) -> bool:
        """Whether it stands in its own bay with nothing to do."""
        base, config, boot = self.robot.machine.base, self.robot.config, self.robot.boot
        is_at_home = math.dist((base.x_m, base.y_m), (config.x_m, config.y_m)) < IN_BAY_M
        return is_at_home and (boot is None or not boot.brain.is_auto)


class Traffic:
    """Tells machines what stands before them; what flies and lean robots are left out.

    Two that stand before each other would wait for ever: after a while somebody of the farm comes and leads one past.

    Args:
        robots: all robots of the world.
    """

    def __init__(self, robots: Iterable[SimRobot], clock: Clock, *, seed: int = 1) -> None:
        on_ground = [one for one in robots if not one.config.is_lean and not one.config.profile.motion.is_on_rails]
        self._members = [_Member(one, _shift(one, on_ground[0])) for one in on_ground]
        self._clock, self._rng = clock, random.Random(f"traffic/{seed}")  # noqa: S311
        self._looked_s = -math.inf
        self._led: dict[str, str] = {}  # who is led past whom, by id

    def look(self) -> None:
        """Look around from each machine; call it as often as you like."""
        now_s = self._clock.mono_s()
        if now_s - self._looked_s < LOOK_EVERY_S:
            return
        self._looked_s = now_s
        self._led = {one: other for one, other in self._led.items() if self._is_before(one, other)}
        for one in self._members:
            one.robot.machine.neighbour = self._before(one)
            self._lead_past(one, now_s)

    def _before(self, one: _Member) -> Neighbour | None:
        """Return who stands in its protective field, the nearest of several."""
        machine = one.robot.machine
        reach_m = (
            machine.profile.protective_field_m + LARGE_M + (FREE_AGAIN_M if machine.neighbour is not None else 0.0)
        )
        seen = [(free_m, other) for other in self._members if (free_m := self._free_m(one, other)) < reach_m]
        if not seen:
            return None
        free_m, other = min(seen, key=lambda pair: pair[0])
        return Neighbour(other.robot.config.id, other.robot.config.name, free_m)

    def _free_m(self, one: _Member, other: _Member) -> float:
        """Return the free ground between the front of ``one`` and ``other``, infinite if that is not before it."""
        x, y, theta = one.place
        ox, oy, other_theta = other.place
        apart_m = math.hypot(ox - x, oy - y)
        if other is one or not OVERLAP_M < apart_m < NEAR_M or self._is_led(one, other) or other.is_parked:
            return math.inf
        own, its = one.robot.machine.profile.dimensions, other.robot.machine.profile.dimensions
        turn, along, side = wrap_rad(other_theta - theta), *_seen_from(x, y, theta, ox, oy)
        middle = its.base_to_front_m - its.length_m / 2
        cos, sin = math.cos(turn), math.sin(turn)
        free_m = math.inf
        for ex, ey in EDGE:
            bx, by = middle + ex * its.length_m / 2, ey * its.width_m / 2
            ahead_m, beside_m = along + bx * cos - by * sin, side + bx * sin + by * cos
            if ahead_m > own.base_to_front_m and abs(beside_m) < own.width_m / 2 + SIDE_M:
                free_m = min(free_m, ahead_m - own.base_to_front_m)
        return free_m

    def _lead_past(self, one: _Member, now_s: float) -> None:
        neighbour, boot = one.robot.machine.neighbour, one.robot.boot
        if neighbour is None or boot is None or boot.brain.hold_code != "robot_ahead" or boot.brain.drive is not None:
            one.waits_until_s = None
            return
        if one.waits_until_s is None:
            one.waits_until_s = now_s + self._rng.uniform(*WALK_S)
        elif now_s >= one.waits_until_s:
            one.waits_until_s = None
            self._led[one.robot.config.id] = neighbour.id
            one.robot.machine.neighbour = None
            one.robot.machine.aside_m = _aside_m(one, self._member(neighbour.id))
            boot.brain.note("mission", "Led past", f"Somebody of the farm led it past {neighbour.name}.")

    def _is_led(self, one: _Member, other: _Member) -> bool:
        """Whoever is led past another does not wait for it; that one waits until its way is free."""
        return self._led.get(one.robot.config.id) == other.robot.config.id

    def _member(self, robot_id: str) -> _Member:
        return next(one for one in self._members if one.robot.config.id == robot_id)

    def _is_before(self, one_id: str, other_id: str) -> bool:
        """Say whether who is led still has the other near; behind it, its line is its own again."""
        one, other = self._member(one_id), self._member(other_id)
        along_m, beside_m = _seen_from(*one.place, *other.place[:2])
        is_near = math.hypot(along_m, beside_m) < BESIDE_M
        if along_m < -PASSED_M or not is_near:
            one.robot.machine.aside_m = 0.0
        return is_near


def _aside_m(one: _Member, other: _Member) -> float:
    """Return how far to the right ``one`` has to go to pass ``other``, negative to the left; the shorter of both."""
    own, its = one.robot.machine.profile.dimensions, other.robot.machine.profile.dimensions
    turn = other.place[2] - one.place[2]
    extent_m = (abs(its.length_m * math.sin(turn)) + abs(its.width_m * math.cos(turn)) + own.width_m) / 2
    _, left_m = _seen_from(*one.place, *other.place[:2])
    free_m = extent_m + 2 * SIDE_M
    return free_m - left_m if left_m >= 0 else -free_m - left_m


def _shift(robot: SimRobot, first: SimRobot) -> Point:
    """Return where the datum of a robot lies in the frame of the first one; both point north, nearly enough."""
    config, common = robot.config, first.config
    return EnuFrame(common.datum_lat_deg, common.datum_lon_deg).to_enu(config.datum_lat_deg, config.datum_lon_deg)


def _seen_from(x: float, y: float, theta: float, ox: float, oy: float) -> tuple[float, float]:
    """Return how far ahead and to the left a place is."""
    cos, sin = math.cos(theta), math.sin(theta)
    return (ox - x) * cos + (oy - y) * sin, -(ox - x) * sin + (oy - y) * cos

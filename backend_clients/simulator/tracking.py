"""Follows a route: steers back to the line, slows for bends, turns sharp corners on the spot; or runs on rails."""

from __future__ import annotations

import math
from dataclasses import dataclass

from backend_clients.simulator.kinematics import Base, wrap_rad
from backend_clients.simulator.route import Route

STIFFNESS_1PM = 1.6  # returns to the line within about 1.5 m of driving
DAMPING = 1.0
ARRIVED_M = 0.02
CREEP_MPS = 0.06
PIVOT_DONE_RAD = math.radians(2.0)
PIVOT_START_RAD = math.radians(30)
YAW_DECEL_RADPS2 = 1.5
RAIL_PIVOT_MPS = 0.5  # what runs on rails does not turn on the spot, but slows for it
CUSP_STAND_S = 1.5  # it has come to rest, and its drive is engaged the other way
RAIL_TURN_SHARE = 0.3  # of the way to the new heading in one step


@dataclass(frozen=True, slots=True)
class Setpoint:
    """Wanted speeds, and whether the machine is turning on the spot."""

    v_mps: float
    yaw_rate_radps: float
    is_pivoting: bool = False


class Tracker:
    """Progress along one route; ``steer`` is called every control step.

    Args:
        route: the line to follow.
        s_m: where on it to begin.
    """

    def __init__(self, route: Route, s_m: float = 0.0) -> None:
        self.route = route
        self.s_m = s_m
        self.left_m = 0.0
        self.is_done = False
        self._must_align = True
        self._stand_s = 0.0

    @property
    def left_of_line_m(self) -> float | None:
        """Cross-track error, left of the machine positive; ``None`` while it turns on the spot."""
        if self._must_align:
            return None
        return -self.left_m if self.route.leg_at(self.s_m).is_backward else self.left_m

    @property
    def is_turning(self) -> bool:
        """Whether it has to turn on the spot before it drives on."""
        return self._must_align

    def go_on_as(self, other: Tracker) -> None:
        """Take over how the machine lies on the line from a tracker of the same stretch."""
        self.left_m, self._must_align, self._stand_s = other.left_m, other._must_align, other._stand_s

    def align(self) -> None:
        """Turn to the line before driving on, e.g. after a pause."""
        self._must_align = True

    def steer(self, x_m: float, y_m: float, theta_rad: float, dt_s: float) -> Setpoint:
        """Return the speeds for the pose as measured."""
        if self._stand_s > 0:
            self._stand_s -= dt_s
            return Setpoint(0.0, 0.0)
        if self._must_align:
            error = wrap_rad(self.route.heading_after(self.s_m) - theta_rad)
            if abs(error) > PIVOT_DONE_RAD:
                return Setpoint(0.0, self._pivot_rate(error), is_pivoting=True)
            self._must_align = False
        # backwards it is steered as if its rear were its nose; only the speed has the other sign
        is_backward = self.route.leg_at(self.s_m).is_backward
        line = self.route.reference(x_m, y_m, self.s_m)
        self.s_m, self.left_m = max(self.s_m, line.s_m), line.left_m
        corner = self.route.next_pivot(self.s_m + 1e-6)
        ahead = corner - self.s_m
        if ahead <= ARRIVED_M:
            self._arrive(corner)
            return Setpoint(0.0, 0.0)
        error = wrap_rad(theta_rad + math.pi * is_backward - line.heading_rad)
        if abs(error) > PIVOT_START_RAD:
            return Setpoint(0.0, self._pivot_rate(-error), is_pivoting=True)
        v = min(self._speed(ahead), max(ahead / dt_s * 0.5, CREEP_MPS))
        v *= max(math.cos(error), 0.3)
        bend = min(max(line.curvature_1pm, -2.0), 2.0)
        pull = STIFFNESS_1PM**2 * min(max(line.left_m, -0.5), 0.5) * _sinc(error)
        turn = v * (bend * math.cos(error) - pull) - 2 * DAMPING * STIFFNESS_1PM * v * error
        most = self.route.motion.yaw_rate_radps
        return Setpoint(-v if is_backward else v, min(max(turn, -most), most))

    def carry(self, base: Base, moved_m: float) -> None:
        """Take note of how far the machine moved; one that is steered follows the line by itself."""

    def _speed(self, ahead_m: float) -> float:
        decel = self.route.motion.planned_decel_mps2
        return min(self.route.speed_limit(self.s_m, decel), max(math.sqrt(2 * decel * ahead_m), CREEP_MPS))

    def _pivot_rate(self, error_rad: float) -> float:
        rate = min(math.sqrt(2 * YAW_DECEL_RADPS2 * abs(error_rad)), self.route.motion.yaw_rate_radps)
        return math.copysign(max(rate * 0.8, 0.05), error_rad)

    def _arrive(self, corner_m: float) -> None:
        self.s_m = corner_m
        if corner_m >= self.route.length_m - 1e-6:
            self.is_done = True
        else:
            self.s_m = corner_m + 1e-5  # past the corner, so that the next stretch is looked at
            is_cusp = self.route.is_cusp(corner_m)  # there its heading goes on
            self._must_align, self._stand_s = not is_cusp, CUSP_STAND_S if is_cusp else 0.0


class RailTracker(Tracker):
    """Puts the machine on the line: for what flies, and where a thousand robots must be cheap."""

    @property
    def left_of_line_m(self) -> float | None:
        """Always on the line."""
        return 0.0

    def steer(self, x_m: float, y_m: float, theta_rad: float, dt_s: float) -> Setpoint:
        """Return the speed along the line; the pose is not looked at."""
        ahead = self.route.length_m - self.s_m
        if ahead <= ARRIVED_M:
            self.s_m, self.is_done = self.route.length_m, True
            return Setpoint(0.0, 0.0)
        v = min(self._speed(ahead), max(ahead / dt_s * 0.5, CREEP_MPS))
        corner = self.route.next_pivot(self.s_m + 1e-6) - self.s_m
        slow = math.sqrt(RAIL_PIVOT_MPS**2 + 2 * self.route.motion.planned_decel_mps2 * corner)
        v = min(v, slow)
        return Setpoint(-v if self.route.leg_at(self.s_m).is_backward else v, 0.0)

    def carry(self, base: Base, moved_m: float) -> None:
        """Put the machine ``moved_m`` further along the line."""
        self.s_m = min(self.s_m + moved_m, self.route.length_m)
        turn = wrap_rad(self.route.heading_after(self.s_m) - base.theta_rad)
        base.put(*self.route.point_at(self.s_m), base.theta_rad + turn * RAIL_TURN_SHARE)


def tracker_on(route: Route, s_m: float = 0.0) -> Tracker:
    """Return what follows ``route`` from ``s_m`` on, steered or on rails as its machine moves."""
    return RailTracker(route, s_m) if route.motion.is_on_rails else Tracker(route, s_m)


def _sinc(x: float) -> float:
    return 1.0 if abs(x) < 1e-6 else math.sin(x) / x

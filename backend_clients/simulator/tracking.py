"""Follows a route: steers back to the line, slows for bends, turns sharp corners on the spot."""

from __future__ import annotations

import math
from dataclasses import dataclass

from backend_clients.simulator.kinematics import MAX_YAW_RATE_RADPS, wrap_rad
from backend_clients.simulator.route import Route

STIFFNESS_1PM = 1.6  # returns to the line within about 1.5 m of driving
DAMPING = 1.0
PLANNED_DECEL_MPS2 = 0.5  # gentler than the brakes, so that it stops where it should
ARRIVED_M = 0.02
CREEP_MPS = 0.06
PIVOT_DONE_RAD = math.radians(2.0)
PIVOT_START_RAD = math.radians(30)
YAW_DECEL_RADPS2 = 1.5


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

    @property
    def left_of_line_m(self) -> float | None:
        """Cross-track error, left positive; ``None`` while it turns on the spot."""
        return None if self._must_align else self.left_m

    def go_on_as(self, other: Tracker) -> None:
        """Take over how the machine lies on the line from a tracker of the same stretch."""
        self.left_m, self._must_align = other.left_m, other._must_align

    def align(self) -> None:
        """Turn to the line before driving on, e.g. after a pause."""
        self._must_align = True

    def steer(self, x_m: float, y_m: float, theta_rad: float, dt_s: float) -> Setpoint:
        """Return the speeds for the pose as measured."""
        if self._must_align:
            error = wrap_rad(self.route.heading_after(self.s_m) - theta_rad)
            if abs(error) > PIVOT_DONE_RAD:
                return Setpoint(0.0, _pivot_rate(error), is_pivoting=True)
            self._must_align = False
        line = self.route.reference(x_m, y_m, self.s_m)
        self.s_m, self.left_m = max(self.s_m, line.s_m), line.left_m
        corner = self.route.next_pivot(self.s_m + 1e-6)
        ahead = corner - self.s_m
        if ahead <= ARRIVED_M:
            self._arrive(corner)
            return Setpoint(0.0, 0.0)
        error = wrap_rad(theta_rad - line.heading_rad)
        if abs(error) > PIVOT_START_RAD:
            return Setpoint(0.0, _pivot_rate(-error), is_pivoting=True)
        v = min(
            self.route.speed_limit(self.s_m, PLANNED_DECEL_MPS2),
            max(math.sqrt(2 * PLANNED_DECEL_MPS2 * ahead), CREEP_MPS),
            max(ahead / dt_s * 0.5, CREEP_MPS),
        )
        v *= max(math.cos(error), 0.3)
        bend = min(max(line.curvature_1pm, -2.0), 2.0)
        pull = STIFFNESS_1PM**2 * min(max(line.left_m, -0.5), 0.5) * _sinc(error)
        turn = v * (bend * math.cos(error) - pull) - 2 * DAMPING * STIFFNESS_1PM * v * error
        return Setpoint(v, min(max(turn, -MAX_YAW_RATE_RADPS), MAX_YAW_RATE_RADPS))

    def _arrive(self, corner_m: float) -> None:
        self.s_m = corner_m
        if corner_m >= self.route.length_m - 1e-6:
            self.is_done = True
        else:
            self.s_m = corner_m + 1e-5  # past the corner, so that the next stretch is looked at
            self._must_align = True


def _pivot_rate(error_rad: float) -> float:
    rate = min(math.sqrt(2 * YAW_DECEL_RADPS2 * abs(error_rad)), MAX_YAW_RATE_RADPS)
    return math.copysign(max(rate * 0.8, 0.05), error_rad)


def _sinc(x: float) -> float:
    return 1.0 if abs(x) < 1e-6 else math.sin(x) / x

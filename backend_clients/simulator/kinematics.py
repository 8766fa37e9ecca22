"""Skid-steer motion with limited acceleration; ENU frame, SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass

from backend_clients.edge.messages_up import Limits

MAX_SPEED_MPS = 6 / 3.6  # published limit of the vehicle, 6 km/h
MAX_ACCEL_MPS2 = 0.6
BRAKE_MPS2 = 1.2  # braking on STOP, without locking the tracks on wet soil
MAX_YAW_RATE_RADPS = 0.9
MAX_YAW_ACCEL_RADPS2 = 2.5
TRACK_M = 1.5  # distance between the tracks

LIMITS = Limits(
    max_speed_mps=round(MAX_SPEED_MPS, 3),
    max_accel_mps2=MAX_ACCEL_MPS2,
    decel_mps2=BRAKE_MPS2,
    max_yaw_rate_radps=MAX_YAW_RATE_RADPS,
    turning_radius_m=0.0,
    can_reverse=True,
    can_pivot=True,
)


def wrap_rad(angle: float) -> float:
    """Return the angle in [-pi, pi)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


def stopping_distance_m(speed_mps: float) -> float:
    """Return how far it rolls when STOP brakes now."""
    return speed_mps * speed_mps / (2 * BRAKE_MPS2)


@dataclass(slots=True)
class SkidSteer:
    """Pose and motion of the machine; ``step`` is the only way they change."""

    x_m: float = 0.0
    y_m: float = 0.0
    theta_rad: float = 0.0
    speed_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    distance_m: float = 0.0

    @property
    def is_still(self) -> bool:
        """Whether nothing moves at all."""
        return abs(self.speed_mps) < 1e-3 and abs(self.yaw_rate_radps) < 1e-3

    def step(self, dt_s: float, v_mps: float, yaw_rate_radps: float, *, is_braking: bool = False) -> None:
        """Move for ``dt_s`` towards the wanted speeds; ``is_braking`` uses the brakes' deceleration."""
        v_mps = min(max(v_mps, -MAX_SPEED_MPS), MAX_SPEED_MPS)
        slowing = is_braking or abs(v_mps) < abs(self.speed_mps)
        rate = BRAKE_MPS2 if slowing else MAX_ACCEL_MPS2
        old_v, old_w = self.speed_mps, self.yaw_rate_radps
        self.speed_mps = _towards(old_v, v_mps, rate * dt_s)
        # the outer track may not be faster than the drive allows
        spare = max(MAX_SPEED_MPS - abs(self.speed_mps), 0.0) * 2 / TRACK_M + 0.35
        limit = min(MAX_YAW_RATE_RADPS, spare)
        wanted = min(max(yaw_rate_radps, -limit), limit)
        self.yaw_rate_radps = _towards(old_w, wanted, MAX_YAW_ACCEL_RADPS2 * dt_s)
        v, w = (old_v + self.speed_mps) / 2, (old_w + self.yaw_rate_radps) / 2
        middle = self.theta_rad + w * dt_s / 2
        self.x_m += v * math.cos(middle) * dt_s
        self.y_m += v * math.sin(middle) * dt_s
        self.theta_rad = wrap_rad(self.theta_rad + w * dt_s)
        self.distance_m += abs(v) * dt_s


def _towards(now: float, wanted: float, most: float) -> float:
    if abs(wanted - now) <= most:
        return wanted
    return now + math.copysign(most, wanted - now)

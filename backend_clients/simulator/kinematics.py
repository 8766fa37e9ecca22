"""Motion with limited acceleration; ENU frame, SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass

from backend_clients.edge.messages_up import Limits


@dataclass(frozen=True, slots=True)
class Motion:
    """How a machine can move.

    ``planned_decel_mps2`` is gentler than the brakes, so that it stops where it should. With ``is_on_rails`` the body
    is put on the line it follows instead of being steered to it: for what flies, and for load tests.
    ``path_reverse_mps``: as fast as that it follows a path backwards; ``None``: never. ``path_height_m``: so high above
    the ground it flies; it climbs there before it sets off.
    """

    max_speed_mps: float
    accel_mps2: float
    brake_mps2: float
    yaw_rate_radps: float
    yaw_accel_radps2: float
    track_m: float
    planned_decel_mps2: float
    can_pivot: bool = True
    turning_radius_m: float = 0.0
    can_reverse: bool = True
    is_on_rails: bool = False
    path_reverse_mps: float | None = None
    path_height_m: float | None = None

    def limits(self) -> Limits:
        """Return them as the factsheet says them."""
        return Limits(
            max_speed_mps=round(self.max_speed_mps, 3),
            max_accel_mps2=self.accel_mps2,
            decel_mps2=self.brake_mps2,
            max_yaw_rate_radps=self.yaw_rate_radps,
            turning_radius_m=self.turning_radius_m,
            can_reverse=self.can_reverse,
            can_pivot=self.can_pivot,
            path_reverse_mps=self.path_reverse_mps,
            path_height_m=self.path_height_m,
        )

    def stopping_distance_m(self, speed_mps: float) -> float:
        """Return how far it rolls when STOP brakes now."""
        return speed_mps * speed_mps / (2 * self.brake_mps2)


TRACKED = Motion(
    max_speed_mps=6 / 3.6,  # published limit of the vehicle, 6 km/h
    accel_mps2=0.6,
    brake_mps2=1.2,  # braking on STOP, without locking the tracks on wet soil
    yaw_rate_radps=0.9,
    yaw_accel_radps2=2.5,
    track_m=1.5,
    planned_decel_mps2=0.5,
)
WHEELED = Motion(
    max_speed_mps=2.0,
    accel_mps2=0.5,
    brake_mps2=1.5,
    yaw_rate_radps=0.35,  # on the spot it stands for the to and fro of a machine that cannot
    yaw_accel_radps2=1.2,
    track_m=2.1,
    planned_decel_mps2=0.4,
    can_pivot=False,
    turning_radius_m=5.0,
    path_reverse_mps=0.6,
)
FLYING = Motion(
    max_speed_mps=8.0,
    accel_mps2=2.0,
    brake_mps2=3.0,
    yaw_rate_radps=1.5,
    yaw_accel_radps2=6.0,
    track_m=0.5,
    planned_decel_mps2=1.5,
    is_on_rails=True,
    path_height_m=30.0,
)


def wrap_rad(angle: float) -> float:
    """Return the angle in [-pi, pi)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


@dataclass(slots=True)
class Base:
    """Pose and motion of the machine; ``step`` and ``put`` are the only ways they change."""

    x_m: float = 0.0
    y_m: float = 0.0
    theta_rad: float = 0.0
    speed_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    distance_m: float = 0.0
    motion: Motion = TRACKED

    @property
    def is_still(self) -> bool:
        """Whether nothing moves at all."""
        return abs(self.speed_mps) < 1e-3 and abs(self.yaw_rate_radps) < 1e-3

    def put(self, x_m: float, y_m: float, theta_rad: float) -> None:
        """Place it; speeds stay as they are."""
        self.x_m, self.y_m, self.theta_rad = x_m, y_m, wrap_rad(theta_rad)

    def step(self, dt_s: float, v_mps: float, yaw_rate_radps: float, *, is_braking: bool = False) -> None:
        """Move for ``dt_s`` towards the wanted speeds; ``is_braking`` uses the brakes' deceleration."""
        old_v, old_w = self.speed_mps, self.yaw_rate_radps
        if not (old_v or old_w or v_mps or yaw_rate_radps):
            return  # most machines of a fleet stand most of the time
        motion = self.motion
        v_mps = min(max(v_mps, -motion.max_speed_mps), motion.max_speed_mps)
        slowing = is_braking or abs(v_mps) < abs(old_v)
        rate = motion.brake_mps2 if slowing else motion.accel_mps2
        self.speed_mps = _towards(old_v, v_mps, rate * dt_s)
        # the outer track may not be faster than the drive allows
        spare = max(motion.max_speed_mps - abs(self.speed_mps), 0.0) * 2 / motion.track_m + 0.35
        limit = min(motion.yaw_rate_radps, spare)
        wanted = min(max(yaw_rate_radps, -limit), limit)
        self.yaw_rate_radps = _towards(old_w, wanted, motion.yaw_accel_radps2 * dt_s)
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

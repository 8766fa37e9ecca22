"""The body of a machine: drive, battery, tool, position sensor, and what stands before it.

It knows nothing of missions or orders; ``world`` moves it, ``brain`` commands it.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from backend_clients.edge import messages_up as up
from backend_clients.simulator.families import WEEDER
from backend_clients.simulator.kinematics import Base, wrap_rad
from backend_clients.simulator.limbs import AHEAD
from backend_clients.simulator.profile import Profile
from backend_clients.simulator.tracking import Setpoint

if TYPE_CHECKING:
    from backend_clients.simulator.limbs import Limbs
    from backend_clients.simulator.planter_rig import PlanterRig

NOISE_LIMIT_M = 0.015  # published RTK accuracy
NOISE_TIME_S = 4.0  # RTK errors wander, they do not jump
FLOAT_DRIFT_M = 0.35
COLD_C, WARM_UP_S = 21.0, 90.0
STANDSTILL_S = 0.5
MOTOR_TIME_S = 240.0
CLIMB_MPS = 2.5
LEVEL_M = 0.5  # this near to its height it is there
WIND_MPS = 4.0
STRAIGHT_DOWN, TO_THE_ROWS = -1.55, -0.32  # of a camera at work, above the horizon
STOPPED = Setpoint(0.0, 0.0)


@dataclass(slots=True)
class Drift:
    """A slowly wandering error, never outside its limit (first-order Gauss-Markov)."""

    limit_m: float = NOISE_LIMIT_M
    value_m: float = 0.0

    def step(self, dt_s: float, rng: random.Random) -> None:
        """Let the error wander for ``dt_s``."""
        keep = math.exp(-dt_s / NOISE_TIME_S)
        spread = self.limit_m / 2.2 * math.sqrt(1 - keep * keep)
        moved = self.value_m * keep + rng.gauss(0.0, spread)
        self.value_m = min(max(moved, -self.limit_m), self.limit_m)


@dataclass(frozen=True, slots=True)
class Neighbour:
    """Another machine in the protective field."""

    id: str
    name: str
    free_m: float


@dataclass(slots=True)
class Machine:
    """Truth about one machine; the fields from ``is_*`` on are switched by people and faults.

    ``aside_m`` is how far right of its line it is led, past another machine; negative to the left.
    """

    rng: random.Random
    base: Base = field(default_factory=Base)
    profile: Profile = WEEDER
    soc: float = 0.92
    tool_on: bool = False
    tool_temperature_c: float = COLD_C
    rate_per_min: float | None = None
    still_s: float = STANDSTILL_S
    load_w: float = 0.0
    person: tuple[float, float] | None = None
    neighbour: Neighbour | None = None
    aside_m: float = 0.0
    is_hardware_stop: bool = False
    is_cover_open: bool = False
    is_rtk_float: bool = False
    is_charging: bool = False
    is_airborne: bool = False
    is_unsure: bool = False
    seedlings: int = 0
    rig: PlanterRig | None = None
    limbs: Limbs | None = None
    motor_c: float = COLD_C
    height_m: float = 0.0
    wind_mps: float = WIND_MPS
    ignores_brakes: bool = False
    last_moving: Setpoint = STOPPED
    error_x: Drift = field(default_factory=Drift)
    error_y: Drift = field(default_factory=Drift)

    def step(self, dt_s: float, wanted: Setpoint, *, is_braking: bool, tool_on: bool) -> None:
        """Live for ``dt_s``. The hardware stop and the tool's cover act here, below any software."""
        if self.ignores_brakes and is_braking and not self.is_hardware_stop:
            wanted, is_braking, tool_on = self.last_moving, False, self.tool_on
        if self.is_hardware_stop or self.soc <= 0:
            wanted, is_braking, tool_on = STOPPED, True, False
        elif wanted.v_mps or wanted.yaw_rate_radps:
            self.last_moving = wanted
        self.tool_on = tool_on and not self.is_cover_open
        self.base.step(dt_s, wanted.v_mps, wanted.yaw_rate_radps, is_braking=is_braking)
        is_still = self.base.is_still and not (self.rig is not None and self.rig.crane.is_moving)
        self.still_s = self.still_s + dt_s if is_still else 0.0
        self._step_energy(dt_s)
        self._step_tool(dt_s)
        if self.rig is not None:
            self.rig.step(dt_s)
        elif self.limbs is not None:
            self._step_limbs(dt_s)
        if not self.profile.motion.is_on_rails:
            self._step_error(dt_s)

    @property
    def is_climbing(self) -> bool:
        """Whether it is below the height at which it flies."""
        return self._goal_m - self.height_m > LEVEL_M

    @property
    def _goal_m(self) -> float:
        """Height above the ground at which it should be now."""
        flies = self.is_airborne and self.limbs is not None  # without a body to look at it has no height
        return (self.profile.motion.path_height_m or 0.0) if flies else 0.0

    @property
    def is_crane_at_limit(self) -> bool:
        """Whether a joint of the crane is outside its soft limits."""
        return self.rig is not None and bool(self.rig.crane.beyond())

    @property
    def is_standing(self) -> bool:
        """Standstill as the safety controller means it: no motion for 0.5 s and the tool off."""
        return self.still_s >= STANDSTILL_S and not self.tool_on

    def measured_pose(self) -> tuple[float, float, float]:
        """Return x, y, theta as the position sensor says."""
        return (
            self.base.x_m + self.error_x.value_m,
            self.base.y_m + self.error_y.value_m,
            wrap_rad(self.base.theta_rad + self.error_y.value_m * 0.05),
        )

    def obstacle_m(self) -> float | None:
        """Return the free distance to what stands in front, ``None`` if nothing is in its way."""
        seen = [self._person_m(), self.neighbour.free_m if self.neighbour is not None else None]
        return min((free_m for free_m in seen if free_m is not None), default=None)

    def _person_m(self) -> float | None:
        if self.person is None:
            return None
        dx, dy = self.person[0] - self.base.x_m, self.person[1] - self.base.y_m
        cos, sin = math.cos(self.base.theta_rad), math.sin(self.base.theta_rad)
        ahead, side = dx * cos + dy * sin, -dx * sin + dy * cos
        size = self.profile.dimensions
        if abs(side) > size.width_m / 2 + 0.5 or ahead < 0:
            return None
        return max(ahead - size.base_to_front_m, 0.0)

    def is_way_blocked(self) -> bool:
        """Whether somebody stands inside the protective field; other machines are ``neighbour``."""
        free_m = self._person_m()
        return free_m is not None and free_m < self.profile.protective_field_m

    def put_person_ahead(self, distance_m: float) -> None:
        """Let a person stand ``distance_m`` before the machine's front."""
        reach = self.profile.dimensions.base_to_front_m + distance_m
        self.person = (
            self.base.x_m + reach * math.cos(self.base.theta_rad),
            self.base.y_m + reach * math.sin(self.base.theta_rad),
        )

    def gnss(self) -> up.Gnss:
        """Return the quality of the fix."""
        if self.is_rtk_float:
            return up.Gnss(fix="float", accuracy_m=FLOAT_DRIFT_M, satellites=11, correction_age_s=14.0)
        return up.Gnss(fix="fixed", accuracy_m=NOISE_LIMIT_M, satellites=19, correction_age_s=1.0)

    def battery(self) -> up.Battery:
        """Return charge and the time left at the present load."""
        energy = self.profile.energy
        remaining = None if self.is_charging else self.soc * energy.capacity_j / max(self.load_w, energy.idle_w)
        return up.Battery(soc=round(self.soc, 4), remaining_s=remaining, charging=self.is_charging)

    def _step_error(self, dt_s: float) -> None:
        limit = FLOAT_DRIFT_M if self.is_rtk_float else NOISE_LIMIT_M
        for error in (self.error_x, self.error_y):
            error.limit_m = limit
            error.step(dt_s, self.rng)

    def _step_energy(self, dt_s: float) -> None:
        energy, base = self.profile.energy, self.base
        now_w = energy.idle_w + energy.drive_w_per_mps * (abs(base.speed_mps) + 0.5 * abs(base.yaw_rate_radps))
        now_w += energy.tool_w if self.tool_on else 0.0
        now_w += energy.hover_w if self.is_airborne else 0.0
        self.load_w += (now_w - self.load_w) * min(dt_s / 20.0, 1.0)
        gained_w = energy.charge_w if self.is_charging else -now_w
        self.soc = min(max(self.soc + gained_w * dt_s / energy.capacity_j, 0.0), 1.0)

    def _step_limbs(self, dt_s: float) -> None:
        assert self.limbs is not None
        down = STRAIGHT_DOWN if self.profile.energy.hover_w > 0 else TO_THE_ROWS
        # the head looks into the bend, and down at what the tool does
        pan = 0.0 if self.base.is_still else round(self.base.yaw_rate_radps, 1)
        looks_down = self.tool_on or self.is_airborne
        self.limbs.look(pan=pan, tilt=down if looks_down else AHEAD["tilt"])
        self.limbs.step(dt_s)
        if self.profile.energy.hover_w:
            up_m = self._goal_m - self.height_m
            self.height_m += min(max(up_m, -CLIMB_MPS * dt_s), CLIMB_MPS * dt_s)
            gust = (WIND_MPS - self.wind_mps) * dt_s / 30.0 + self.rng.gauss(0.0, 0.35 * math.sqrt(dt_s))
            self.wind_mps = max(self.wind_mps + gust, 0.0)
        work = min(self.load_w / (self.profile.energy.tool_w + self.profile.energy.idle_w + 1.0), 1.5)
        self.motor_c += (COLD_C + 34.0 * work - self.motor_c) * min(dt_s / MOTOR_TIME_S, 1.0)

    def _step_tool(self, dt_s: float) -> None:
        goal = (self.profile.hot_c or COLD_C) if self.tool_on else COLD_C
        self.tool_temperature_c += (goal - self.tool_temperature_c) * min(dt_s / WARM_UP_S, 1.0)
        usual = self.profile.rate_per_min
        if not self.tool_on or usual is None:
            self.rate_per_min = None
            return
        before = self.rate_per_min if self.rate_per_min is not None else usual
        wander = self.rng.gauss(0.0, 12.0 * math.sqrt(dt_s))
        self.rate_per_min = max(before + (usual - before) * min(dt_s / 10, 1.0) + wander, 5.0)

"""The machine a plan is made for: outline, motion limits, speeds, energy."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import shapely

from hmi.domain.family import Family
from hmi.domain.mission_plan import PlanRefused
from hmi.domain.planned_machine import PIVOTING_RADIUS_M
from hmi.domain.robot import Factsheet
from hmi.planning.energy import UAV, WEEDER, Energy, energy_of
from hmi.planning.projection import Floats

_LEAD_IN_M = {"laser": 0.3, "planter": 0.0}  # a laser sees weeds half a second before it fires at them
PLANT_S = 71.0
"""Seconds a planter stands for one tree: of the published 375 s for five trees and two moves, without the driving."""
SEEDLINGS_PER_M2 = 0.25
"""2,500 a hectare, the usual density of planted forest."""
_WAY_MPS = 0.6
_LEAD_OUT_M = {"laser": 0.1, "planter": 0.0}


@dataclass(frozen=True, slots=True)
class RobotProfile:
    """What the planner needs to know of a robot. SI; the reference point ``base`` is what follows the path.

    ``margin_m`` is kept between outline and border: RTK noise, tracking error and the sampling of curves.
    The tool is switched on
    ``lead_in_m`` before ground to be treated and off ``lead_out_m`` after it. ``stand_s_per_m`` is how long it stands
    for a metre of worked path: a planter plants where it stands. ``reverse_mps`` is its speed backwards in turns, 0 if
    it follows no path backwards. ``tool_width_m`` is the most that its tool treats in one pass, ``None`` if that is not
    known, or no matter. ``clearance_m`` is kept from closed ground on top of the margin. ``flies``: it needs no
    headland to turn on, and standing rows are not in its way.
    """

    length_m: float = 2.6
    width_m: float = 1.7
    base_to_front_m: float = 1.3
    turning_radius_m: float = PIVOTING_RADIUS_M
    can_pivot: bool = True
    row_speed_mps: float = 0.45
    turn_speed_mps: float = 0.3
    transit_speed_mps: float = 1.0
    accel_mps2: float = 0.4
    yaw_rate_radps: float = 0.6
    margin_m: float = 0.1
    energy: Energy = WEEDER
    battery_j: float = WEEDER.store_j
    lead_in_m: float = 0.5
    lead_out_m: float = 0.2
    stand_s_per_m: float = 0.0
    reverse_mps: float = 0.0
    tool_width_m: float | None = None
    clearance_m: float = 0.0
    flies: bool = False

    def __post_init__(self) -> None:
        """Refuse a machine that cannot be."""
        for name in ("length_m", "width_m", "row_speed_mps", "turn_speed_mps", "transit_speed_mps", "accel_mps2"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise PlanRefused("bad_machine", f"The machine's {name} is {value}; it must be positive.", name)
        if not (math.isfinite(self.turning_radius_m) and 0 <= self.turning_radius_m <= 100):
            raise PlanRefused("bad_machine", "The machine's turning radius must be 0 to 100 m.", "turning_radius_m")
        if not (math.isfinite(self.reverse_mps) and self.reverse_mps >= 0):
            raise PlanRefused("bad_machine", "The machine's speed backwards must be 0 m/s or more.", "reverse_mps")
        for name, value in (("battery", self.battery_j), ("tool_width_m", self.tool_width_m or 1.0)):
            if not (math.isfinite(value) and value > 0):
                raise PlanRefused("bad_machine", f"The machine's {name} is {value:g}; it must be positive.", name)
        if not (math.isfinite(self.yaw_rate_radps) and self.yaw_rate_radps >= 0):
            raise PlanRefused("bad_machine", "The machine's yaw rate must be 0 rad/s or more.", "yaw_rate_radps")
        if not 0 <= self.base_to_front_m <= self.length_m:
            raise PlanRefused("bad_machine", "The machine's base lies outside its outline.", "base_to_front_m")

    @classmethod
    def from_factsheet(cls, sheet: Factsheet) -> RobotProfile:
        """Take the outline and motion limits the robot declares, what it leaves open from the usual one of its family.

        Speeds and accelerations are the usual ones, never above its own limits.
        """
        base = _FLYER if sheet.family is Family.UAV else cls()
        energy = energy_of(sheet.family)
        top = sheet.max_speed_mps
        return replace(
            base,
            length_m=sheet.length_m,
            width_m=sheet.width_m,
            base_to_front_m=min(sheet.base_to_front_m, sheet.length_m),
            # tracks that turn on the spot still tear up less soil on an arc
            turning_radius_m=max(sheet.turning_radius_m, base.turning_radius_m if sheet.can_pivot else 0.0),
            can_pivot=sheet.can_pivot,
            row_speed_mps=min(base.row_speed_mps, top),
            turn_speed_mps=min(base.turn_speed_mps, top),
            transit_speed_mps=min(base.transit_speed_mps, top),
            accel_mps2=min(base.accel_mps2, sheet.max_accel_mps2),
            yaw_rate_radps=min(base.yaw_rate_radps, sheet.max_yaw_rate_radps),
            energy=energy,
            battery_j=energy.store_j if sheet.battery_wh is None else sheet.battery_wh * 3600,
            lead_in_m=_LEAD_IN_M.get(sheet.tool_kind, base.lead_in_m),
            lead_out_m=_LEAD_OUT_M.get(sheet.tool_kind, base.lead_out_m),
            reverse_mps=min(sheet.path_reverse_mps or 0.0, top),
            # a crane plants the row it is driven along, however far the next one is
            tool_width_m=None if sheet.family is Family.PLANTER else sheet.tool_width_m or None,
        )

    def planting(self, width_m: float, spacing_m: float | None) -> RobotProfile:
        """Return the machine with the time it stands to plant, a tree each ``spacing_m`` or at the usual density."""
        per_m = 1 / spacing_m if spacing_m else SEEDLINGS_PER_M2 * width_m
        return replace(self, stand_s_per_m=PLANT_S * per_m)

    @property
    def way_mps(self) -> float:
        """Speed of a short or bent way between field and home."""
        return min(self.turn_speed_mps if self.flies else _WAY_MPS, self.transit_speed_mps)

    @property
    def reach_m(self) -> float:
        """Radius of the circle the outline sweeps when it turns on the spot."""
        return math.hypot(self._overhang_m, self.width_m / 2)

    @property
    def border_m(self) -> float:
        """Least distance of a path from a border it follows, corners rounded with the turning radius included.

        In a corner the outer front edge swings out to ``hypot(r + width/2, overhang)`` from the turning centre.
        """
        r = self.turning_radius_m
        return math.hypot(r + self.width_m / 2, self._overhang_m) - r + self.margin_m

    @property
    def _overhang_m(self) -> float:
        return max(self.base_to_front_m, self.length_m - self.base_to_front_m)

    def outlines(self, poses: Floats) -> Floats:
        """Return (N, 5, 2) closed outlines of the machine at (N, 3) poses x, y, heading."""
        rear = self.base_to_front_m - self.length_m
        half = self.width_m / 2
        corners = np.array(
            [
                [rear, -half],
                [self.base_to_front_m, -half],
                [self.base_to_front_m, half],
                [rear, half],
                [rear, -half],
            ]
        )
        cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x = poses[:, 0, None] + cos[:, None] * corners[:, 0] - sin[:, None] * corners[:, 1]
        y = poses[:, 1, None] + sin[:, None] * corners[:, 0] + cos[:, None] * corners[:, 1]
        return np.stack([x, y], axis=-1)

    def outline_polygons(self, poses: Floats) -> shapely.Geometry:
        """Return an array of N polygons, see ``outlines``."""
        return shapely.polygons(self.outlines(poses))


_FLYER = RobotProfile(
    length_m=0.9,
    width_m=0.9,
    base_to_front_m=0.45,
    turning_radius_m=4.0,
    row_speed_mps=5.0,
    turn_speed_mps=3.0,
    transit_speed_mps=7.0,
    accel_mps2=2.0,
    yaw_rate_radps=1.5,
    clearance_m=2.0,  # its fix need not be RTK
    energy=UAV,
    battery_j=UAV.store_j,
    lead_in_m=0.0,
    lead_out_m=0.0,
    flies=True,
)

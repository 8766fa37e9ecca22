"""What the tool does while the robot follows its mission: weeds, plants trees, or searches.

Each kind of work may slow or stop the drive, says whether the tool is on, and names what it waits for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from backend_clients.simulator.machine import STOPPED, Machine
from backend_clients.simulator.tracking import Setpoint

if TYPE_CHECKING:
    from backend_clients.simulator.mission_run import MissionRun
    from backend_clients.simulator.profile import Profile

ROLLING_MPS = 0.05
AT_TREE_M = 0.06
TO_TREE_MPS = 0.1
LEAST_STEP_M = 0.1


@dataclass(frozen=True, slots=True)
class Doing:
    """What one control step shall do. ``is_working``: what is driven now counts as done."""

    wanted: Setpoint
    tool_on: bool = False
    is_working: bool = False


class Work(Protocol):
    """One kind of work."""

    def guide(self, run: MissionRun, wanted: Setpoint, dt_s: float) -> Doing:
        """Return what to do where the mission wants ``wanted``."""
        ...

    def waits_for(self) -> str:
        """Return the code of what it waits for, empty if nothing."""
        ...

    def count(self, run: MissionRun, dt_s: float) -> float:
        """Return how many weeds, trees or the like were done in the step that just passed."""
        ...


class Weeding:
    """Fires at weeds while it rolls along a row."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine

    def guide(self, run: MissionRun, wanted: Setpoint, dt_s: float) -> Doing:
        """Switch the laser on where the mission says so and the machine rolls."""
        is_rolling = self._machine.base.speed_mps > ROLLING_MPS
        is_on = not wanted.is_pivoting and is_rolling and run.leg.is_tool_wanted(run.tracker.s_m)
        return Doing(wanted, is_on, is_on)

    def waits_for(self) -> str:
        """Wait where it cannot tell crop and weed apart."""
        return "weed_unsure" if self._machine.is_unsure else ""

    def count(self, run: MissionRun, dt_s: float) -> float:
        """Return the weeds treated."""
        # a low dose spares weeds; a high one takes longer on each, which the slower segment brings by itself
        dose = run.leg.dose
        return (self._machine.rate_per_min or 0.0) * dt_s / 60 * min(dose, 1 / max(dose, 1))


class Planting:
    """Stops at each planting point of a row, plants one seedling, drives on."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._left_s = 0.0
        self._planted_at_m = -math.inf
        self._fresh = 0

    def guide(self, run: MissionRun, wanted: Setpoint, dt_s: float) -> Doing:
        """Brake for the next point; plant there with the drive still."""
        s_m = run.tracker.s_m
        if self._left_s > 0:
            return self._plant(s_m, dt_s)
        if wanted.is_pivoting or not run.leg.is_tool_wanted(s_m):
            return Doing(wanted)
        ahead_m = self._next_m(run, s_m) - s_m
        if ahead_m > AT_TREE_M:
            decel = self._machine.profile.motion.planned_decel_mps2
            v = min(wanted.v_mps, max(math.sqrt(2 * decel * ahead_m) * 0.8, TO_TREE_MPS))
            return Doing(Setpoint(v, wanted.yaw_rate_radps), is_working=True)
        if self._machine.base.is_still:
            self._left_s = self._machine.profile.dwell_s
        return Doing(STOPPED, is_working=True)

    def waits_for(self) -> str:
        """Wait for a tray, or for a crane that somebody brings back."""
        if self._machine.is_crane_at_limit:
            return "crane_limit"
        return "tray_empty" if self._machine.seedlings == 0 and self._left_s <= 0 else ""

    def count(self, run: MissionRun, dt_s: float) -> float:
        """Return the trees planted."""
        fresh, self._fresh = self._fresh, 0
        return fresh

    def _plant(self, s_m: float, dt_s: float) -> Doing:
        self._left_s -= dt_s
        if self._left_s <= 0:
            self._machine.seedlings = max(self._machine.seedlings - 1, 0)
            self._planted_at_m, self._fresh = s_m, self._fresh + 1
        return Doing(STOPPED, tool_on=self._left_s > 0, is_working=True)

    def _next_m(self, run: MissionRun, s_m: float) -> float:
        """Return where on the line the next tree goes; the end of the row if there is none."""
        if self._planted_at_m > s_m + AT_TREE_M:
            self._planted_at_m = -math.inf  # the mission began again
        leg, spacing = run.leg, self._machine.profile.spacing_m
        first = max(self._planted_at_m + LEAST_STEP_M, s_m - AT_TREE_M) - leg.own_start_m
        at = leg.own_start_m + max(math.ceil(first / spacing), 0) * spacing
        return at if at <= leg.end_m else leg.end_m + spacing


class Searching:
    """Takes pictures while it flies along a line."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine

    def guide(self, run: MissionRun, wanted: Setpoint, dt_s: float) -> Doing:
        """Switch the camera on where the mission says so."""
        is_on = run.leg.is_tool_wanted(run.tracker.s_m)
        return Doing(wanted, is_on, is_on)

    def waits_for(self) -> str:
        """Wait for nothing."""
        return ""

    def count(self, run: MissionRun, dt_s: float) -> float:
        """Count nothing."""
        return 0.0


def work_of(profile: Profile, machine: Machine) -> Work:
    """Return the work a family does."""
    kinds: dict[str, type[Weeding] | type[Planting] | type[Searching]] = {
        "weed": Weeding,
        "plant": Planting,
        "survey": Searching,
    }
    return kinds[profile.work](machine)

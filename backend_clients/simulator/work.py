"""What the tool does while the robot follows its mission: weeds, plants trees, or searches.

Each kind of work may slow or stop the drive, says whether the tool is on, and names what it waits for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from backend_clients.simulator.machine import Machine
from backend_clients.simulator.tracking import Setpoint
from backend_clients.simulator.verdict import Verdict

if TYPE_CHECKING:
    from backend_clients.simulator.mission_run import MissionRun
    from backend_clients.simulator.profile import Profile

ROLLING_MPS = 0.05
CREEP_MPS = 0.1


@runtime_checkable
class Sites(Protocol):
    """A work that goes from site to site, where people may help."""

    def skip(self, target_id: str | None = None) -> Verdict:
        """Leave the point that is worked at; where a target is named, only that one."""
        ...

    def person_helped(self) -> None:
        """Somebody looked at what the machine asked for."""
        ...

    def work_left_s(self, run: MissionRun) -> float:
        """Return how long what is left will take with the machine standing."""
        ...


@dataclass(frozen=True, slots=True)
class Doing:
    """What one control step shall do. ``is_working``: what is driven now counts as done."""

    wanted: Setpoint
    tool_on: bool = False
    is_working: bool = False


class Work(Protocol):
    """One kind of work.

    ``row`` is the row that is worked where it is not the one the machine is on; ``is_at_site`` while it works with
    the machine standing.
    """

    row: int | None
    is_at_site: bool

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

    row: int | None = None
    is_at_site = False

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


class Searching:
    """Takes pictures while it flies along a line."""

    row: int | None = None
    is_at_site = False

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


def approach(v_mps: float, ahead_m: float, decel_mps2: float) -> float:
    """Return the speed that still stops after ``ahead_m``."""
    return min(v_mps, max(math.sqrt(2 * decel_mps2 * max(ahead_m, 0.0)) * 0.8, CREEP_MPS))


def work_of(profile: Profile, machine: Machine) -> Work:
    """Return the work a family does."""
    if profile.work == "plant":
        # its supervisor's library is not needed where no planter lives
        from backend_clients.simulator.planting import Planting

        return Planting(machine)
    return Weeding(machine) if profile.work == "weed" else Searching(machine)

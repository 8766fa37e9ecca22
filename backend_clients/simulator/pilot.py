"""What a robot wants to do in one control step: stand, wait, obey a hand, or follow what it has to follow."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from backend_clients.simulator.crane import TRANSPORT
from backend_clients.simulator.machine import STOPPED
from backend_clients.simulator.tracking import Setpoint, Tracker
from backend_clients.simulator.work import Doing

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain
    from backend_clients.simulator.crane_task import CraneTask
    from backend_clients.simulator.machine_orders import JogState
    from backend_clients.simulator.planter_rig import PlanterRig

DEADMAN_S = 0.5  # five missed setpoints at 10 Hz
MANUAL_MAX_MPS = 1.0
START_HORN_S = 3.0
CRANE_OUT_MPS = 0.3  # by hand, with the crane not folded
FOLD_SHARE = 0.5
ARRIVED = {"return-home": "Home reached", "go-to": "Place reached"}


@dataclass(slots=True)
class DriveState:
    """Driving by hand: the newest setpoint and when it came, on the robot's clock."""

    v_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    heard_s: float = -math.inf


class Pilot:
    """Decides for one brain. ``lead`` is the way to the path of its mission, while it is on it."""

    def __init__(self, brain: Brain) -> None:
        self._brain = brain
        self.lead: Tracker | None = None
        self.horn_left_s = 0.0
        self.doing = Doing(STOPPED)
        self.followed: Tracker | None = None
        self._is_barred = False  # by hand: something stood in its way, and the hand has not let go since

    def decide(self, dt_s: float) -> Setpoint:
        """Return the speeds wanted in this step; sets ``doing``, ``followed`` and the brain's ``hold_code``."""
        self.doing, self.followed = Doing(STOPPED), None
        if self._brain.machine.rig is not None:
            self._brain.machine.rig.crane.halt()  # until somebody moves it in this step
        if self._brain.machine.limbs is not None:
            self._brain.machine.limbs.hand = self._hand()
        if self._brain.is_stopped:
            return STOPPED
        if self._brain.drive is not None:
            self._jog(dt_s)
            return self._by_hand(self._brain.drive)
        if not self._brain.is_auto:
            return STOPPED
        if self._brain.crane_task is not None:
            return self._move_crane(self._brain.crane_task, dt_s)
        reason = self._waiting_for()
        if reason:
            self.horn_left_s = START_HORN_S
            self._brain.hold_code = reason
            return STOPPED
        if self.horn_left_s > 0:
            self.horn_left_s -= dt_s
            self._brain.hold_code = "start_horn"
            return STOPPED
        if self._brain.machine.is_climbing:
            # its path was planned at a height: below, something may stand there
            self._brain.hold_code = "climbing"
            return STOPPED
        return self._follow(dt_s)

    def _by_hand(self, drive: DriveState) -> Setpoint:
        is_held = self._brain.clock.mono_s() - drive.heard_s <= DEADMAN_S
        is_ahead = is_held and drive.v_mps > 0
        is_blocked = self._brain.machine.is_way_blocked() or self._brain.machine.neighbour is not None
        self._is_barred = is_ahead and (self._is_barred or is_blocked)
        if self._is_barred:
            self._brain.hold_code = "way_blocked"
            return STOPPED
        if not is_held:
            return STOPPED
        rig = self._brain.machine.rig
        most = MANUAL_MAX_MPS if rig is None or rig.is_folded else CRANE_OUT_MPS
        v = min(max(drive.v_mps, -most), most)
        return Setpoint(v, drive.yaw_rate_radps, is_pivoting=v == 0 and drive.yaw_rate_radps != 0)

    def _hand(self) -> Mapping[str, float] | None:
        """Return what a hand wants of the camera head; once it was moved by hand it stays so while that is open."""
        if self._brain.is_stopped:
            return {}
        if self._brain.drive is None or self._brain.jog is None:
            return None
        return self._brain.jog.rates if self._is_held(self._brain.jog) else {}

    def _is_held(self, jog: JogState) -> bool:
        return self._brain.clock.mono_s() - jog.heard_s <= DEADMAN_S

    def _jog(self, dt_s: float) -> None:
        jog, rig = self._brain.jog, self._brain.machine.rig
        if jog is None or rig is None or not self._is_held(jog):
            return
        if self._brain.work.waits_for() == "person_inside":
            self._brain.hold_code = "person_inside"
        elif not self._brain.nodes.why_off("manual-crane"):
            rig.crane.jog(jog.rates, dt_s)

    def _move_crane(self, task: CraneTask, dt_s: float) -> Setpoint:
        if self._brain.work.waits_for() == "person_inside":
            self._brain.hold_code, self.horn_left_s = "person_inside", START_HORN_S
        elif self.horn_left_s > 0:
            self.horn_left_s -= dt_s
            self._brain.hold_code = "start_horn"
        else:
            task.step(dt_s)
            self.doing = Doing(STOPPED, tool_on=True)
            if task.is_done:
                self._brain.crane_arrived()
        return STOPPED

    def _fold(self, rig: PlanterRig, dt_s: float) -> Setpoint:
        """Bring the crane where the machine may be driven."""
        if rig.crane.planned != TRANSPORT:
            rig.crane.send(dict(TRANSPORT))
        rig.crane.step(dt_s, FOLD_SHARE)
        self.doing = Doing(STOPPED, tool_on=True)
        return STOPPED

    def _waiting_for(self) -> str:
        if self._brain.machine.is_way_blocked():
            return "person_ahead"
        if self._brain.machine.neighbour is not None and not self._is_turning():
            return "robot_ahead"
        if self._brain.home_run is not None:
            return self._brain.work.waits_for() if self._brain.work.waits_for() == "person_inside" else ""
        if self._brain.machine.is_rtk_float and self._brain.profile.needs_rtk:
            return "rtk_float"
        return "tool_interlock" if self._brain.machine.is_cover_open else self._brain.work.waits_for()

    def _is_turning(self) -> bool:
        """Whether it turns on the spot: it may turn away from what stands before it."""
        return self.tracker is not None and self.tracker.is_turning

    def _follow(self, dt_s: float) -> Setpoint:
        tracker, rig = self.tracker, self._brain.machine.rig
        assert tracker is not None
        is_travelling = self._brain.run is None or tracker is not self._brain.run.tracker
        if is_travelling and rig is not None and not rig.is_folded:
            return self._fold(rig, dt_s)
        if self._brain.work.is_at_site and self._brain.run is not None and tracker is self._brain.run.tracker:
            self.followed = tracker
            self.doing = self._brain.work.guide(self._brain.run, STOPPED, dt_s)
            return STOPPED
        wanted = tracker.steer(*self._pose_on(tracker), dt_s)
        if tracker.is_done:
            self._arrived(tracker)
            return STOPPED
        if self._brain.run is not None and tracker is self._brain.run.tracker:
            self.doing = self._brain.work.guide(self._brain.run, wanted, dt_s)
            wanted = self.doing.wanted
        self.followed = tracker
        return wanted

    def _pose_on(self, tracker: Tracker) -> tuple[float, float, float]:
        """Return the pose as the tracker takes it: led past something, the line lies aside of where it was."""
        x_m, y_m, theta_rad = self._brain.machine.measured_pose()
        aside_m = self._brain.machine.aside_m
        if aside_m:
            heading = tracker.route.heading_after(tracker.s_m)
            x_m, y_m = x_m - aside_m * math.sin(heading), y_m + aside_m * math.cos(heading)
        return x_m, y_m, theta_rad

    @property
    def tracker(self) -> Tracker | None:
        """What it follows: the way home, the way to its path, or its path."""
        if self._brain.home_run is not None:
            return self._brain.home_run
        return self.lead or (self._brain.run.tracker if self._brain.run is not None else None)

    def _arrived(self, tracker: Tracker) -> None:
        if tracker is self._brain.home_run:
            self._brain.home_run = None
            self._brain.actions.close("finished")
            self._brain.note("mission", ARRIVED[self._brain.errand_name])
        elif tracker is self.lead and self._brain.run is not None:
            self.lead = None
            self._brain.run.tracker.align()
        elif self._brain.run is not None:
            self._brain.run.finish(self._brain.journal, self._brain.mono_ms())
            self._brain.actions.close("finished")
            self._brain.note("mission", "Mission done", self._brain.run.mission.name)
        self._brain.save()

"""The people at the field: they start unattended missions at the machines, and start again what may go on.

A robot on which somebody acted from the console (pause, abort, return home, STOP, another mission) is theirs from
then on: nobody here touches it.
"""

from __future__ import annotations

import random
from collections.abc import Mapping

from backend_clients.simulator.brain import Brain
from backend_clients.simulator.config import Job
from backend_clients.simulator.mission_run import MOVED_LIMIT_M
from backend_clients.simulator.work import Sites
from backend_clients.simulator.world import SimRobot
from hmi.clock import Clock

LOOK_EVERY_S = 1.0
WALK_S = (45.0, 120.0)  # to the machine
STARTING_S = 60.0
OPERATOR_THERE_S = 5.0  # whoever has control at a screen decides
CHARGED = 0.9
SENT_HOME_BELOW = 0.15
HELPED = {"tray_empty": "Tray loaded", "ask_person": "Tray and arm looked at"}
"""What somebody beside the machine does about what it waits for."""
GOES_ON = ("rebooted", "continued", "link_lost", "battery_low")
"""Reasons of a pause that somebody beside the machine may end."""
WENT_HOME = ("low_charge", "link_lost")
"""Reasons for which a robot goes home by itself; there its mission is begun anew."""


class Foreman:
    """Looks after the robots that have a job; call ``look`` as often as you like."""

    def __init__(self, robots: Mapping[str, SimRobot], jobs: Mapping[str, Job], clock: Clock, *, seed: int = 1) -> None:
        self._robots = {robot_id: robots[robot_id] for robot_id in jobs if robot_id in robots}
        self._jobs, self._clock = jobs, clock
        self._rng = random.Random(f"foreman/{seed}")  # noqa: S311
        self._begun_s = clock.mono_s()
        self._looked_s = self._begun_s - LOOK_EVERY_S
        self._due_s: dict[str, float] = {}
        self._help_s: dict[str, float] = {}
        self._to_begin = set(self._robots)
        for robot_id, robot in self._robots.items():
            self._bring(robot, jobs[robot_id])

    def look(self) -> None:
        """Do what is due."""
        now_s = self._clock.mono_s()
        if now_s - self._looked_s < LOOK_EVERY_S:
            return
        self._looked_s = now_s
        for robot_id, robot in self._robots.items():
            if robot.boot is not None:
                self._look_at(robot_id, robot.boot.brain, now_s)

    def _bring(self, robot: SimRobot, job: Job) -> None:
        """Put a robot that has never had a mission into the middle of its work."""
        if robot.boot is None or robot.boot.brain.run is not None or robot.boot.brain.is_stopped:
            return
        brain = robot.boot.brain
        brain.load(job.mission)
        run = brain.run
        assert run is not None  # load made it, or raised
        if job.done > 0:
            s_m = job.done * run.route.length_m
            robot.machine.base.put(*run.route.point_at(s_m), run.route.heading_after(s_m))
            run.count_done(s_m)
            run.stand_at(s_m, brain.place)
            brain.save()

    def _look_at(self, robot_id: str, brain: Brain, now_s: float) -> None:
        run = brain.run
        is_ours = run is not None and run.mission.mission_id == self._jobs[robot_id].mission.mission_id
        if run is None or not is_ours or brain.is_stopped or brain.drive is not None:
            self._due_s.pop(robot_id, None)
            return
        if brain.is_auto:
            if not brain.errand:
                self._help(robot_id, brain, now_s)
            if not brain.errand and brain.machine.soc < SENT_HOME_BELOW:
                brain.go_home(by="low_charge")
            self._due_s.pop(robot_id, None)
            return
        self._help_s.pop(robot_id, None)
        if not brain.is_farm_heard or not self._may_go(robot_id, brain):
            return
        has_operator = brain.guard.active_lease > 0 and now_s - brain.operator_heard_s < OPERATOR_THERE_S
        if has_operator:
            self._due_s.pop(robot_id, None)
            return
        if robot_id in self._to_begin:  # somebody started it before the console came up
            self._to_begin.discard(robot_id)
            self._go(brain)
        elif self._jobs[robot_id].is_endless and run.status == "done":
            self._go(brain)
        elif now_s >= self._due_s.setdefault(robot_id, now_s + self._walk_s(now_s)):
            del self._due_s[robot_id]
            self._go(brain)

    def _help(self, robot_id: str, brain: Brain, now_s: float) -> None:
        """Walk to a machine that asks for a tray or for a look at it, and do that; not what a situation plays."""
        code = brain.hold_code
        if code not in HELPED or brain.faults.is_on("tray-empty"):
            self._help_s.pop(robot_id, None)
        elif now_s >= self._help_s.setdefault(robot_id, now_s + self._rng.uniform(*WALK_S)):
            del self._help_s[robot_id]
            brain.machine.seedlings = brain.machine.profile.tray
            if isinstance(brain.work, Sites):
                brain.work.person_helped()
            brain.note("mission", HELPED[code])

    def _walk_s(self, now_s: float) -> float:
        # while everything starts, links come and go, and the people still stand beside the machines
        return 3.0 if now_s < self._begun_s + STARTING_S else self._rng.uniform(*WALK_S)

    def _may_go(self, robot_id: str, brain: Brain) -> bool:
        run = brain.run
        assert run is not None
        if _may_resume(brain):
            return brain.machine.soc > SENT_HOME_BELOW
        if run.status == "loaded":
            return robot_id in self._to_begin and brain.machine.soc > SENT_HOME_BELOW
        if self._jobs[robot_id].is_endless and run.status == "done":
            return True
        has_ended = run.status == "done" or (run.status == "paused" and run.pause_code in WENT_HOME)
        return has_ended and brain.is_at_home and brain.machine.soc >= CHARGED

    def _go(self, brain: Brain) -> None:
        run = brain.run
        assert run is not None
        if _may_resume(brain):
            brain.resume(is_supervised=False)
            return
        if run.is_open:
            brain.abort()
        brain.begin(is_supervised=False)


def _may_resume(brain: Brain) -> bool:
    run = brain.run
    if run is None or run.status != "paused" or run.pause_code not in GOES_ON:
        return False
    return run.moved_m(brain.place) <= MOVED_LIMIT_M

"""Does it do what it says? It stopped and moves; it pauses and drives; its tool is on and nobody asked for it."""

from __future__ import annotations

import math

from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.robot import Mode, Pose, Robot, SafetyState
from hmi.domain.stop import STANDSTILL_LIMIT_S, StopTarget
from hmi.ingest.supervision.view import View

MOVING_MPS = 0.1  # twice the noise of a standing machine's speed
MOVED_M, ACCURACIES = 0.3, 3.0  # a fix wanders by its own accuracy
UNASKED_MPS = 0.2
AT_REST = (Mode.PAUSED, Mode.IDLE, Mode.FAULT, Mode.STOPPED)
TOOL_MUST_BE_OFF = (*AT_REST, Mode.MANUAL)


class Motion:
    """Contradictions between what the robot says it does and what is measured."""

    codes = frozenset({"moves-after-stop", "moves-unasked", "tool-on-unasked"})

    def __init__(self) -> None:
        self._latched_s: float | None = None
        self._speed_mps: float | None = None
        self._stood: Pose | None = None

    def look(self, view: View) -> Findings | None:
        """See ``Rule``."""
        robot, safety = view.robot, view.robot.safety
        if safety is None:
            return None
        is_stopped = safety.latched or safety.hardware_stop
        if is_stopped and self._latched_s is None:
            self._latched_s, self._speed_mps = safety.stamp.source_s, _speed(robot, safety)
        elif not is_stopped:
            self._latched_s = self._stood = None
        mode = robot.state.mode if robot.state is not None else Mode.UNKNOWN
        if mode is Mode.AUTO and not is_stopped:
            return NOTHING
        tool = robot.telemetry.tool if robot.telemetry is not None else None
        is_tool_on = tool is not None and tool.state == "on"
        if not is_stopped and mode not in TOOL_MUST_BE_OFF:
            return NOTHING
        found = []
        if is_stopped and (text := self._moves(robot, safety, view.now_s)):
            found.append(Finding("moves-after-stop", text))
        elif not is_stopped and mode in AT_REST and _speed(robot, safety) > UNASKED_MPS:
            speed = _speed(robot, safety)
            found.append(Finding("moves-unasked", f"It says {mode.value} and moves at {speed:.1f} m/s."))
        if is_tool_on and (is_stopped or mode in TOOL_MUST_BE_OFF):
            said = "a STOP is latched" if is_stopped else f"it says {mode.value}"
            found.append(Finding("tool-on-unasked", f"Its tool is on while {said}."))
        return tuple(found)

    def _moves(self, robot: Robot, safety: SafetyState, now_s: float) -> str:
        """Return how it moves although it should stand, empty while it may still brake."""
        assert self._latched_s is not None
        decel = robot.factsheet.decel_mps2 if robot.factsheet is not None else None
        limit_s = StopTarget(robot.id, robot.name, decel, standstill_limit_s=STANDSTILL_LIMIT_S)
        if now_s - self._latched_s < limit_s.braking_limit_s(self._speed_mps):
            return ""
        speed = _speed(robot, safety)
        if speed > MOVING_MPS:
            return f"It is stopped and moves at {speed:.1f} m/s."
        if robot.telemetry is None:
            return ""
        pose, gnss = robot.telemetry.pose, robot.telemetry.gnss
        if self._stood is None:
            self._stood = pose
        moved_m = math.hypot(pose.x_m - self._stood.x_m, pose.y_m - self._stood.y_m)
        limit_m = max(MOVED_M, ACCURACIES * gnss.accuracy_m if gnss is not None else MOVED_M)
        return f"It is stopped and was moved by {moved_m:.1f} m." if moved_m > limit_m else ""


class OldStop:
    """A stop that was not confirmed before the console restarted: it holds until the robot is seen to stand."""

    codes = frozenset({"stop-not-confirmed"})

    def look(self, view: View) -> Findings | None:
        """See ``Rule``."""
        safety, link = view.robot.safety, view.robot.link
        is_proved = safety is not None and link.is_online and safety.standstill and safety.tool_off
        return NOTHING if is_proved else None


def _speed(robot: Robot, safety: SafetyState) -> float:
    """Return the faster of what the controller and the position say."""
    by_pose = abs(robot.telemetry.pose.speed_mps) if robot.telemetry is not None else 0.0
    return max(abs(safety.speed_mps), by_pose)

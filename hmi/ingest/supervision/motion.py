"""Does it do what it says? It stopped and moves; it pauses and drives; its tool is on and nobody asked for it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.freshness import STALE_S
from hmi.domain.robot import Mode, Pose, Robot, SafetyState, Telemetry
from hmi.domain.stop import STANDSTILL_LIMIT_S, StopTarget
from hmi.ingest.supervision.view import View

MOVING_MPS = 0.1  # twice the noise of a standing machine's speed
MOVED_M, ACCURACIES = 0.3, 3.0  # a fix wanders by its own accuracy
UNASKED_MPS = 0.2
AT_REST = (Mode.PAUSED, Mode.IDLE, Mode.FAULT, Mode.STOPPED)
TOOL_MUST_BE_OFF = (*AT_REST, Mode.MANUAL)


class Sample(NamedTuple):
    """A speed and when it was measured."""

    at_s: float
    speed_mps: float


class Motion:
    """Contradictions between what the robot says it does and what is measured."""

    codes = frozenset({"moves-after-stop", "moves-unasked", "tool-on-unasked"})

    def __init__(self) -> None:
        self._latched_s: float | None = None
        self._speed_mps: float | None = None
        self._stood: Pose | None = None
        self._is_tool_on = False

    def look(self, view: View) -> Findings | None:
        """See ``Rule``; what a robot measured before it fell silent says nothing of now."""
        robot, safety = view.robot, view.robot.safety
        if safety is None or not robot.link.is_online:
            return None
        is_stopped = safety.latched or safety.hardware_stop
        mode = robot.state.mode if robot.state is not None else Mode.UNKNOWN
        if not is_stopped:
            self._latched_s = self._stood = None
            if mode not in TOOL_MUST_BE_OFF:
                self._is_tool_on = False
                return NOTHING
        telemetry = _fresh_telemetry(view)
        samples = _samples(safety, telemetry, view.now_s)
        if is_stopped and self._latched_s is None:
            self._latched_s, self._speed_mps = safety.stamp.source_s, _fastest(samples)
        if not samples:
            return None
        if telemetry is not None:
            self._is_tool_on = telemetry.tool is not None and telemetry.tool.state == "on"
        found = []
        if is_stopped and (text := self._moves(robot, samples, telemetry)):
            found.append(Finding("moves-after-stop", text))
        elif not is_stopped and mode in AT_REST and (speed := _fastest(samples) or 0.0) > UNASKED_MPS:
            found.append(Finding("moves-unasked", f"It says {mode.value} and moves at {speed:.1f} m/s."))
        if self._is_tool_on:
            said = "a STOP is latched" if is_stopped else f"it says {mode.value}"
            found.append(Finding("tool-on-unasked", f"Its tool is on while {said}."))
        return tuple(found)

    def _moves(self, robot: Robot, samples: Sequence[Sample], telemetry: Telemetry | None) -> str:
        """Return how it moves although it should stand, empty for what was measured while it might still brake."""
        assert self._latched_s is not None
        decel = robot.factsheet.decel_mps2 if robot.factsheet is not None else None
        target = StopTarget(robot.id, robot.name, decel, standstill_limit_s=STANDSTILL_LIMIT_S)
        stands_s = self._latched_s + target.braking_limit_s(self._speed_mps)
        speed = _fastest([one for one in samples if one.at_s >= stands_s]) or 0.0
        if speed > MOVING_MPS:
            return f"It is stopped and moves at {speed:.1f} m/s."
        if telemetry is None or telemetry.pose.stamp.source_s < stands_s:
            return ""
        pose, gnss = telemetry.pose, telemetry.gnss
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


def _fresh_telemetry(view: View) -> Telemetry | None:
    telemetry = view.robot.telemetry
    return telemetry if telemetry is not None and view.now_s - telemetry.pose.stamp.source_s < STALE_S else None


def _samples(safety: SafetyState, telemetry: Telemetry | None, now_s: float) -> list[Sample]:
    """Return what the controller and the position say of its speed, as far as that is fresh."""
    found = [Sample(safety.stamp.source_s, abs(safety.speed_mps))] if now_s - safety.stamp.source_s < STALE_S else []
    if telemetry is not None:
        found.append(Sample(telemetry.pose.stamp.source_s, abs(telemetry.pose.speed_mps)))
    return found


def _fastest(samples: Sequence[Sample]) -> float | None:
    return max((one.speed_mps for one in samples), default=None)

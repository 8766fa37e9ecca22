"""From what is known of a robot to one row of history, and when a row is due."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, NamedTuple

from hmi.clock import Clock
from hmi.domain.event import RobotEvent
from hmi.domain.ids import new_id
from hmi.domain.machine import height_m
from hmi.domain.robot import Mode, Robot, RobotState
from hmi.store.audit_chain import clean, plain

PERIOD_S = 1.0
HEIGHT = "@height"
"""The name by which metres above the ground are kept beside the joints; none is called so."""
JOINTS_APART_S = 2.0  # at rest they are sent twice a second
_EARLY_S = 0.1  # a robot that sends once a second is never exactly on time: a little early counts


class Sample(NamedTuple):
    """A robot as it was at one moment; made into columns by the thread that writes them."""

    robot: Robot
    at: datetime


@dataclass(slots=True)
class _Seen:
    source_s: float | None = None
    due_s: float = 0.0
    mode: Mode | None = None
    path: tuple[str, ...] = ()
    mission_id: str | None = None


class Sampler:
    """Remembers of every robot what was recorded last. Used by one thread, never waits."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._seen: dict[str, _Seen] = {}

    def sample(self, robot: Robot) -> Sample | None:
        """Return a sample if one is due: once a second, and only if the robot said something new."""
        telemetry = robot.telemetry
        if telemetry is None:
            return None
        seen = self._seen.setdefault(robot.id, _Seen())
        source_s = telemetry.pose.stamp.source_s
        is_back = seen.source_s is None or source_s < seen.source_s - PERIOD_S  # the robot's clock was set back
        if not is_back and source_s < seen.due_s - _EARLY_S:
            return None
        seen.due_s = source_s + PERIOD_S if is_back else max(seen.due_s, source_s - _EARLY_S) + PERIOD_S
        seen.source_s = source_s
        return Sample(robot, self._utc_of(source_s))

    def transition(self, robot: Robot) -> RobotEvent | None:
        """Return an event if mode or supervisor state differ from what was seen before."""
        state = robot.state
        if state is None:
            return None
        seen = self._seen.setdefault(robot.id, _Seen())
        seen.mission_id = state.order.mission_id if state.order else None
        if (state.mode, state.path) == (seen.mode, seen.path):
            return None
        before = seen.mode
        seen.mode, seen.path = state.mode, state.path
        return _mode_event(robot.id, before, state, self._utc_of(state.stamp.source_s))

    def mission_of(self, robot_id: str) -> str | None:
        """Return the mission on the robot when it was last seen."""
        seen = self._seen.get(robot_id)
        return seen.mission_id if seen else None

    def forget(self, robot_id: str) -> None:
        """Drop what is remembered of a robot that was removed."""
        self._seen.pop(robot_id, None)

    def _utc_of(self, source_s: float) -> datetime:
        return datetime.fromtimestamp(self._clock.utc().timestamp() - (self._clock.mono_s() - source_s), UTC)


def sample_columns(sample: Sample) -> dict[str, Any]:
    """Return the columns of a sample."""
    robot = sample.robot
    telemetry, state = robot.telemetry, robot.state
    assert telemetry is not None
    order = state.order if state else None
    return {
        "farm_id": robot.farm_id,
        "robot_id": robot.id,
        "mission_id": order.mission_id if order else None,
        "at": sample.at,
        "period_s": int(PERIOD_S),
        "lat_deg": _finite(telemetry.pose.lat_deg),
        "lon_deg": _finite(telemetry.pose.lon_deg),
        "theta_rad": _finite(telemetry.pose.theta_rad),
        "speed_mps": _finite(telemetry.pose.speed_mps),
        "soc": _finite(telemetry.battery.soc) if telemetry.battery else None,
        "cross_track_m": _finite(telemetry.cross_track_m),
        "gnss_accuracy_m": _finite(telemetry.gnss.accuracy_m) if telemetry.gnss else None,
        "rtt_s": _finite(robot.link.rtt_s),
        "tool": telemetry.tool.state[:16] if telemetry.tool else None,
        "mode": state.mode.value if state else None,
        "row": min(order.row, 2**31 - 1) if order else None,
        "area_done_m2": _finite(order.area_done_m2) if order else None,
        "joints": _joints(robot),
    }


def _joints(robot: Robot) -> dict[str, float] | None:
    """Joints and height heard of when the rest was; older ones would replay a posture it no longer had."""
    telemetry, body = robot.telemetry, robot.body
    if body is None or telemetry is None:
        return None
    if abs(telemetry.pose.stamp.source_s - body.stamp.source_s) > JOINTS_APART_S:
        return None
    up_m = height_m(body.gauges)
    values = body.joints if up_m is None else {**body.joints, HEIGHT: up_m}
    return {name: round(value, 4) for name, value in values.items() if math.isfinite(value)} or None


def event_columns(event: RobotEvent, farm_id: str, mission_id: str | None) -> dict[str, Any]:
    """Return the columns of an event, safe for any database."""
    return {
        "farm_id": farm_id,
        "robot_id": event.robot_id,
        "id": clean(event.event_id)[:64],
        "mission_id": mission_id,
        "at": event.at_utc,
        "kind": clean(event.kind)[:24],
        "name": clean(event.name)[:80],
        "text": clean(event.text)[:4000],
        "data": plain(event.data),
    }


def _mode_event(robot_id: str, before: Mode | None, state: RobotState, at: datetime) -> RobotEvent:
    return RobotEvent(
        robot_id,
        new_id(),
        "mode",
        state.mode.value,
        " / ".join(state.path),
        {"before": before.value if before else None, "path": list(state.path)},
        at_utc=at,
        stamp=state.stamp,
        mission_id=state.order.mission_id if state.order else None,
    )


def _finite(value: float | None) -> float | None:
    """Databases disagree about NaN; missing is missing."""
    return value if value is not None and math.isfinite(value) else None

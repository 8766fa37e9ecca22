"""Gathers what is known about a robot and a mission at one moment, for the queue to judge."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from zoneinfo import ZoneInfo

from hmi.clock import Clock
from hmi.commands.lease_service import LeaseService
from hmi.commands.ports import FleetReader
from hmi.domain.command import Action
from hmi.domain.forecast import Forecast
from hmi.domain.function_use import obstacle
from hmi.domain.planned_machine import battery_share_on
from hmi.domain.queue.arming import ArmingBook
from hmi.domain.queue.entry import Entry
from hmi.domain.queue.facts import Facts, MissionFacts, RobotFacts, Weather
from hmi.domain.queue.reason import clock_text
from hmi.domain.robot import Mode, OrderStatus, Robot
from hmi.domain.sensors.gate import Gate
from hmi.store.missions import Mission, Missions
from hmi.store.queue import QueueStore
from hmi.store.robots import Robots


@dataclass(frozen=True, slots=True)
class FactSources:
    """Where facts come from; all answer from memory.

    Args:
        sent_s: when a robot last took a mission from a person: what it told before says nothing about what it holds.
    """

    store: QueueStore
    missions: Missions
    robots: Robots
    fleet: FleetReader
    leases: LeaseService
    book: ArmingBook
    clock: Clock
    zone: ZoneInfo
    weather: Callable[[], Weather | None]
    may_replace: Callable[[str, str], bool] = lambda _robot_id, _sha256: False
    sent_s: Callable[[str], float] = lambda _robot_id: -math.inf
    treatment: Callable[[], Gate | None] = lambda: None
    forecast: Callable[[], Forecast | None] = lambda: None


class FactDesk:
    """Makes the facts of one entry."""

    def __init__(self, sources: FactSources) -> None:
        self._from = sources

    def of(self, entry: Entry, ahead: Mission | None, pause: tuple[str, datetime] | None = None) -> Facts:
        """Return what is known now; ``ahead`` is the mission whose turn is before, ``pause`` as in ``Facts``."""
        source, now = self._from, self._from.clock.utc()
        mission = source.missions.known(entry.mission_id)
        arming, ended = source.book.of(entry.robot_id), source.book.ended(entry.robot_id)
        lease = source.leases.of(entry.robot_id)
        robot = self._robot(entry.robot_id)
        return Facts(
            now=now,
            zone=source.zone,
            robot=robot,
            mission=None if mission is None else _mission(mission, source.fleet.robot(entry.robot_id)),
            ahead="" if ahead is None else ahead.name,
            is_ahead_running=ahead is not None and ahead.status.value in ("running", "resuming"),
            may_replace=robot is not None and source.may_replace(entry.robot_id, robot.held_sha256),
            frozen=self.frozen(),
            armed_until=None if arming is None else arming.until,
            disarmed="" if ended is None else ended[0],
            owner="" if lease is None or lease.holder.is_system else lease.holder.user_name,
            blackouts=source.store.blackouts(),
            weather=source.weather(),
            treatment=source.treatment() if entry.conditions.needs_treatment_weather else None,
            forecast=source.forecast(),
            pause=pause,
        )

    def frozen(self) -> str:
        """Return the sentence why the whole queue stands still, empty if it does not."""
        freeze = self._from.store.freeze()
        if freeze is None or not freeze.is_frozen:
            return ""
        at = clock_text(freeze.at, self._from.clock.utc(), self._from.zone)
        by = f" by {freeze.by}" if freeze.by else ""
        return f"Frozen since STOP ALL{by} at {at}. A person must release the queue."

    def _robot(self, robot_id: str) -> RobotFacts | None:
        entry, robot = self._from.robots.get(robot_id), self._from.fleet.robot(robot_id)
        if entry is None:
            return None
        if robot is None:
            return RobotFacts(entry.name, entry.is_unattended_allowed)
        return _robot(robot, self._from, is_allowed=entry.is_unattended_allowed)


def _robot(robot: Robot, source: FactSources, *, is_allowed: bool) -> RobotFacts:
    now_s = source.clock.mono_s()
    state, safety, telemetry = robot.state, robot.safety, robot.telemetry
    is_known = state is not None and state.stamp.source_s > source.sent_s(robot.id)
    order = state.order if state is not None else None
    held = source.missions.known(order.mission_id) if order is not None else None
    fault = next((f for f in state.faults if f.level in ("critical", "high")), None) if state is not None else None
    return RobotFacts(
        name=robot.name,
        is_unattended_allowed=is_allowed,
        link_age_s=None if robot.link.challenge_s is None else now_s - robot.link.challenge_s,
        safety_age_s=None if safety is None else now_s - safety.stamp.source_s,
        state_age_s=now_s - state.stamp.source_s if state is not None and is_known else None,
        stop=_stop(robot),
        mode=Mode.UNKNOWN if state is None else state.mode,
        order=OrderStatus.NONE if order is None else order.status,
        held_id="" if order is None or order.status is OrderStatus.NONE else order.mission_id,
        held_sha256="" if order is None else order.sha256,
        held_name="" if held is None else held.name,
        trouble="" if fault is None else fault.text,
        hold="" if state is None or state.hold is None else state.hold.text,
        value_age_s=None if telemetry is None else now_s - telemetry.pose.stamp.source_s,
        soc=None if telemetry is None or telemetry.battery is None else telemetry.battery.soc,
        fix=None if telemetry is None or telemetry.gnss is None else telemetry.gnss.fix,
        cannot=obstacle(robot, Action.START),
    )


def _stop(robot: Robot) -> str:
    safety = robot.safety
    if safety is None:
        return ""
    if safety.hardware_stop:
        return "The red button on the machine is pressed. Release it there first."
    if not safety.latched:
        return ""
    names = " and ".join(dict.fromkeys(p.by for p in safety.presses if not p.is_reset and p.by))
    return f"{names} pressed STOP. Reset it first." if names else "STOP was pressed. Reset it first."


def _mission(mission: Mission, robot: Robot | None) -> MissionFacts:
    share = battery_share_on(mission.statistics, None if robot is None else robot.factsheet)
    return MissionFacts(mission.name, mission.status, mission.sha256, mission.is_supervised, share)

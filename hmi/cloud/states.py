"""Robots as the cloud shall see them now: the newest only, what has changed only."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import timedelta
from typing import NamedTuple

from backend_clients.ngsi.query import Query
from hmi.clock import Clock
from hmi.domain.family import Family
from hmi.domain.robot import Robot
from hmi.fiware.leftover import gone_from
from hmi.fiware.robot import robot_removed, state_message
from hmi.fiware.uav import uav_entity
from hmi.fiware.urn import OWN, KeyValues, Urns
from hmi.store.fleet import FleetStore

SIGN_OF_LIFE_S = 10.0  # a robot that stands is told again so often, so that the cloud knows it is there
LEFT_AFTER_S = 30.0  # until then every robot that is on was heard
LEFT_AGAIN_S = 300.0  # after a question that got no answer
MOVED_DEG = 4e-7  # some 4 cm: less is noise of the fix
_MODELS = ("StateMessage", "UnmannedAerialVehicle")
_TIMES = frozenset({"commandTime", "observedAt"})
_NOISE = _TIMES | {"location", "pose", "accuracy", "battery", "fuel", "speed", "groundSpeed"}


class Report(NamedTuple):
    """One robot to tell of.

    Args:
        entity: what changed since it was told last, with id, type and time; whole at first.
        whole: everything, to compare with next time; empty if the robot was removed.
        source_s, received_s: of its newest values, on the console's clock; ``None`` if it has told no position.
        gone: attributes that it had and has no more.
    """

    robot_id: str
    entity: KeyValues
    whole: KeyValues
    source_s: float | None
    received_s: float | None
    gone: frozenset[str] = frozenset()


class RobotStates:
    """Watches the fleet; ``told`` notes what arrived.

    Args:
        fleet: the live store.
        urns: names of the farm's entities.
    """

    def __init__(self, fleet: FleetStore, urns: Urns, clock: Clock) -> None:
        self._fleet, self._urns, self._clock = fleet, urns, clock
        self._revision = 0
        self._waiting: dict[str, None] = {}
        self._told: dict[str, tuple[KeyValues, float]] = {}
        self._left_s: float | None = clock.mono_s() + LEFT_AFTER_S

    def reports(self, limit: int) -> list[Report]:
        """Return what to tell now, robots that waited longest first; until told, they come again."""
        changes = self._fleet.since(self._revision)
        self._revision = changes.revision
        for robot_id in (*changes.robots, *changes.removed):
            self._waiting.setdefault(robot_id)
        found = []
        for robot_id in list(self._waiting):
            report = self._report(robot_id)
            if report is None:
                del self._waiting[robot_id]
                continue
            found.append(report)
            if len(found) == limit:
                break
        return found

    def told(self, reports: Iterable[Report]) -> None:
        """Note that these arrived."""
        now_s = self._clock.mono_s()
        for report in reports:
            self._waiting.pop(report.robot_id, None)
            if report.whole:
                self._told[report.robot_id] = report.whole, now_s
            else:
                self._told.pop(report.robot_id, None)

    def forget(self) -> None:
        """Tell everything again: the broker may have lost it, or be another one."""
        self._told.clear()
        self._revision = 0
        self._left_s = self._clock.mono_s() + LEFT_AFTER_S

    def wanted(self) -> Query | None:
        """Return what to ask of robots that an earlier run told of, once when it is time; see ``found``."""
        is_time = self._left_s is not None and self._clock.mono_s() >= self._left_s
        return Query(types=_MODELS) if is_time else None

    def left_later(self) -> None:
        """Ask again later: the question got no answer."""
        self._left_s = self._clock.mono_s() + LEFT_AGAIN_S

    def found(self, entities: Iterable[KeyValues]) -> None:
        """Take what the cloud has of robots; those that this run has told nothing of are looked at."""
        self._left_s = None
        for one in entities:
            robot_id = self._urns.name_of(one["type"], one["id"])
            if robot_id is not None and isinstance(one.get(OWN), dict):
                self._told.setdefault(robot_id, (one, float("-inf")))
                self._waiting.setdefault(robot_id)

    def _report(self, robot_id: str) -> Report | None:
        robot = self._fleet.robot(robot_id)
        before, at_s = self._told.get(robot_id, (None, 0.0))
        if robot is None or not robot.is_registered:
            is_told = before is None or "removed" in before[OWN]
            return Report(robot_id, robot_removed(before), {}, None, None) if before and not is_told else None
        if robot.telemetry is None and robot.state is None:
            return None if before is None else _silent(robot_id, before)
        whole = self._entity(robot)
        stamp = robot.telemetry.pose.stamp if robot.telemetry is not None else None
        entity, gone = whole, gone_from(whole)
        if before is not None and before["id"] == whole["id"]:
            changed = {key: value for key, value in whole.items() if before.get(key) != value}
            gone = gone_from(whole, before)
            if not gone and not _matters(changed, before, whole) and self._clock.mono_s() - at_s < SIGN_OF_LIFE_S:
                return None
            entity = {"id": whole["id"], "type": whole["type"], **changed}
        source_s, received_s = (None, None) if stamp is None else (stamp.source_s, stamp.received_s)
        return Report(robot_id, entity, whole, source_s, received_s, gone)

    def _entity(self, robot: Robot) -> KeyValues:
        now_s = self._clock.mono_s()
        stamp = robot.telemetry.pose.stamp if robot.telemetry is not None else None
        stamp = stamp or (robot.state.stamp if robot.state is not None else None)
        at = self._clock.utc() - timedelta(seconds=max(0.0, now_s - stamp.source_s) if stamp is not None else 0.0)
        is_uav = robot.factsheet is not None and robot.factsheet.family is Family.UAV
        return uav_entity(self._urns, robot, at) if is_uav else state_message(self._urns, robot, at)


def _silent(robot_id: str, before: KeyValues) -> Report | None:
    """Return that a robot is not heard in this run, ``None`` if that is known; the rest stays with its time."""
    if not before[OWN].get("online"):
        return None
    own = {**before[OWN], "online": False}
    patch = {"id": before["id"], "type": before["type"], OWN: own}
    return Report(robot_id, patch, {**before, OWN: own}, None, None)


def _matters(changed: KeyValues, before: KeyValues, now: KeyValues) -> bool:
    if changed.keys() - _NOISE:
        return True
    here, there = now.get("location"), before.get("location")
    if here is None or there is None:
        return here is not there
    pairs = zip(here["coordinates"], there["coordinates"], strict=True)
    return any(abs(one - other) > MOVED_DEG for one, other in pairs)

"""The queues as screens show them; from memory, so that it may be asked often."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from zoneinfo import ZoneInfo

from hmi.clock import Clock
from hmi.commands.ports import FleetReader
from hmi.commands.queue_handover import held_unstarted
from hmi.commands.queue_runner import QueueRunner
from hmi.commands.weather import WeatherBoard
from hmi.domain.queue.arming import ArmingBook
from hmi.domain.queue.blackout import Blackout
from hmi.domain.queue.entry import Entry
from hmi.domain.queue.reason import clock_text
from hmi.domain.role import Permission
from hmi.presenters.queue import arming_row, blackout_row, entry_row, utc_text, waiting_row, weather_row
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.errors import NotFound
from hmi.store.missions import Mission, Missions
from hmi.store.queue import Freeze, QueueStore
from hmi.store.robots import RegisteredRobot, Robots

Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class ViewParts:
    """What the view reads.

    Args:
        may_replace: as in ``QueueHandover``.
    """

    store: QueueStore
    missions: Missions
    robots: Robots
    fleet: FleetReader
    book: ArmingBook
    runner: QueueRunner
    may_replace: Callable[[str, str], bool]
    weather: WeatherBoard
    authorize: Authorize
    clock: Clock
    zone: ZoneInfo


class QueueView:
    """Reads everything about the queues for one person."""

    def __init__(self, parts: ViewParts) -> None:
        self._parts = parts

    def clock(self, at: datetime) -> str:
        """Return a time on the farm's clock."""
        return clock_text(at, self._parts.clock.utc(), self._parts.zone)

    def blackout(self, session: SessionInfo, window_id: str) -> Blackout:
        """Return one window; raises ``NotFound``."""
        self._parts.authorize(session, Permission.WATCH)
        for one in self._parts.store.blackouts():
            if one.id == window_id:
                return one
        raise NotFound(f"there is no window {window_id!r}")

    def whole(self, session: SessionInfo) -> Row:
        """Return every queue of the farm."""
        parts = self._parts
        parts.authorize(session, Permission.WATCH)
        return {
            "now_utc": utc_text(parts.clock.utc()),
            "zone": parts.zone.key,
            "frozen": _frozen(parts.store.freeze()),
            "weather": weather_row(parts.weather.latest),
            "robots": [self._robot(one) for one in parts.robots.all()],
            "entries": [self._entry(one) for one in parts.store.entries()],
            "ended": [self._entry(one) for one in parts.store.ended()],
            "blackouts": [blackout_row(one) for one in parts.store.blackouts()],
        }

    def _robot(self, robot: RegisteredRobot) -> Row:
        parts, ended = self._parts, self._parts.book.ended(robot.id)
        return {
            "robot_id": robot.id,
            "name": robot.name,
            "revision": parts.store.revision(robot.id),
            "is_unattended_allowed": robot.is_unattended_allowed,
            "arming": arming_row(parts.book.of(robot.id)),
            "disarmed": None if ended is None else {"why": ended[0], "utc": utc_text(ended[1])},
            "now": self._now(robot.id),
            "holds": self._holds(robot.id),
        }

    def _holds(self, robot_id: str) -> Row | None:
        """Return the unstarted mission that the queue does not replace; its own entry waits for nobody but itself."""
        parts, robot = self._parts, self._parts.fleet.robot(robot_id)
        held = None if robot is None else held_unstarted(robot)
        if held is None or parts.may_replace(robot_id, held.sha256):
            return None
        entries = parts.store.entries(robot_id)
        is_queued = any(one.mission_id == held.mission_id for one in entries)
        if is_queued and not any(self._waits_for_held(one) for one in entries):
            return None
        mission = parts.missions.known(held.mission_id)
        return {"mission_id": held.mission_id, "name": held.mission_id if mission is None else mission.name}

    def _waits_for_held(self, entry: Entry) -> bool:
        shown = self._parts.runner.shown(entry.id)
        return shown is not None and shown.verdict.waiting.code == "holds_other"

    def _now(self, robot_id: str) -> Row | None:
        robot = self._parts.fleet.robot(robot_id)
        order = robot.state.order if robot is not None and robot.state is not None else None
        if order is None or order.status.value not in ("running", "paused"):
            return None
        mission = self._parts.missions.known(order.mission_id)
        return {
            "mission_id": order.mission_id,
            "name": order.mission_id if mission is None else mission.name,
            "status": order.status.value,
            "remaining_s": order.remaining_s,
        }

    def _entry(self, entry: Entry) -> Row:
        shown, mission = self._parts.runner.shown(entry.id), self._parts.missions.known(entry.mission_id)
        waiting = None
        if shown is not None and entry.is_open:
            waiting = waiting_row(shown.verdict, shown.since)
        return {**entry_row(entry), **_mission(mission), "waiting": waiting}


def _mission(mission: Mission | None) -> Row:
    if mission is None:
        return {"name": "Deleted mission", "field_name": "", "status": "", "is_supervised": True, "duration_s": None}
    return {
        "name": mission.name,
        "field_name": mission.field_name,
        "status": mission.status.value,
        "is_supervised": mission.is_supervised,
        "duration_s": mission.statistics.get("duration_s"),
    }


def _frozen(freeze: Freeze | None) -> Row | None:
    if freeze is None or not freeze.is_frozen:
        return None
    return {"by": freeze.by, "utc": utc_text(freeze.at)}

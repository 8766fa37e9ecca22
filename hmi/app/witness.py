"""Whoever keeps account of robots: recorder, tracking of missions, STOP for those that come back."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import TypeVar

from hmi.clock import Clock
from hmi.domain.robot import Robot
from hmi.store.fleet import FleetStore
from hmi.store.robot_record import Part

FAST = frozenset({Part.TELEMETRY, Part.LINK})
LOOK_S = 0.5  # telemetry and heartbeats come 15 times a second and robot; a sample a second is kept
See = Callable[[Robot], None]
T = TypeVar("T")
log = logging.getLogger(__name__)


class FleetWitness:
    """Shows every robot that changed to those who keep account, no more often than they need.

    A change of state or safety is shown at once and never skipped; fast values alone twice a second. What somebody
    raises over one robot is logged: changes are told once, and the others have to see it and the other robots.

    Args:
        on_return: told the id of a robot that is heard again.
        see: called with each robot shown; on the event loop, must not wait.
    """

    def __init__(self, fleet: FleetStore, clock: Clock, on_return: Callable[[str], None], see: Sequence[See]) -> None:
        self._fleet, self._clock, self._on_return, self._see = fleet, clock, on_return, see
        self._revision = 0
        self._online: set[str] = set()
        self._looked_s: dict[str, float] = {}

    def start(self) -> Callable[[], None]:
        """Begin to look; returns what ends it."""
        return self._fleet.subscribe(self._changed)

    def _changed(self) -> None:
        changes, now_s = self._fleet.since(self._revision), self._clock.mono_s()
        self._revision = changes.revision
        for robot_id in changes.removed:
            self._looked_s.pop(robot_id, None)
            self._online.discard(robot_id)
        for robot_id, parts in changes.robots.items():
            self._notice_return(robot_id)
            if parts <= FAST and now_s - self._looked_s.get(robot_id, -LOOK_S) < LOOK_S:
                continue
            self._looked_s[robot_id] = now_s
            robot = self._fleet.robot(robot_id)
            if robot is not None and robot.is_registered:
                for see in self._see:
                    self._tell(see, robot)

    def _notice_return(self, robot_id: str) -> None:
        if not self._fleet.is_online(robot_id):
            self._online.discard(robot_id)
        elif robot_id not in self._online and self._fleet.registration(robot_id) is not None:
            self._online.add(robot_id)
            self._tell(self._on_return, robot_id)

    def _tell(self, who: Callable[[T], None], what: T) -> None:
        try:
            who(what)
        except Exception:
            log.exception("whoever keeps account of robots failed")

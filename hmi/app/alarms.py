"""Alarms in the console: supervision, live alarms and everybody who hears of them, plugged together."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import Any

from fastapi import APIRouter

from hmi.api.alarms import AlarmRoutes, alarm_routes
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.commands.alarm_desk import AlarmDesk
from hmi.commands.ports import LaneEvent
from hmi.domain.alarm.alarm import CONSOLE
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.conditions import Change, Conditions
from hmi.domain.alarm.live_alarm import Step
from hmi.domain.event import RobotEvent
from hmi.domain.robot import Robot
from hmi.ingest.supervision.faults import Faults
from hmi.ingest.supervision.link import Link
from hmi.ingest.supervision.view import MissionOf, Rule
from hmi.ingest.supervision.watch import Watch
from hmi.presenters import alarms as shown
from hmi.security.authorization import Authorize
from hmi.settings import Settings
from hmi.store.alarms import AlarmStore
from hmi.store.fleet import FleetStore

ROUND_S = 1.0
SHIFT = timedelta(hours=8)
log = logging.getLogger(__name__)


class AlarmRoom:
    """Everything of alarms of one farm; also the source of lane topic ``alarms``."""

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        records: Records,
        fleet: FleetStore,
        authorize: Authorize,
        mission_of: MissionOf,
        on_event: LaneEvent,
    ) -> None:
        self._clock, self._fleet, self._on_event = clock, fleet, on_event
        types = catalogue()
        self.store = AlarmStore(clock, types)
        self.store.listeners.append(self._told)
        conditions = Conditions(types.__getitem__)
        self.watch = Watch(fleet, clock, conditions, self._rules, mission_of, self._apply)
        self.desk = AlarmDesk(self.store, records.audit, authorize, clock, self._is_robot, self._shift_end)
        self._task: asyncio.Task[None] | None = None

    @property
    def revision(self) -> int:
        """See ``AlarmSource``."""
        return self.store.revision

    def entries_since(self, revision: int) -> dict[str, dict[str, Any] | None]:
        """See ``AlarmSource``."""
        changed = self.store.since(revision)
        return {i: None if one is None else shown.entry(one, self.name_of(one.alarm.key.source))
                for i, one in changed.items()}  # fmt: skip

    def summary(self) -> dict[str, Any]:
        """See ``AlarmSource``."""
        flood, now_s = self.store.flood(), self._clock.mono_s()
        since = None if flood is None else (self._clock.utc() - timedelta(seconds=now_s - flood[0]), flood[1])
        return shown.summary(self.store.counts(), since, self.store.checked_s)

    def name_of(self, source: str) -> str:
        """Return what people call a robot, a station or the console."""
        entry = self._fleet.registration(source)
        return shown.name_of(source, entry.name if entry is not None else None)

    def routes(self) -> APIRouter:
        """Return the REST routes."""
        return alarm_routes(AlarmRoutes(self.store, self.desk, self._clock, self.name_of))

    def start(self) -> None:
        """Begin to look once a second."""
        self._task = asyncio.create_task(self._rounds(), name="alarms")

    async def stop(self) -> None:
        """End."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)

    def see(self, robot: Robot) -> None:
        """Look at a robot that changed."""
        self.watch.see(robot)

    def see_event(self, event: RobotEvent) -> None:
        """Take an event of a robot."""
        self.watch.see_event(event)

    def round(self) -> None:
        """Look at everything once."""
        self.watch.sweep()
        self.store.pass_time()

    async def _rounds(self) -> None:
        while True:
            try:
                self.round()
            except Exception:  # the next round must come whatever one value is
                log.exception("a round of the supervision failed")
            await asyncio.sleep(ROUND_S)

    def _rules(self) -> Sequence[Rule]:
        return (Link(), Faults(_ROBOT_CODES))

    def _apply(self, changes: list[Change]) -> None:
        if changes:
            self.store.apply(changes)

    def _told(self, step: Step) -> None:
        self._on_event(shown.event(step, self.name_of(step.live.alarm.key.source)))

    def _is_robot(self, source: str) -> bool:
        return source != CONSOLE and self._fleet.registration(source) is not None

    def _shift_end(self) -> datetime:
        return self._clock.utc() + SHIFT


_ROBOT_CODES = frozenset(
    {"hardware-stop", "person-ahead", "tool-interlock", "rtk-float", "battery-low", "battery-very-low", "battery-empty"}
)

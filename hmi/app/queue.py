"""The queue of missions in the console: everything of it, plugged together."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from fastapi import APIRouter

from hmi.api.queue import QueueRoutes, queue_routes
from hmi.api.queue_view import QueueView, ViewParts
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.commands.desk import CommandDesk
from hmi.commands.gate import Gate
from hmi.commands.mission_book import MissionBook
from hmi.commands.ports import LaneEvent
from hmi.commands.queue_arming import ArmingParts, QueueArming
from hmi.commands.queue_book import QueueBook, QueueParts
from hmi.commands.queue_facts import FactDesk, FactSources
from hmi.commands.queue_freeze import QueueFreeze
from hmi.commands.queue_handover import HandoverParts, QueueHandover
from hmi.commands.queue_life import LifeParts, QueueLife
from hmi.commands.queue_runner import QueueRunner, RunnerParts
from hmi.commands.weather import WeatherBoard
from hmi.domain.forecast import Forecast
from hmi.domain.freshness import TickRing
from hmi.domain.queue.arming import ArmingBook
from hmi.domain.robot import Robot
from hmi.domain.role import Permission, may
from hmi.domain.sensors.gate import Gate as TreatmentGate
from hmi.security.authorization import Authorize
from hmi.settings import Settings
from hmi.store.fleet import FleetStore
from hmi.store.queue import QueueStore
from hmi.store.queue_armings import QueueArmings

log = logging.getLogger(__name__)


class QueueDesk:
    """Queues, arming, freeze and runner of one farm."""

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        records: Records,
        fleet: FleetStore,
        ticks: TickRing,
        desk: CommandDesk,
        missions: MissionBook,
        authorize: Authorize,
        on_event: LaneEvent,
    ) -> None:
        self._records, self._farm_id, self._clock = records, settings.farm_id, clock
        self._fleet, self._missions, self._desk = fleet, missions, desk
        self._authorize, self._on_event = authorize, on_event
        self._zone = farm_zone(settings.time_zone)
        self.store = QueueStore(records.database, settings.farm_id, clock)
        self.weather = WeatherBoard(clock, authorize, settings.farm_id)
        self.treatment: Callable[[], TreatmentGate | None] = lambda: None
        self.forecast: Callable[[], Forecast | None] = lambda: None
        gate = Gate(fleet, ticks, clock, authorize)
        self.arming = self._make_arming(gate)
        self.freeze = QueueFreeze(
            self.store,
            self.arming,
            gate,
            authorize,
            records.audit,
            clock,
            on_event,
            farm_id=settings.farm_id,
            robots=fleet.robots,
        )
        missions.queue_of = self.store.robot_of
        self.book = self._make_book()
        self.handover = self._make_handover()
        desk.missions.on_sent(self.handover.sent)
        self._life = self._make_life()
        self.runner = self._make_runner()
        self._view = self._make_view()

    def _make_arming(self, gate: Gate) -> QueueArming:
        parts = ArmingParts(
            store=self.store,
            armings=QueueArmings(self._records.database, self._farm_id),
            robots=self._records.robots,
            database=self._records.database,
            gate=gate,
            leases=self._desk.leases,
            audit=self._records.audit,
            clock=self._clock,
            zone=self._zone,
            farm_id=self._farm_id,
            on_event=self._on_event,
        )
        return QueueArming(parts, ArmingBook())

    def _make_book(self) -> QueueBook:
        return QueueBook(
            QueueParts(
                store=self.store,
                missions=self._records.missions,
                book=self._missions,
                robots=self._records.robots,
                database=self._records.database,
                audit=self._records.audit,
                authorize=self._authorize,
                clock=self._clock,
                on_changed=self._changed,
            )
        )

    def _make_handover(self) -> QueueHandover:
        return QueueHandover(
            HandoverParts(
                store=self.store,
                missions=self._records.missions,
                fleet=self._fleet,
                database=self._records.database,
                audit=self._records.audit,
                authorize=self._authorize,
                on_changed=self._changed,
                clock=self._clock,
            )
        )

    def _make_runner(self) -> QueueRunner:
        sources = FactSources(
            store=self.store,
            missions=self._records.missions,
            robots=self._records.robots,
            fleet=self._fleet,
            leases=self._desk.leases,
            book=self.arming.book,
            clock=self._clock,
            zone=self._zone,
            weather=lambda: self.weather.latest,
            may_replace=self.handover.may_replace,
            sent_s=self.handover.sent_s,
            treatment=lambda: self.treatment(),
            forecast=lambda: self.forecast(),
        )
        parts = RunnerParts(
            store=self.store,
            missions=self._records.missions,
            facts=FactDesk(sources),
            life=self._life,
            arming=self.arming,
            sender=self._desk.missions,
            commands=self._desk.commands,
            clock=self._clock,
            on_event=self._on_event,
            farm_id=self._farm_id,
            may_still_start=self._may_still_start,
            on_sent=self.handover.sent_by_queue,
        )
        return QueueRunner(parts)

    def _make_life(self) -> QueueLife:
        return QueueLife(
            LifeParts(
                store=self.store,
                missions=self._records.missions,
                book=self._missions,
                arming=self.arming,
                database=self._records.database,
                fleet=self._fleet,
                audit=self._records.audit,
                clock=self._clock,
                zone=self._zone,
                on_event=self._on_event,
                may_replace=self.handover.may_replace,
            )
        )

    def _make_view(self) -> QueueView:
        return QueueView(
            ViewParts(
                store=self.store,
                missions=self._records.missions,
                robots=self._records.robots,
                fleet=self._fleet,
                book=self.arming.book,
                runner=self.runner,
                may_replace=self.handover.may_replace,
                weather=self.weather,
                authorize=self._authorize,
                clock=self._clock,
                zone=self._zone,
            )
        )

    def routes(self) -> APIRouter:
        """Return the REST routes."""
        return queue_routes(QueueRoutes(self.book, self.arming, self.freeze, self.handover, self._view, self.weather))

    async def prepare(self) -> None:
        """Read the queues into memory; nothing is armed."""
        await self._records.database.run(self.store.load)
        await self.arming.load()
        gone = {one.robot_id for one in self.store.entries() if self._records.robots.get(one.robot_id) is None}
        await self.book.robots_removed(gone)
        await self._life.mend(self._farm_id)

    def start(self) -> None:
        """Begin to work through the queues."""
        self.runner.start()

    async def stop(self) -> None:
        """Disarm everything and end."""
        await self.runner.close()
        await self.arming.close()

    def stopped(self, robot_id: str, by: str) -> None:
        """STOP was pressed for a robot."""
        self.arming.stopped(robot_id, by)

    def see(self, robot: Robot) -> None:
        """Take note of what a robot's safety controller says; on the event loop, does not wait."""
        if robot.is_registered and robot.safety is not None and (robot.safety.latched or robot.safety.hardware_stop):
            self.arming.observe(robot)
            self.freeze.observe(robot)

    def _changed(self, robot_id: str, by: str) -> None:
        self.arming.end(robot_id, f"{by} changed the queue.")
        self._on_event({"kind": "queue", "robot": robot_id, "what": "changed", "by": by})

    async def _may_still_start(self, user_id: str) -> bool:
        user = await self._records.database.run(self._records.users.get, user_id)
        is_ours = user is not None and user.farm_id == self._farm_id and user.is_active
        return is_ours and user is not None and may(user.role, Permission.START)


def farm_zone(name: str) -> ZoneInfo:
    """Return the farm's time zone: as set, else the machine's, else UTC."""
    link = os.path.realpath("/etc/localtime")
    machine = link.split("zoneinfo/", 1)[1] if "zoneinfo/" in link else ""
    for candidate in (name, os.getenv("TZ", ""), machine):
        if not candidate:
            continue
        try:
            return ZoneInfo(candidate)
        except (ZoneInfoNotFoundError, ValueError, OSError):
            log.warning("there is no time zone %r", candidate)
    return ZoneInfo("UTC")

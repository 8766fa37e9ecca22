"""The fleet screen's services in the console: group orders, groups, duty, wall screens, today's figures."""

from __future__ import annotations

import asyncio
import logging
from datetime import date, datetime
from pathlib import Path

from fastapi import APIRouter

from hmi.api.fleet import FleetRoutes, fleet_routes
from hmi.api.fleet_duty import DutyRoutes, duty_routes
from hmi.app.queue import farm_zone
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.commands.desk import CommandDesk
from hmi.commands.fleet_actions import FleetActions
from hmi.commands.fleet_duty import DutyDesk, DutyParts
from hmi.commands.fleet_groups import FleetGroupBook
from hmi.commands.ledger import CommandResult, Ticket
from hmi.commands.ports import LaneEvent
from hmi.domain.command import Action
from hmi.domain.event import RobotEvent
from hmi.domain.fleet_day import FleetDay
from hmi.security.authorization import Authorize
from hmi.settings import Settings
from hmi.store.fleet import FleetStore
from hmi.store.fleet_day import read_day, write_day

LOOK_S = 2.0
KEEP_S = 30.0  # a power cut costs half a minute of the day's sums
DAY_FILE = Path("run") / "fleet-day.json"
ROBOTS_A_STEP = 100  # between steps others get the event loop
INTERVENTIONS = frozenset(
    {Action.RESUME.value, Action.PAUSE.value, Action.ABORT.value, Action.RETURN_HOME.value, Action.DRIVE_OPEN.value}
    | {"reset"}
)
"""What a person does in the work of a robot. Starting a mission is the plan, not an intervention."""
log = logging.getLogger(__name__)


class FleetDesk:
    """Everything of the fleet screen that is not one robot's."""

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        records: Records,
        fleet: FleetStore,
        desk: CommandDesk,
        authorize: Authorize,
        on_event: LaneEvent,
    ) -> None:
        self._clock, self._records, self._fleet = clock, records, fleet
        self._zone = farm_zone(settings.time_zone)
        self._kept, self._kept_s = settings.data / DAY_FILE, clock.mono_s()
        self.day = FleetDay()
        self.actions = FleetActions(desk.commands, desk.missions, desk.leases.of, records.audit)
        self.groups = FleetGroupBook(records.fleet_groups, records.database, records.audit, authorize, on_event)
        self.duty = DutyDesk(
            DutyParts(
                duties=records.duties,
                database=records.database,
                people=records.users.all,
                farm_id=settings.farm_id,
                is_robot=lambda robot_id: records.robots.get(robot_id) is not None,
                name_of=self._name_of,
                audit=records.audit,
                authorize=authorize,
                clock=clock,
                on_event=on_event,
            )
        )
        records.accounts.on_changed.append(self.duty.let_go)
        desk.ledger.when_settled(self._settled)
        self._task: asyncio.Task[None] | None = None

    def routes(self) -> list[APIRouter]:
        """Return the REST routes."""
        return [
            fleet_routes(FleetRoutes(self.actions, self.groups, self.day.figures)),
            duty_routes(DutyRoutes(self.duty, self._records.walls, self._records.tokens)),
        ]

    async def prepare(self) -> None:
        """Let wall screens that are valid open their sessions, and go on with duties and today's sums."""
        await self.duty.let_go()
        await self._records.walls.load()
        self.day.restore(await asyncio.to_thread(read_day, self._kept), self._today())

    def start(self) -> None:
        """Begin to add up the day."""
        self._task = asyncio.create_task(self._run(), name="fleet-day")

    async def stop(self) -> None:
        """End."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
            self._task = None
            await self._keep()

    def see_event(self, event: RobotEvent) -> None:
        """Count a tree, unless a robot tells late of another day."""
        today = self._today()
        if self._fleet.registration(event.robot_id) is not None and self._day_of(event.at_utc) == today:
            self.day.see_event(event, today)

    def _today(self) -> date:
        return self._day_of(self._clock.utc())

    def _day_of(self, at: datetime) -> date:
        return at.astimezone(self._zone).date()

    def _name_of(self, robot_id: str) -> str:
        entry = self._fleet.registration(robot_id)
        return entry.name if entry is not None else robot_id

    def _settled(self, ticket: Ticket, result: CommandResult) -> None:
        is_person = ticket.actor.user_id != "queue"
        if result.is_accepted and is_person and ticket.what in INTERVENTIONS:
            self.day.intervened(self._today())

    async def _run(self) -> None:
        while True:
            try:
                await self._look()
                if self._clock.mono_s() - self._kept_s >= KEEP_S:
                    await self._keep()
            except Exception:
                log.exception("the day's figures could not be added up; trying again")
            await asyncio.sleep(LOOK_S)

    async def _keep(self) -> None:
        self._kept_s = self._clock.mono_s()
        try:
            await asyncio.to_thread(write_day, self._kept, self.day.kept())
        except OSError as error:
            log.warning("today's figures are not kept: %s", error.strerror)

    async def _look(self) -> None:
        now_s, today = self._clock.mono_s(), self._today()
        for count, robot_id in enumerate(self._fleet.registered_ids(), 1):
            robot = self._fleet.robot(robot_id)
            if robot is not None:
                self.day.see(robot, now_s, today)
            if count % ROBOTS_A_STEP == 0:
                await asyncio.sleep(0)

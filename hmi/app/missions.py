"""Missions in the console: the book, its tracking, the planner's process and, in the demo, the seed."""

from __future__ import annotations

from fastapi import APIRouter

from hmi.api.drafts import draft_routes
from hmi.api.mission_rest import rest_routes
from hmi.api.missions import mission_routes
from hmi.api.templates import template_routes
from hmi.app.mission_facts import MissionFactsBook
from hmi.app.planner import PlannerRoom
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.commands.checklist_desk import ChecklistDesk
from hmi.commands.desk import CommandDesk
from hmi.commands.draft_book import DraftBook
from hmi.commands.map_watch import MapWatch
from hmi.commands.mission_acts import MissionActs
from hmi.commands.mission_book import MissionBook, MissionParts
from hmi.commands.mission_rest import MissionRests
from hmi.commands.ports import LaneEvent
from hmi.commands.rest_sources import RestParts
from hmi.commands.start_rules import MissionStartRules
from hmi.commands.template_book import TemplateBook
from hmi.demo.seed import DemoSeed, SeedParts
from hmi.domain.mission import MissionChange
from hmi.presenters.operate import MissionTitle
from hmi.security.authorization import Authorize
from hmi.security.demo_users import seed_demo_users
from hmi.settings import Settings
from hmi.store.audit_chain import AuditEntry
from hmi.store.fleet import FleetStore
from hmi.store.mission_tracking import MissionTracking
from hmi.store.missions import Mission


class MissionDesk:
    """Everything about stored missions, with what runs beside it."""

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        records: Records,
        fleet: FleetStore,
        authorize: Authorize,
        on_event: LaneEvent,
    ) -> None:
        self._on_event = on_event
        self._settings, self._clock, self._records, self._fleet = settings, clock, records, fleet
        self.planner = PlannerRoom(settings, clock)
        self._seed: DemoSeed | None = None
        self.book = MissionBook(
            MissionParts(
                missions=records.missions,
                features=records.features,
                database=records.database,
                fleet=fleet,
                planner=self.planner,
                audit=records.audit,
                authorize=authorize,
                clock=clock,
                maps=records.maps,
            )
        )
        self.tracking = MissionTracking(
            records.missions, records.database, settings.farm_id, self._moved, self.book.revisions
        )
        self.acts = MissionActs(records.missions, records.database, fleet, clock, self.tracking.acted, self._moved)
        self.facts = MissionFactsBook(
            records.missions, records.features, MapWatch(records.maps, records.database), records.database, fleet
        )
        self.checklists = ChecklistDesk(
            records.checklists,
            records.missions,
            records.database,
            fleet,
            records.audit,
            authorize,
            clock,
            is_required=settings.checklist_required,
            valid_hours=settings.checklist_hours,
        )
        self.start_rules = MissionStartRules(
            records.missions,
            records.checklists,
            lambda: self.checklists.is_required,
            records.robots.may_run_alone,
            self.facts.in_flight,
        )
        self._authorize = authorize
        self.drafts = DraftBook(records.missions, records.features, records.database, records.audit, authorize, clock)
        self.templates = TemplateBook(records.templates, records.database, records.audit, authorize)

    def title_of(self, mission_id: str) -> MissionTitle | None:
        """Return what people call a mission and its field; from memory."""
        found = self.book.title(mission_id)
        return None if found is None else MissionTitle(*found)

    def routes(self, desk: CommandDesk) -> list[APIRouter]:
        """Return the REST routes of missions and map, and of going on with a mission."""
        records = self._records
        rests = MissionRests(
            RestParts(
                missions=records.missions,
                revisions=self.book.revisions,
                features=records.features,
                maps=records.maps,
                database=records.database,
                fleet=self._fleet,
                planner=self.planner,
                gate=desk.gate,
                leases=desk.leases,
                sender=desk.missions,
                commands=desk.commands,
                authorize=self._authorize,
                clock=self._clock,
            )
        )
        return [
            mission_routes(self.book, self._fleet),
            rest_routes(rests, self.checklists),
            draft_routes(self.drafts),
            template_routes(self.templates),
        ]

    async def prepare(self) -> None:
        """Read missions into memory; in the demo, fill an empty installation first."""
        if self._settings.demo:
            await self._seed_demo()
        await self.book.load()

    def start(self) -> None:
        """Begin to follow the robots' reports."""
        self.tracking.start()
        self.planner.start()
        if self._seed is not None:
            self._seed.in_background()

    async def stop(self) -> None:
        """End tracking, planning and seeding."""
        if self._seed is not None:
            await self._seed.close()
        await self.tracking.close()
        await self.acts.close()
        await self.facts.close()
        await self.planner.stop()

    async def _seed_demo(self) -> None:
        records = self._records
        await seed_demo_users(records.accounts)
        self._seed = DemoSeed(
            SeedParts(
                database=records.database,
                features=records.features,
                missions=records.missions,
                robots=records.robots,
                clock=self._clock,
                farm_id=self._settings.farm_id,
                data=self._settings.data,
            )
        )
        await self._seed.at_once()

    def _moved(self, mission: Mission, change: MissionChange) -> None:
        robot = mission.robot_id
        self._records.audit.append(
            AuditEntry(mission.farm_id, change.by, "", "mission", change.after.value, robot, mission.id, change.why)
        )
        status = change.after.value
        self._on_event({"kind": "mission-status", "robot": robot, "mission_id": mission.id, "status": status})

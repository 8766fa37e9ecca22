"""Missions in the console: the book, what follows the robots, the planner's process, and the demo's seed."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter

from hmi.api.missions import mission_routes
from hmi.commands.mission_book import MissionBook, MissionParts
from hmi.commands.ports import StoredMission
from hmi.domain.mission import MissionChange
from hmi.domain.robot import Robot
from hmi.planning.worker import PlanningProcess
from hmi.presenters.operate import MissionTitle
from hmi.security.authorization import Authorizer
from hmi.security.demo_users import seed_demo_users
from hmi.store.mission_tracking import MissionTracking
from hmi.store.missions import Mission

if TYPE_CHECKING:
    from hmi.app.records import Records
    from hmi.clock import Clock
    from hmi.demo.seed import DemoSeed
    from hmi.security.accounts import Accounts
    from hmi.settings import Settings
    from hmi.store.fleet import FleetStore


class MissionDesk:
    """Everything about missions, wired once. Also the ``MissionSource`` of the sending service.

    Args:
        on_event: told of each move in a mission's life, for the live lane.
    """

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        records: Records,
        fleet: FleetStore,
        on_event: Callable[[dict[str, Any]], None] = lambda _event: None,
    ) -> None:
        self._settings, self._clock, self._records, self._fleet = settings, clock, records, fleet
        self._on_event = on_event
        self.planner = PlanningProcess()
        self.book = MissionBook(
            MissionParts(
                missions=records.missions,
                features=records.features,
                database=records.database,
                fleet=fleet,
                planner=self.planner,
                audit=records.audit,
                authorize=Authorizer(fleet.robot),
                clock=clock,
            )
        )
        self.tracking = MissionTracking(records.missions, records.database, settings.farm_id, self._moved)
        self._seed: DemoSeed | None = None

    async def load(self) -> None:
        """Read the missions and begin to follow robots."""
        await self.book.load()
        self.tracking.start()

    async def stop(self) -> None:
        """End everything."""
        if self._seed is not None:
            await self._seed.close()
        await self.tracking.close()
        await asyncio.to_thread(self.planner.close)

    def title_of(self, mission_id: str) -> MissionTitle | None:
        """Return what people call a mission; from memory."""
        title = self.book.title(mission_id)
        return None if title is None else MissionTitle(*title)

    def see(self, robot: Robot) -> None:
        """Take note of a robot that changed."""
        self.tracking.see(robot)

    async def stored(self, farm_id: str, mission_id: str, robot_id: str) -> StoredMission | None:
        """See ``MissionSource``."""
        return await self.book.stored(farm_id, mission_id, robot_id)

    async def sent(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> None:
        """See ``MissionSource``."""
        await self.book.sent(farm_id, mission_id, robot_id, by)

    def routes(self, _desk: Any = None) -> list[APIRouter]:
        """Return the routes of missions and of the map."""
        return [mission_routes(self.book, self._fleet)]

    async def seed_demo(self, accounts: Accounts) -> None:
        """Fill an empty demo; what takes long goes on in the background."""
        from hmi.demo.seed import DemoSeed, SeedParts

        records = self._records
        await seed_demo_users(accounts)
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
        self._seed.in_background()

    def _moved(self, mission: Mission, change: MissionChange) -> None:
        self._on_event(
            {
                "kind": "mission-status",
                "mission_id": mission.id,
                "name": mission.name,
                "robot": mission.robot_id,
                "status": change.after.value,
                "text": change.why,
                "by": change.by,
            }
        )

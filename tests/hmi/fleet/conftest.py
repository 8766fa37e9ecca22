"""A console with the fleet's routes on top of what the tests of REST use."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hmi.api.fleet import FleetRoutes, fleet_routes
from hmi.api.fleet_duty import DutyRoutes, duty_routes
from hmi.commands.fleet_actions import FleetActions
from hmi.commands.fleet_duty import DutyDesk, DutyParts
from hmi.commands.fleet_groups import FleetGroupBook
from hmi.domain.fleet_day import FleetDay
from hmi.domain.robot import Family
from hmi.security.walls import WallScreens
from hmi.store.duty import Duties
from hmi.store.fleet_groups import FleetGroups
from hmi.store.robots import RegisteredRobot
from hmi.store.stop_list import StopList
from hmi.store.walls import Walls
from tests.hmi.api.conftest import migrated
from tests.hmi.api.console import Console
from tests.hmi.commands.field import FARM

__all__ = ["migrated"]


class FleetConsole(Console):
    """A console whose fleet routes are there."""

    def plug(self) -> None:
        """Add the routes and two more robots."""
        clock, database = self.field.clock, self.database
        note = self.field.events.append
        self.day = FleetDay()
        self.duties = Duties(database, FARM, clock)
        self.stop_folder = self.folder / "stop"
        stop_list = StopList(database, FARM, self.stop_folder)
        self.walls = WallScreens(database, Walls(database, clock), self.sessions, FARM, self.audit.append, stop_list)
        groups = FleetGroupBook(FleetGroups(database, clock), database, self.audit, self.authorize, note)
        names = {"weeder-01": "Weeder 01", "weeder-02": "Weeder 02"}
        parts = DutyParts(
            duties=self.duties,
            database=database,
            people=self.users.all,
            farm_id=FARM,
            is_robot=lambda robot_id: self.registry.get(robot_id) is not None,
            name_of=lambda robot_id: names.get(robot_id, robot_id),
            audit=self.audit,
            authorize=self.authorize,
            clock=clock,
            on_event=note,
        )
        self.duty = DutyDesk(parts)
        self.accounts.on_changed.append(self.duty.let_go)
        desk = self.field.desk
        actions = FleetActions(desk.commands, desk.missions, desk.leases.of, self.audit)
        self.api.include_router(fleet_routes(FleetRoutes(actions, groups, self.day.figures)))
        self.api.include_router(duty_routes(DutyRoutes(self.duty, self.walls, self.tokens)))
        self.field.add("weeder-02", "Weeder 02")
        self.registry.add(RegisteredRobot("weeder-02", FARM, "Weeder 02", Family.WEEDER, "admin", clock.utc()))


@pytest.fixture
async def console(tmp_path: Path, migrated: Path) -> AsyncIterator[FleetConsole]:
    """Return a console with two registered weeders and the fleet's routes."""
    console = FleetConsole(tmp_path, migrated)
    await console.database.run(console.register)
    await console.database.run(console.plug)
    yield console
    await console.close()

"""A farm with one field, missions in a database, and the routes on top; planning happens right here."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from datetime import timedelta
from typing import Any

import httpx
import shapely
from fastapi import FastAPI

from hmi.api import errors
from hmi.api.access import Access
from hmi.api.drafts import draft_routes
from hmi.api.missions import mission_routes
from hmi.clock import FakeClock
from hmi.commands.draft_book import DraftBook
from hmi.commands.mission_book import MissionBook, MissionParts
from hmi.domain.mission_plan import Candidate, PlannedMission, PlanWish, Tell, nobody
from hmi.domain.robot import (
    LinkHealth,
    Mode,
    Order,
    OrderStatus,
    Pose,
    Robot,
    RobotState,
    Stamp,
    Telemetry,
)
from hmi.domain.role import Role
from hmi.domain.stop_token import StopToken
from hmi.planning.mission import plan_candidate, plan_mission
from hmi.planning.projection import LocalFrame
from hmi.security.authorization import Authorizer
from hmi.security.errors import BadToken
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.features import Feature, Features
from hmi.store.maps import Maps
from hmi.store.missions import Missions

FARM, OTHER_FARM = "farm", "other-farm"
FRAME = LocalFrame(51.78, 4.26)


def lon_lat(*points: tuple[float, float]) -> list[list[float]]:
    """Return positions of metres east and north of the farm's middle."""
    found: list[list[float]] = FRAME.to_lon_lat(points).tolist()
    return found


def parcel_geometry(side_m: float = 40.0) -> dict[str, Any]:
    """Return a square field."""
    corners = lon_lat(*shapely.get_coordinates(shapely.box(0, 0, side_m, side_m)).tolist())
    return {"type": "Polygon", "coordinates": [corners]}


def farm_map() -> list[Feature]:
    """Return a field, a road to it, a home and a pylon."""
    line = {"type": "LineString", "coordinates": lon_lat((-30, 10), (4, 10))}
    pylon = {"type": "Point", "coordinates": lon_lat((20, 20))[0]}
    home = {"type": "Point", "coordinates": lon_lat((-25, 10))[0]}
    return [
        Feature("field-1", FARM, "parcel", "Home field", parcel_geometry(), {"row_bearing_deg": 90.0}),
        Feature("road-1", FARM, "road", "Lane", line, {"width_m": 6.0}),
        Feature("home-1", FARM, "home", "Garage", home, {"robot": "weeder-01"}),
        Feature("pylon-1", FARM, "obstacle", "Pylon", pylon, {"radius_m": 2.0}),
        Feature("bow-tie", FARM, "parcel", "Bow tie", {"type": "Polygon", "coordinates": [
            lon_lat((0, 0), (40, 40), (40, 0), (0, 40), (0, 0))]}),
    ]  # fmt: skip


class HerePlanner:
    """Plans in this process, at once."""

    async def plan(self, wish: PlanWish, tell: Tell = nobody) -> PlannedMission:
        """Return the plan."""
        return plan_mission(wish)

    async def candidate(self, wish: PlanWish, tell: Tell = nobody) -> Candidate:
        """Return the plan to look at."""
        return plan_candidate(wish)


@dataclass
class Fleet:
    """The robots as the live store shows them."""

    robots: dict[str, Robot] = field(default_factory=dict)

    def robot(self, robot_id: str) -> Robot | None:
        """Return one."""
        return self.robots.get(robot_id)

    def report(self, robot_id: str, order: Order | None, at_s: float) -> Robot:
        """Let a robot say what it has."""
        stamp = Stamp(at_s, at_s)
        state = RobotState(Mode.AUTO, ("Mission",), at_s, 0, None, order, (), None, stamp)
        self.robots[robot_id] = replace(self.robots[robot_id], state=state)
        return self.robots[robot_id]

    def place(self, robot_id: str, lat_deg: float, lon_deg: float) -> None:
        """Put a robot somewhere."""
        pose = Pose(lat_deg, lon_deg, 0, 0, 0, 0, 0, Stamp(0, 0))
        telemetry = Telemetry(pose, None, None, None, None, None)
        self.robots[robot_id] = replace(self.robots[robot_id], telemetry=telemetry)


def weeder(robot_id: str, name: str, farm_id: str = FARM) -> Robot:
    """Return a registered robot that has said nothing yet."""
    link = LinkHealth(True, None, None, None, None, None, None, True)
    return Robot(robot_id, True, name, farm_id, link)


def order(mission_id: str, sha256: str, status: OrderStatus) -> Order:
    """Return what a robot says about its mission."""
    return Order(mission_id, 1, sha256, status, 1, 4, 2, 0.0, 100.0, 20.0, 30.0, 60.0, True)


class Log:
    """The audit as a list."""

    def __init__(self) -> None:
        self.entries: list[AuditEntry] = []

    def append(self, entry: AuditEntry) -> None:
        """Note a line."""
        self.entries.append(entry)


class Rig:
    """Everything about missions on one database."""

    def __init__(self, database: Database, clock: FakeClock) -> None:
        self.clock, self.database = clock, database
        self.fleet = Fleet({r.id: r for r in (weeder("weeder-01", "Weeder 01"), weeder("weeder-02", "Weeder 02"))})
        self.features, self.missions = Features(database, clock), Missions(database, clock)
        self.audit = Log()
        self.authorize = Authorizer(self.fleet.robot)
        self.book = MissionBook(
            MissionParts(
                self.missions,
                self.features,
                database,
                self.fleet,
                HerePlanner(),
                self.audit,
                self.authorize,
                clock,
                Maps(database, clock),
            )
        )
        self.drafts = DraftBook(self.missions, self.features, database, self.audit, self.authorize, clock)
        self.features.put(farm_map())

    def person(self, role: Role, farm_id: str = FARM) -> SessionInfo:
        """Return somebody signed in."""
        expires = self.clock.utc() + timedelta(hours=1)
        return SessionInfo(
            "s", role.value, f"{role.value.title()} Person", role, "d", "Tablet 3", farm_id, "c", expires
        )

    def client(self, role: Role | None, farm_id: str = FARM) -> httpx.AsyncClient:
        """Return a browser of somebody, or of nobody."""
        app = FastAPI()
        app.state.access = Access(
            Door(None if role is None else self.person(role, farm_id)), NoTokens(), self.authorize
        )
        app.include_router(mission_routes(self.book, self.fleet))
        app.include_router(draft_routes(self.drafts))
        errors.install(app)
        return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://console.local")


class Door:
    """Lets one person in, or nobody."""

    def __init__(self, session: SessionInfo | None) -> None:
        self._session = session

    def of_headers(self, _headers: Iterable[tuple[bytes, bytes]]) -> SessionInfo | None:
        """Return who it is."""
        return self._session


class NoTokens:
    """Knows no stop token."""

    def read_stop_token(self, _text: str) -> StopToken:
        """Refuse."""
        raise BadToken("There are no tokens here.")

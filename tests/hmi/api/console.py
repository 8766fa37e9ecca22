"""A console without its pages: real sessions, registry and audit, and the robots of a field."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import httpx
from argon2 import PasswordHasher
from starlette.applications import Starlette
from starlette.routing import Mount
from starlette.types import ASGIApp

from hmi.api.access import Access
from hmi.api.health import HealthRoutes, KeeperReport
from hmi.api.metrics import ConsoleMetrics, Gauge
from hmi.api.nodes import NodeRoutes, node_routes
from hmi.api.records import RecordRoutes
from hmi.api.robots import RobotRoutes
from hmi.api.router import PREFIX, ApiServices, build_api
from hmi.api.sessions import SessionRoutes
from hmi.api.state_chart import StateRoutes, state_chart_routes
from hmi.domain.robot import Family, Robot
from hmi.domain.robot_log import LogFailed
from hmi.domain.role import Role
from hmi.domain.stop_token import StopToken
from hmi.security.accounts import Accounts
from hmi.security.authorization import Authorizer
from hmi.security.cookie import COOKIE_NAME
from hmi.security.enrolment import Enrolment
from hmi.security.origins import Origins
from hmi.security.passwords import Passwords
from hmi.security.request_guard import RequestGuard
from hmi.security.session_info import SessionInfo
from hmi.security.sessions import Sessions
from hmi.security.sign_in import SignIn
from hmi.security.stop_tokens import StopTokens
from hmi.store.audit import Audit
from hmi.store.database import Database
from hmi.store.devices import Devices
from hmi.store.history import History
from hmi.store.robots import RegisteredRobot, Robots
from hmi.store.state_times import StateRecords
from hmi.store.stop_list import StopList
from hmi.store.users import Users
from tests.hmi.commands.field import FARM, Field

SECRET = "0123456789abcdef0123456789abcdef"
PASSWORD = "correct horse battery"
BASE = "http://console.local"


class FakeStop:
    """Takes presses."""

    def __init__(self) -> None:
        self.presses: list[tuple[str, Sequence[str] | str, StopToken]] = []

    def press(self, stop_id: str, robots: Sequence[str] | str, token: StopToken) -> list[dict[str, Any]]:
        """Note a press."""
        self.presses.append((stop_id, robots, token))
        return self.steps(stop_id)

    def steps(self, stop_id: str | None = None) -> list[dict[str, Any]]:
        """Return a step for each robot named."""
        return [
            {"stop_id": s, "robot": robot, "state": "sent", "by": token.who}
            for s, robots, token in self.presses
            if stop_id in (None, s)
            for robot in ([robots] if isinstance(robots, str) else robots)
        ]


class FakeLogs:
    """The logs of all robots; ``trouble`` is what reading them raises."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.trouble: LogFailed | None = None
        self.asked: list[int] = []

    async def tail_log(self, robot_id: str, lines: int) -> list[str]:
        """Return the newest lines."""
        self.asked.append(lines)
        if self.trouble is not None:
            raise self.trouble
        return self.lines[-lines:]


class FieldView:
    """The robots of a field as the fleet store shows them; registered is what the registry says."""

    def __init__(self, field: Field, registry: Robots) -> None:
        self._field, self._registry = field, registry

    def robot(self, robot_id: str) -> Robot | None:
        """Return one."""
        return self._field.robot(robot_id)

    def robots(self) -> list[Robot]:
        """Return all."""
        return [robot.known() for robot in self._field.robots.values()]

    def sync(self) -> None:
        """Take over the registry."""
        for robot in self._field.robots.values():
            robot.is_registered = self._registry.get(robot.id) is not None


class Console:
    """Everything behind REST; ``client`` talks to it as a browser does."""

    def __init__(self, folder: Path, migrated: Path) -> None:
        self.folder = folder
        shutil.copyfile(migrated, folder / "headland.db")
        self.field = Field()
        clock = self.field.clock
        self.database = Database(f"sqlite:///{folder / 'headland.db'}")
        self.stop_list = StopList(self.database, FARM, folder / "stop")
        self.registry = Robots(self.database, FARM, clock, self.stop_list)
        self.users = Users(self.database, clock)
        self.devices = Devices(self.database, clock, self.stop_list)
        self.audit = Audit(self.database, clock, folder / "spill.jsonl")
        self.sessions = Sessions(self.database, clock, FARM, 12 * 3600)
        self.tokens = StopTokens(SECRET, self.devices.is_revoked)
        self.authorize = Authorizer(self.registry.of_any_farm)
        passwords = Passwords(SECRET, PasswordHasher(time_cost=1, memory_cost=8, parallelism=1))
        note = self.audit.append
        self.accounts = Accounts(self.database, FARM, self.users, self.sessions, passwords, self.stop_list, note)
        self.sign_in = SignIn(
            self.database, clock, FARM, self.users, self.devices, self.sessions, passwords, self.tokens, note
        )
        self.enrolment = Enrolment(self.database, self.devices, self.sessions, self.tokens, note)
        self.stop = FakeStop()
        self.stops_at: set[str] = set()
        self.metrics = ConsoleMetrics()
        self.field.desk.ledger.when_settled(self.metrics.observe)
        self.metrics.add(Gauge("lanes", "Open lanes.", lambda: 3))
        self.broker_state = "up"
        self.is_database_up = True
        self.fleet = FieldView(self.field, self.registry)
        self.logs = FakeLogs()
        self.api = build_api(self._services())
        self._clients: list[httpx.AsyncClient] = []

    def _services(self) -> ApiServices:
        clock = self.field.clock
        return ApiServices(
            access=Access(self.sessions, self.tokens, self.authorize),
            sessions=SessionRoutes(
                self.sign_in, self.sessions, self.tokens, self.enrolment, self.devices, self.database
            ),
            accounts=self.accounts,
            robots=RobotRoutes(
                self.fleet,
                self.registry,
                self.database,
                self.field.desk.leases,
                self.audit,
                clock,
                self.fleet.sync,
                is_stop_open=self._is_stop_open,
            ),
            records=RecordRoutes(self.audit, History(self.database, FARM), self.registry, self.database, clock),
            health=HealthRoutes(
                "0.1.0",
                KeeperReport(self.folder),
                clock,
                lambda: (self.broker_state, "mqtt://127.0.0.1:1883"),
                lambda: self.is_database_up,
            ),
            desk=self.field.desk,
            stop=self.stop,
            diagnostics={"ingest": lambda: {"messages": 7}},
            further=[
                state_chart_routes(
                    StateRoutes(
                        self.fleet.robot, StateRecords(self.database, FARM), self.database, clock, self.authorize
                    )
                ),
                node_routes(NodeRoutes(self.fleet.robot, self.field.desk.commands, self.logs, clock)),
            ],
        )

    async def _is_stop_open(self, robot_id: str) -> bool:
        return robot_id in self.stops_at

    def register(self) -> None:
        """Put the field's weeder into the registry."""
        clock = self.field.clock
        self.registry.add(RegisteredRobot("weeder-01", FARM, "Weeder 01", Family.WEEDER, "admin", clock.utc()))
        self.audit.start()

    async def session(self, role: Role, *, browser: str = "1") -> tuple[str, SessionInfo]:
        """Sign somebody of a role in without a password; return cookie and session."""
        user_id = role.value
        user = await self.database.run(self.users.get, user_id)
        if user is None:
            name = {"operator": "Martha Keller", "supervisor": "Anna Ostermeier"}.get(user_id, user_id.title())
            user = await self.accounts.create_user(name, role, PASSWORD, by="test", user_id=user_id)
        return await self.sessions.open(user, f"tablet-{browser}", f"Tablet {browser}")

    def client(
        self, cookie: str = "", session: SessionInfo | None = None, *, host: str = "10.0.0.5"
    ) -> httpx.AsyncClient:
        """Return a browser, signed in if a session is given."""
        site: ASGIApp = Starlette(routes=[Mount(PREFIX, self.api), self.metrics.route()])
        guarded = RequestGuard(site, Origins(), self.sessions.of_headers)
        headers: Mapping[str, str] = {"x-headland-csrf": session.csrf, "origin": BASE} if session else {}
        client = httpx.AsyncClient(
            base_url=BASE + PREFIX,
            transport=httpx.ASGITransport(guarded, raise_app_exceptions=False, client=(host, 40_000)),
            headers=headers,
            cookies={COOKIE_NAME: cookie} if cookie else None,
        )
        self._clients.append(client)
        return client

    async def browser(self, role: Role, *, browser: str = "1") -> httpx.AsyncClient:
        """Return a signed-in browser of somebody with a role."""
        return self.client(*await self.session(role, browser=browser))

    async def written(self, kind: str) -> list[Any]:
        """Return the audit of one kind, oldest first, once it is on disk."""
        await self.database.run(self.audit.flush)
        return (await self.database.run(lambda: self.audit.recent(FARM, 1000, kind=kind)))[::-1]

    async def close(self) -> None:
        """End everything."""
        for client in self._clients:
            await client.aclose()
        await self.field.desk.close()
        await self.database.run(self.audit.close)
        self.database.close()

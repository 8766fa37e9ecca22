"""A farm with a weeder that has two cameras, a camera process that does as told, and a disk of any size."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from datetime import timedelta
from pathlib import Path
from typing import Any
from unittest.mock import patch

import httpx
from argon2 import PasswordHasher
from fastapi import FastAPI

from hmi.api import errors
from hmi.api.access import Access
from hmi.api.limits import BodyLimit
from hmi.app.pictures import PictureDesk
from hmi.app.records import Records
from hmi.clock import FakeClock, SystemClock
from hmi.commands.camera_ports import CameraProcess, CamerasAway, Clip, NoPicture, Still
from hmi.domain.camera import CameraInfo
from hmi.domain.robot import Family, Mode, Order, OrderStatus, Pose, Press, RobotState, SafetyState, Stamp, Telemetry
from hmi.domain.role import Role
from hmi.presenters.operate import MissionTitle
from hmi.security.authorization import Authorizer
from hmi.security.passwords import Passwords
from hmi.security.session_info import SessionInfo
from hmi.settings import Settings
from hmi.store.picture_files import PictureFiles
from hmi.store.robots import RegisteredRobot
from tests.hmi.commands.field import FARM, factsheet
from tests.hmi.missions.rig import Fleet, NoTokens, weeder
from tests.hmi.pictures.jpeg import picture

SECRET = "0123456789abcdef0123456789abcdef"
WEEDER = "weeder-01"


def quick_passwords(secret: str) -> Passwords:
    """Return hashes that take no time; nobody signs in here."""
    return Passwords(secret, PasswordHasher(time_cost=1, memory_cost=8, parallelism=1))


@dataclass
class FakeCameras:
    """A camera process: shows what ``shows`` holds, keeps what it is told to."""

    clock: FakeClock
    shows: dict[tuple[str, str], bytes] = field(default_factory=dict)
    kept: dict[tuple[str, str], bytes] = field(default_factory=dict)
    age_s: float = 0.2
    is_away: bool = False
    is_dated: bool = True
    changed_s: float | None = None  # when the source of every camera was changed
    held: tuple[tuple[str, str], ...] = ()
    told: list[tuple[tuple[str, str], ...]] = field(default_factory=list)
    asked: list[tuple[str, str, float | None]] = field(default_factory=list)
    full: int = 0
    cut: list[tuple[str, str, float, float]] = field(default_factory=list)
    frames: list[tuple[str, bytes]] = field(default_factory=list)
    ages_s: list[float] = field(default_factory=list)
    watching: list[tuple[str, str]] = field(default_factory=list)

    async def still(self, robot_id: str, camera: str, fresh_s: float | None, *, is_full: bool = False) -> Still:
        """Return what a camera shows."""
        self._answer()
        self.asked.append((robot_id, camera, fresh_s))
        self.full += is_full
        if (robot_id, camera) not in self.shows:
            raise NoPicture("no_picture", "The camera shows no picture now.")
        return Still(self.shows[(robot_id, camera)], self.clock.mono_s() - self.age_s, self.is_dated)

    async def record(self, cameras: Sequence[tuple[str, str]]) -> None:
        """Hold these."""
        self._answer()
        self.held = tuple(cameras)
        self.told.append(self.held)

    async def watched(self) -> list[tuple[str, str]]:
        """Return who is looked at."""
        self._answer()
        return self.watching

    async def clip(self, robot_id: str, camera: str, from_s: float, to_s: float, path: Path) -> Clip:
        """Write what was kept."""
        self._answer()
        self.cut.append((robot_id, camera, from_s, to_s))
        if (robot_id, camera) not in self.kept:
            raise NoPicture("nothing_kept", "Nothing was recorded.")
        await asyncio.to_thread(path.write_bytes, self.kept[(robot_id, camera)])
        if self.changed_s is not None and from_s < self.changed_s < to_s:
            return Clip(self.changed_s, to_s, 640, 480, is_dated=self.is_dated, has_before=True)
        return Clip(to_s - 60.0, to_s, 640, 480, is_dated=self.is_dated)

    async def frame(self, robot_id: str, camera: str, data: bytes, age_s: float) -> None:
        """Show a frame."""
        self._answer()
        self.ages_s.append(age_s)
        self.frames.append((camera, data))
        self.shows[(robot_id, camera)] = data

    def _answer(self) -> None:
        if self.is_away:
            raise CamerasAway("it is away")


class PictureRig:
    """Everything about pictures of one farm.

    Args:
        process: a camera process that is not played; it needs the clock of this machine.
    """

    def __init__(self, folder: Path, *, process: CameraProcess | None = None, **settings: Any) -> None:
        self.folder, self.clock = folder, FakeClock()
        clock = self.clock if process is None else SystemClock()
        wanted = {"data": folder, "farm_id": FARM, "secret": SECRET, "port": 0, **settings}
        self.settings = Settings.model_validate(wanted)
        with patch("hmi.app.records.Passwords", quick_passwords):
            self.records = Records(self.settings, clock, lambda _id: True)
        self.free_bytes = 100_000_000_000
        self.events: list[dict[str, Any]] = []
        self.cameras = FakeCameras(self.clock)
        sheet = factsheet(cameras=(CameraInfo("rear", "Rear", 640, 480), CameraInfo("front", "Front", 640, 480)))
        self.fleet = Fleet({WEEDER: replace(weeder(WEEDER, "Weeder 01", FARM), factsheet=sheet)})
        self.authorize = Authorizer(self.records.robots.of_any_farm)
        self.desk = PictureDesk(
            self.settings, clock, self.records, self.fleet, self.authorize, self.events.append,
            lambda _id: MissionTitle("Home field, all rows", "Home field"), process or self.cameras,
        )  # fmt: skip
        self.desk.shelf.files = PictureFiles(folder / "pictures", lambda _path: self.free_bytes)
        self.shelf, self.recorder = self.desk.shelf, self.desk.recorder
        self._clients: list[httpx.AsyncClient] = []
        self._app: FastAPI | None = None

    async def open(self) -> None:
        """Register the weeder and read what there is."""
        await self.records.database.run(self.records.robots.load)
        if self.records.robots.get(WEEDER) is None:
            robot = RegisteredRobot(WEEDER, FARM, "Weeder 01", Family.WEEDER, "admin", self.clock.utc())
            robot = replace(robot, http_url="http://10.0.0.5:9000")
            await self.records.database.run(self.records.robots.add, robot)
        self.records.audit.start()
        await self.desk.prepare()

    async def close(self) -> None:
        """End everything."""
        for client in self._clients:
            await client.aclose()
        await self.desk.stop()
        await asyncio.to_thread(self.records.close)

    def person(self, role: Role, farm_id: str = FARM) -> SessionInfo:
        """Return somebody signed in."""
        until = self.clock.utc() + timedelta(hours=1)
        return SessionInfo("s", role.value, f"{role.value.title()} Person", role, "d", "Tablet 3", farm_id, "c", until)

    def browser(self, role: Role | None, farm_id: str = FARM) -> httpx.AsyncClient:
        """Return a browser of somebody, or a program that is not signed in."""
        self._app = self._app or self._made()  # takes longer than most tests
        headers = {} if role is None else {"x-person": role.value, "x-farm": farm_id}
        client = httpx.AsyncClient(
            transport=httpx.ASGITransport(self._app), base_url="http://console.local", headers=headers
        )
        self._clients.append(client)
        return client

    def of_headers(self, headers: Iterable[tuple[bytes, bytes]]) -> SessionInfo | None:
        """Return who it is: our browsers say so."""
        told = {name.decode(): value.decode() for name, value in headers}
        return self.person(Role(told["x-person"]), told["x-farm"]) if "x-person" in told else None

    def _made(self) -> FastAPI:
        app = FastAPI()
        app.state.access = Access(self, NoTokens(), self.authorize)
        for router in self.desk.routes():
            app.include_router(router)
        errors.install(app)
        app.add_middleware(BodyLimit)
        return app

    async def audited(self, kind: str) -> list[Any]:
        """Return the audit of one kind, oldest first."""
        await self.records.database.run(self.records.audit.flush)
        return (await self.records.database.run(lambda: self.records.audit.recent(FARM, 1000, kind=kind)))[::-1]

    def files(self) -> list[Path]:
        """Return the files of kept pictures."""
        return sorted(path for path in (self.folder / "pictures" / "kept").rglob("*") if path.is_file())

    def show(self, camera: str = "front", data: bytes | None = None) -> bytes:
        """Let a camera of the weeder show something."""
        data = data or picture()
        self.cameras.shows[(WEEDER, camera)] = data
        return data

    def stand(self, *, row: int = 0, status: OrderStatus = OrderStatus.RUNNING, speed_mps: float = 0.0) -> None:
        """Let the weeder say where it is and, with a row, what it works on."""
        stamp = Stamp(self.clock.mono_s() - 0.5, self.clock.mono_s() - 0.4)
        pose = Pose(51.5, 4.25, 0, 0, 0.0, speed_mps, 0, stamp)
        order = Order("m-1", 1, "a" * 64, status, row, 9, 1, 0.0, 100.0, 10.0, 20.0, 60.0, True) if row else None
        state = RobotState(Mode.AUTO, ("Mission",), 0.0, 0, None, order, (), None, stamp)
        robot = replace(self.fleet.robots[WEEDER], telemetry=Telemetry(pose, None, None, None, None, None), state=state)
        self._heard(robot)

    def latch(self, *stop_ids: str, hardware: bool = False) -> None:
        """Let the weeder say which presses of STOP it holds."""
        now_s = self.clock.mono_s()
        presses = tuple(Press(one, "Martha Keller", "Tablet 3", now_s, False) for one in stop_ids)
        safety = SafetyState(hardware, bool(stop_ids), True, 0.0, True, presses, 0.0, Stamp(now_s, now_s))
        self._heard(replace(self.fleet.robots[WEEDER], safety=safety))

    def _heard(self, robot: Any) -> None:
        self.fleet.robots[robot.id] = robot
        self.recorder.see(robot)

    async def seconds(self, count: float) -> None:
        """Let time pass; the recorder looks each second. What was begun in it is done."""
        for _ in range(int(count)):
            self.clock.advance(1.0)
            await self.recorder.round()
        await self.settled()

    async def settled(self) -> None:
        """Wait for clips and pictures that are being kept."""
        names = ("clip-", "mission-picture")
        while tasks := [one for one in asyncio.all_tasks() if one.get_name().startswith(names)]:
            await asyncio.gather(*tasks)

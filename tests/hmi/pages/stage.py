"""A stage for the screens: the real shell, fleet store and live lane, with robots that a test moves by hand.

``python -m tests.hmi.pages.stage`` serves it on a free loopback port. No broker, no database; REST answers are played.
Anybody is signed in whose cookie ``stage`` names a role.
"""

from __future__ import annotations

import argparse
import asyncio
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

import uvicorn
from fastapi import FastAPI, Request
from fastapi.responses import JSONResponse
from nicegui import ui
from starlette.staticfiles import StaticFiles

from hmi.api.access import Access
from hmi.clock import SystemClock
from hmi.domain import robot as domain
from hmi.domain.freshness import TickRing
from hmi.domain.role import Permission, Role, may
from hmi.live.frames import Drive
from hmi.live.hub import LiveHub
from hmi.live.lane import lane_route, same_origin_or
from hmi.pages import bundle
from hmi.pages.services import PageServices, StopAddress
from hmi.pages.shell import shell
from hmi.presenters.operate import MissionTitle
from hmi.security.errors import NotAllowed, NotSignedIn
from hmi.security.session_info import SessionInfo
from hmi.settings import Settings
from hmi.store.fleet import FleetStore
from tests.components import map_field
from tests.hmi.live.crowd import Crowd
from tests.hmi.pages import (
    alarm_stage,
    camera_stage,
    fleet_stage,
    machine_stage,
    maps_stage,
    maps_stage_routes,
    sensor_stage,
    super_stage,
)

SHA = "ab" * 32
NAMES = {Role.OPERATOR: "Martha Keller", Role.SUPERVISOR: "Anna Ostermeier", Role.ADMIN: "Jonas Weber"}


@dataclass(frozen=True, slots=True)
class Entry:
    """A registry row as the store reads it."""

    id: str
    name: str
    farm_id: str = "farm"
    http_url: str | None = None
    http_token: str | None = None
    contact_name: str | None = "Jonas Weber"
    contact_phone: str | None = "+49 151 0000"
    keep_out_m: float = 15.0


class StageSessions:
    """Signs everybody in by the word in the cookie."""

    def of_headers(self, headers: Iterable[tuple[bytes, bytes]]) -> SessionInfo | None:
        """Return the person of the ``stage`` cookie."""
        for name, value in headers:
            if name == b"cookie" and b"stage=" in value:
                return self.get(value.split(b"stage=")[1].split(b";")[0].decode())
        return None

    def get(self, session_id: str) -> SessionInfo | None:
        """Return the session of a role."""
        if session_id not in set(Role):
            return None
        role = Role(session_id)
        name = NAMES.get(role, role.value.title())
        return SessionInfo(
            session_id, role.value, name, role, "tab", "Tablet 3", "farm", "csrf", datetime.max.replace(tzinfo=UTC)
        )


def authorize(session: SessionInfo | None, permission: Permission, robot_id: str | None = None) -> None:
    """Allow by role alone."""
    if session is None:
        raise NotSignedIn
    if not may(session.role, permission):
        raise NotAllowed("This needs another role.")


@dataclass
class Scene:
    """What the robot on stage does now."""

    mode: str = "auto"
    path: tuple[str, ...] = ("Mission", "Treat row", "Laser firing")
    status: str = "running"
    row: int = 37
    speed_mps: float = 0.42
    tool: str = "on"
    rate: float | None = 212.0
    fix: str = "fixed"
    accuracy_m: float = 0.014
    soc: float = 0.68
    rtt_s: float = 0.084
    is_latched: bool = False
    is_silent: bool = False
    hold: tuple[str, str, str, str] | None = None
    fault: tuple[str, str, str, str] | None = ("rain-soon", "medium", "Rain in 35 min", "It may pause.")
    owner: str = ""
    asked: str = ""
    outcome: str = "accepted"
    text: str = ""


STILL: dict[str, Any] = {"speed_mps": 0.0, "tool": "off", "rate": None}
PAUSED: dict[str, Any] = {**STILL, "mode": "paused", "status": "paused", "owner": "operator"}
PERSON_AHEAD = ("person", "A person is 4 m ahead.", "It goes on when the person has left.", "anybody")

SCENES: dict[str, dict[str, Any]] = {
    "running": {"owner": "operator"},
    "idle": {**STILL, "mode": "idle", "path": ("Idle",), "status": "loaded", "row": 0},
    "paused": {**PAUSED, "path": ("Mission", "Paused by you"), "tool": "armed"},
    "manual": {**PAUSED, "mode": "manual", "path": ("Paused", "Manual", "Hold to run"), "speed_mps": 0.18},
    "latched": {**PAUSED, "mode": "stopped", "path": ("Stopped", "Wait for reset"), "is_latched": True, "owner": ""},
    "silent": {"is_silent": True, "owner": "operator"},
    "float": {"fix": "float", "accuracy_m": 0.24, "soc": 0.14, "speed_mps": 0.2, "owner": "supervisor"},
    "held": {**PAUSED, "path": ("Mission", "Paused", "Person ahead"), "hold": PERSON_AHEAD, "asked": "supervisor"},
}


class Stage:
    """The robots, the lane and the played answers."""

    def __init__(self) -> None:
        self.clock = SystemClock()
        self.fleet = FleetStore(self.clock.mono_s)
        self.ticks = TickRing("stage", self.clock.mono_s, self.clock.utc)
        self.alarms = alarm_stage.AlarmStage(self.clock.mono_s, lambda event: self.hub.event(event))
        self.hub = LiveHub(
            self.fleet,
            self.ticks,
            self.clock,
            lambda _id: MissionTitle("M-0412", "Nordfeld 12"),
            alarms=self.alarms,
        )
        self.sessions = StageSessions()
        self.scene = Scene(owner="operator")
        self.frames: list[Any] = []
        self.orders: list[dict[str, Any]] = []
        self.since_s = self.clock.mono_s() - 38
        self.place = map_field.row_point(37, 0.42)
        self.farm, self.mission = map_field.farm(), map_field.mission()
        self.fleet.set_broker(is_up=True)
        self.machine = machine_stage.MachineStage(self.fleet, self.clock.mono_s, self.register)
        self.register(False)
        self.fleet.put_factsheet("weeder-07", factsheet("Weeder 07"))
        self.cameras = camera_stage.CameraStage(self.clock.mono_s)
        self.sensors = sensor_stage.SensorStage(self.clock.mono_s)
        self.planter = super_stage.SuperStage(self.clock, is_silent=True)

    def register(self, has_machine: bool) -> None:
        """Let the robots be known, with or without the planter whose inside tests look at."""
        names = {"weeder-07": "Weeder 07", "weeder-01": "Weeder 01", "planter-02": "Planter 02"}
        more = {machine_stage.ID: machine_stage.NAME} if has_machine else {}
        self.fleet.set_registry([Entry(i, n) for i, n in {**names, **more}.items()])

    def play(self, name: str) -> None:
        """Show another scene."""
        self.scene = replace(Scene(), **SCENES[name])
        self.since_s = self.clock.mono_s()
        self.orders.clear()
        self.frames.clear()
        self.alarms.clear()
        self.tell_lease()

    def tell_lease(self) -> None:
        """Say who has control."""
        self.hub.set_group(
            "weeder-07",
            "lease",
            {"owner": person(self.scene.owner), "since_s": 1.0, "asked": [p for p in [person(self.scene.asked)] if p]},
        )

    async def run_crowd(self, count: int) -> None:
        """Let many robots report twice a second instead."""
        await self.hub.start()
        crowd = Crowd(self.fleet, count, self.clock.mono_s)
        while True:
            crowd.step()
            await asyncio.sleep(0.5)

    async def run(self) -> None:
        """Let the robot speak ten times a second."""
        await self.hub.start()
        self.tell_lease()
        while True:
            if not self.scene.is_silent:
                self.speak()
            self.planter.speak(self.fleet, factsheet)
            self.machine.speak()
            self.fleet.announce()
            self.fleet.refresh_links()
            await asyncio.sleep(0.1)

    def speak(self) -> None:
        """One beat of heartbeat, telemetry, state and safety."""
        now = self.clock.mono_s()
        stamp = domain.Stamp(now - 0.05, now)
        scene, fleet = self.scene, self.fleet
        fleet.put_heartbeat("weeder-07", boot="b" * 8, challenge="c" * 8, heard_s=now - 0.04)
        fleet.put_round_trip("weeder-07", scene.rtt_s)
        fleet.put_telemetry("weeder-07", telemetry(scene, self.place, stamp))
        fleet.put_state("weeder-07", state(scene, self.since_s, stamp))
        presses = (
            (domain.Press("d" * 32, "Martha Keller", "Tablet 3", self.since_s, False),) if scene.is_latched else ()
        )
        fleet.put_safety(
            "weeder-07",
            domain.SafetyState(
                False,
                scene.is_latched,
                scene.speed_mps == 0,
                scene.speed_mps,
                scene.tool == "off",
                presses,
                0.31 if scene.is_latched else None,
                stamp,
            ),
        )
        fleet.announce()


def person(role: str) -> dict[str, str] | None:
    """Return a lease owner."""
    return {"user": role, "name": NAMES.get(Role(role), role), "device": "Tablet 3", "session": role} if role else None


def telemetry(scene: Scene, place: tuple[float, float, float], stamp: domain.Stamp) -> domain.Telemetry:
    """Return fast values of a scene."""
    lon, lat, heading = place
    return domain.Telemetry(
        domain.Pose(lat, lon, 0, 0, math.radians(90 - heading), scene.speed_mps, 0.0, stamp),
        domain.Gnss(scene.fix, scene.accuracy_m, 27, 0.8), domain.Battery(scene.soc, 18600, False),
        domain.ToolState(scene.tool, scene.tool != "off", scene.rate, 41.0), 0.009, 6.4,
    )  # fmt: skip


def state(scene: Scene, since_s: float, stamp: domain.Stamp) -> domain.RobotState:
    """Return the operating state of a scene."""
    done = 172600 * scene.row / 84
    order = domain.Order(
        "m-0412",
        1,
        SHA,
        domain.OrderStatus(scene.status),
        scene.row,
        84,
        72,
        30.0,
        172600.0,
        done,
        900.0,
        12360.0,
        True,
    )
    faults = (domain.Fault(*scene.fault),) if scene.fault else ()
    hold = domain.Hold(*scene.hold) if scene.hold else None
    return domain.RobotState(domain.Mode(scene.mode), scene.path, since_s, 1, 0.45, order, faults, hold, stamp)


def factsheet(name: str) -> domain.Factsheet:
    """Return what a weeder says it is."""
    return domain.Factsheet(
        domain.Family.WEEDER, name, "LW-2", "1.4.2", 51.75, 5.75, 2.4, 1.8, 1.6, 1.2, 1.5, 1.67, 0.6, 1.0, 0.8, 0.0,
        True, True, "laser", "Laser", 1.5, 0.5, 3.5, 10.0, 3.0, 15.0, "laser off, tracks brake",
    )  # fmt: skip


def build(stage: Stage) -> FastAPI:
    """Return the application of the stage."""
    app = FastAPI()
    for route in bundle.routes():
        app.router.routes.append(route)
    app.router.routes.append(
        lane_route(
            stage.hub, stage.sessions, same_origin_or(), lambda _s, _lane, f: stage.frames.append(f), stage.clock
        )
    )
    app.mount("/static", StaticFiles(directory=bundle.STATIC))

    @app.get("/api/v1/features")
    async def features() -> dict[str, Any]:
        return stage.farm

    @app.get("/api/v1/robots/{robot}/mission.geojson")
    async def mission(robot: str) -> dict[str, Any]:
        return stage.mission

    app.include_router(alarm_stage.router(stage.alarms, stage.orders.append))
    app.include_router(camera_stage.router(stage.cameras))
    app.include_router(sensor_stage.router(stage.sensors, stage.sessions))
    app.include_router(fleet_stage.router(fleet_stage.FleetStage()))
    app.include_router(stage.machine.router(stage.orders))
    app.include_router(maps_stage_routes.router(maps_stage.MapStage(), stage.sessions))

    app.state.access = Access(stage.sessions, None, authorize)  # type: ignore[arg-type]
    app.include_router(super_stage.router(stage.planter, stage.fleet, authorize))

    _wishes(app, stage)

    services = PageServices(
        Settings(demo=True, farm_name="Hof Brandt", map_engine="full"),
        stage.clock,
        stage.fleet,
        stage.sessions,
        authorize,
        StopAddress(1),
    )
    ui.run_with(
        app,
        root=shell(services),
        title="Headland",
        tailwind=False,
        reconnect_timeout=30,
        binding_refresh_interval=None,
        show_welcome_message=False,
    )
    return app


def _wishes(app: FastAPI, stage: Stage) -> None:
    """Add the routes by which tests set the scene and hear what came, and the console's REST behind them."""

    @app.post("/stage/{scene}")
    async def play(scene: str) -> dict[str, Any]:
        stage.play(scene)
        return {"scene": scene}

    @app.post("/stage-set")
    async def adjust(request: Request) -> dict[str, Any]:
        stage.scene = replace(stage.scene, **await request.json())
        stage.tell_lease()
        return {}

    @app.get("/stage-heard")
    async def heard() -> dict[str, Any]:
        frames = [f for f in stage.frames if isinstance(f, Drive)]
        drives = [{"v": f.v, "w": f.w} | ({} if f.picture is None else {"picture": f.picture}) for f in frames]
        heres = sum(type(f).__name__ == "Here" for f in stage.frames)
        jogs = [f.rates for f in stage.frames if type(f).__name__ == "Jog"]
        return {"orders": stage.orders, "drives": drives, "jogs": jogs, "heres": heres}

    @app.api_route("/api/v1/{rest:path}", methods=["GET", "POST", "PATCH", "DELETE"])
    async def rest(rest: str, request: Request) -> JSONResponse:
        return await answer(stage, rest, request)


WEEDER = {
    "id": "weeder-07",
    "name": "Weeder 07",
    "family": "weeder",
    "http_url": "http://10.0.0.17:8090",
    "contact_name": "Jonas Weber",
    "contact_phone": "+49 151 0000",
}
MARTHA = {"id": "operator", "name": "Martha Keller", "role": "operator"}
ANNA = {"id": "supervisor", "name": "Anna Ostermeier", "role": "supervisor"}
PAUSE_ENTRY = {
    "seq": 3,
    "utc": "2026-05-20T14:36:40.9Z",
    "actor": "Martha Keller",
    "device": "Tablet 3",
    "kind": "command",
    "robot_id": "weeder-07",
    "outcome": "accepted",
    "text": "pause",
}
PLAYED: dict[str, Any] = {
    "session": {"stop_token": "token"},
    "robots": {"robots": [WEEDER]},
    "robots/new": {"robots": [{"id": "planter-09", "family": "planter", "name": "Planter 09", "model": "TP-1"}]},
    "users": {"users": [{**MARTHA, "is_active": True, "has_pin": True}]},
    "devices": {"devices": []},
    "audit": {"entries": [PAUSE_ENTRY]},
    "diagnostics": {"ingest": {"received": 48211, "malformed": 0}, "lanes": {"open": 3}},
    "people": {"people": [MARTHA, ANNA], "device": {"name": "Tablet 3"}},
}


async def answer(stage: Stage, rest: str, request: Request) -> JSONResponse:
    """Play the console's REST: orders are noted, records are fixed."""
    if request.method == "GET":
        return JSONResponse(
            PLAYED.get(rest, {"code": "not_found", "text": "Nothing here."}), 200 if rest in PLAYED else 404
        )
    body = await request.json() if await request.body() else {}
    stage.orders.append({"method": request.method, "path": rest, **body})
    if rest == "session":
        is_right = body.get("password") == body.get("name") or body.get("pin") == "1111"
        reply = JSONResponse(
            {"user": {}, "csrf": "csrf", "stop_token": "token"}
            if is_right
            else {"code": "wrong", "text": "Wrong name or password."},
            200 if is_right else 401,
        )
        if is_right:
            reply.set_cookie("stage", body["name"])
        return reply
    return JSONResponse(
        {"outcome": stage.scene.outcome, "text": stage.scene.text, "granted": True, "stop_token": "token", "ms": 40}
    )


def main() -> None:
    """Serve until killed; the first line says where."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--crowd", type=int, default=0, help="so many robots instead of the one that scenes are about")
    options = parser.parse_args()
    port = options.port
    stage = Stage()
    server = uvicorn.Server(
        uvicorn.Config(build(stage), host="127.0.0.1", port=port, log_level="warning", ws_per_message_deflate=False)
    )

    async def serve() -> None:
        playing = stage.run_crowd(options.crowd) if options.crowd else stage.run()
        task = asyncio.create_task(playing, name="stage")
        serving = asyncio.create_task(server.serve(), name="server")
        while not server.started and not serving.done():  # noqa: ASYNC110 - uvicorn offers no event
            await asyncio.sleep(0.05)
        if server.started:
            print(f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}", flush=True)
        await serving
        task.cancel()

    asyncio.run(serve())


if __name__ == "__main__":
    main()

"""Switches faults and shows the truth, for testers; loopback only and in no real robot.

::

    POST   /_faults/{robot}          {"fault": "silence", "http": true}
    DELETE /_faults/{robot}[?fault=silence]
    GET    /_faults/{robot}
    GET    /_world/{robot}           ground truth
    POST   /_world/{robot}           {"x_m", "y_m", "theta_rad", "soc"}, all optional: puts the machine there
    POST   /_world                   {"speed": 10}
    GET    /_situations              what can be played, on which stations too, and what is on
    POST   /_situations/{robot}      {"situation": "rtk-float"}, null ends it

Where there are field sensors, ``/_faults`` and ``/_situations`` take a station's id as well.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from typing import Annotated, Any

import msgspec
from msgspec import Meta, Struct
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from backend_clients.simulator.director import Director
from backend_clients.simulator.faults import decode_fault, name_of
from backend_clients.simulator.http_server import error
from backend_clients.simulator.late_sensors import LateSensors
from backend_clients.simulator.situations import SITUATIONS
from backend_clients.simulator.world import SimRobot, World

MAX_BODY = 4096
LOOPBACK = {"127.0.0.1", "::1", "::ffff:127.0.0.1", "testclient"}

Metres = Annotated[float, Meta(ge=-1e5, le=1e5)]
Handler = Callable[[Request], Awaitable[Response]]


class Place(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where to put a machine, and how full its battery is."""

    x_m: Metres | None = None
    y_m: Metres | None = None
    theta_rad: Annotated[float, Meta(ge=-10, le=10)] | None = None
    soc: Annotated[float, Meta(ge=0, le=1)] | None = None


class Pace(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How much faster than real time missions run."""

    speed: Annotated[float, Meta(ge=0.1, le=200)]


class Wanted(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which situation to play on a robot; ``None`` ends the one that is on."""

    situation: str | None


def routes(world: World, director: Director, sensors: LateSensors | None = None) -> list[Route]:
    """Return the tester's routes."""
    return [
        Route("/_faults/{robot_id}", _local(_Faults(world, sensors).serve), methods=["GET", "POST", "DELETE"]),
        Route("/_world/{robot_id}", _local(_Truth(world).serve), methods=["GET", "POST"]),
        Route("/_situations", _local(_Situations(director, sensors).list), methods=["GET"]),
        Route("/_situations/{robot_id}", _local(_Situations(director, sensors).play), methods=["POST"]),
        Route("/_world", _local(_Pace(world).serve), methods=["GET", "POST"]),
    ]


class _Faults:
    def __init__(self, world: World, sensors: LateSensors | None) -> None:
        self._robots, self._sensors = world.robots, sensors

    async def serve(self, request: Request) -> Response:
        found = request.path_params["robot_id"]
        robot = self._robots.get(found)
        if robot is None and self._sensors is not None and self._sensors.has(found):
            return await self._station(request, self._sensors, found)
        if robot is None:
            return error(404, "unknown_robot", "There is no such robot here.")
        if request.method == "POST":
            robot.set_fault(decode_fault(await request.body()))
        elif request.method == "DELETE":
            robot.clear_fault(request.query_params.get("fault"))
        return _answer({"faults": {name_of(fault): fault for fault in robot.faults.list()}})

    async def _station(self, request: Request, sensors: LateSensors, station_id: str) -> Response:
        if request.method == "POST":
            sensors.set_fault(station_id, await request.body())
        elif request.method == "DELETE":
            sensors.clear_fault(station_id, request.query_params.get("fault"))
        return _answer({"faults": sensors.faults(station_id)})


class _Truth:
    def __init__(self, world: World) -> None:
        self._world = world

    async def serve(self, request: Request) -> Response:
        robot = self._world.robots.get(request.path_params["robot_id"])
        if robot is None:
            return error(404, "unknown_robot", "There is no such robot here.")
        if request.method == "POST":
            place = msgspec.json.decode(await request.body(), type=Place)
            base = robot.machine.base
            base.x_m = base.x_m if place.x_m is None else place.x_m
            base.y_m = base.y_m if place.y_m is None else place.y_m
            base.theta_rad = base.theta_rad if place.theta_rad is None else place.theta_rad
            robot.machine.soc = robot.machine.soc if place.soc is None else place.soc
        return _answer(truth(robot, self._world.clock.mono_s()))


class _Situations:
    def __init__(self, director: Director, sensors: LateSensors | None) -> None:
        self._director, self._sensors = director, sensors

    async def list(self, _request: Request) -> Response:
        known = [{"id": s.id, "title": s.title, "text": s.text, "families": s.families} for s in SITUATIONS]
        if self._sensors is None:
            return _answer({"situations": known, "stations": [], "now": self._director.now()})
        told = self._sensors.told()
        return _answer({**told, "situations": [*known, *told["situations"]], "now": self._now()})

    async def play(self, request: Request) -> Response:
        wanted = msgspec.json.decode(await request.body(), type=Wanted).situation
        found = request.path_params["robot_id"]
        player: Director | LateSensors = self._director
        if self._sensors is not None and self._sensors.has(found):
            player = self._sensors
        try:
            player.provoke(found, wanted)
        except KeyError as problem:
            return error(404, "unknown", f"There is no robot, station or situation {problem.args[0]!r} here.")
        except ValueError as problem:
            return error(409, "not_possible", f"{problem}.")
        return _answer({"now": self._now()})

    def _now(self) -> dict[str, str]:
        return self._director.now() | (self._sensors.told()["now"] if self._sensors is not None else {})


class _Pace:
    def __init__(self, world: World) -> None:
        self._world = world

    async def serve(self, request: Request) -> Response:
        if request.method == "POST":
            self._world.speed = msgspec.json.decode(await request.body(), type=Pace).speed
        return _answer({"speed": self._world.speed, "robots": sorted(self._world.robots)})


def truth(robot: SimRobot, now_s: float) -> dict[str, Any]:
    """Return what is really so; ``*_age_s`` count from now, ``None`` means never or not now."""
    base, boot = robot.machine.base, robot.boot
    drive = boot.brain.last_drive if boot is not None else None
    is_driven = drive is not None and math.isfinite(drive.heard_s)
    return {
        "is_on": boot is not None,
        "boot": boot.brain.boot if boot is not None else None,
        "mode": boot.brain.mode if boot is not None else None,
        "x_m": base.x_m,
        "y_m": base.y_m,
        "theta_rad": base.theta_rad,
        "speed_mps": base.speed_mps,
        "yaw_rate_radps": base.yaw_rate_radps,
        "distance_m": base.distance_m,
        "laser_on": robot.machine.tool_on,
        "soc": robot.machine.soc,
        "standstill": robot.machine.is_standing,
        "latched": boot.brain.latch.is_set if boot is not None else None,
        "stopped_age_s": None if robot.stopped_at_s is None else now_s - robot.stopped_at_s,
        "drive_age_s": now_s - drive.heard_s if drive is not None and is_driven else None,
        "drive_v_mps": drive.v_mps if drive is not None and is_driven else None,
        "setpoint_to_standstill_s": (
            robot.stopped_at_s - drive.heard_s
            if drive is not None and is_driven and robot.stopped_at_s is not None
            else None
        ),
        "faults": [name_of(fault) for fault in robot.faults.list()],
    }


def _local(handler: Handler) -> Handler:
    async def serve(request: Request) -> Response:
        if request.client is None or request.client.host not in LOOPBACK:
            return error(403, "loopback_only", "Only this machine may do that.")
        if int(request.headers.get("content-length", "0") or "0") > MAX_BODY:
            return error(413, "too_large", f"More than {MAX_BODY} bytes.")
        try:
            return await handler(request)
        except msgspec.DecodeError as problem:
            return error(400, "bad_request", str(problem))

    return serve


def _answer(content: dict[str, Any]) -> Response:
    return Response(msgspec.json.encode(content), media_type="application/json")

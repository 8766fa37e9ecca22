"""The robots' own HTTP endpoint, as ``backend_clients.edge.http`` speaks to it, several robots on one port."""

from __future__ import annotations

import asyncio
import hmac
from collections.abc import Awaitable, Callable

import msgspec
from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from backend_clients.edge import codec
from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Address, Down, is_id
from backend_clients.errors import MalformedPayload, OversizedPayload, WireError
from backend_clients.simulator.cameras.web import CameraWeb, camera_web
from backend_clients.simulator.datasheet import urdf
from backend_clients.simulator.unreadable_stop import read_anyway
from backend_clients.simulator.world import Boot, SimRobot, World

MAX_SILENCE_S = 30.0
MAX_LOG_LINES = 2000

Handler = Callable[[Request, SimRobot, Boot], Awaitable[Response]]
OnAck = Callable[[str, up.Ack], None]


class RobotEndpoint:
    """Answers for every robot of a world; all handlers run on the world's event loop.

    Args:
        world: the robots.
        on_ack: told of each order taken by HTTP, so that MQTT reports the change too.
        cameras: answers for their cameras.
    """

    def __init__(self, world: World, on_ack: OnAck, cameras: CameraWeb | None = None) -> None:
        self._world, self._on_ack = world, on_ack
        self.cameras = cameras or camera_web(world)
        self._closing = asyncio.Event()

    def routes(self) -> list[Route]:
        """Return the routes below ``/{robot_id}/``."""
        table: list[tuple[str, str, Handler]] = [
            ("stop", "POST", self._stop),
            ("stop-reset", "POST", self._reset),
            ("safety", "GET", self._safety),
            ("state", "GET", self._state),
            ("factsheet", "GET", self._factsheet),
            ("missions/{mission_id}", "PUT", self._put_mission),
            ("missions/{mission_id}", "GET", self._get_mission),
            ("logs", "GET", self._logs),
            ("map", "GET", self._map),
            ("model", "GET", self._model),
            ("cameras", "GET", self.cameras.list),
            ("cameras/{camera_id}/stream", "GET", self.cameras.stream),
            ("cameras/{camera_id}/still", "GET", self.cameras.still),
            ("cameras/{camera_id}/detections", "GET", self.cameras.detections),
            ("cameras/{camera_id}/control", "POST", self.cameras.control),
            ("cameras/{camera_id}/control", "GET", self.cameras.told),
        ]
        return [
            Route("/{robot_id}/" + path, self._guarded(handler), methods=[method]) for path, method, handler in table
        ]

    def close(self) -> None:
        """Let requests held by a silence fault go, and end every stream of a camera."""
        self._closing.set()
        self.cameras.close()

    def _guarded(self, handler: Handler) -> Callable[[Request], Awaitable[Response]]:
        async def serve(request: Request) -> Response:
            robot = self._world.robots.get(request.path_params["robot_id"])
            if robot is None:
                return error(404, "unknown_robot", "There is no such robot here.")
            if not _has_token(request, robot.config.token):
                return error(401, "bad_token", "The robot does not accept this token.")
            silence = robot.faults.silence
            if robot.boot is None or (silence is not None and silence.http and silence.deaf):
                return await self._say_nothing()
            try:
                response = await handler(request, robot, robot.boot)
            except OversizedPayload as problem:
                return error(413, "too_large", str(problem))
            except WireError as problem:
                return error(400, "bad_request", str(problem))
            except ClientDisconnect:
                return error(400, "disconnected", "The sender went away.")
            if silence is not None and silence.http:
                return await self._say_nothing()
            return response

        return serve

    async def _say_nothing(self) -> Response:
        try:
            async with asyncio.timeout(MAX_SILENCE_S):
                await self._closing.wait()
        except TimeoutError:
            pass
        return error(503, "silent", "The robot did not answer.")

    async def _stop(self, request: Request, robot: SimRobot, boot: Boot) -> Response:
        body = await _body(request, codec.MAX_BYTES)
        try:
            order = codec.decode_body(Address(robot.config.id, Down.STOP), body)
        except MalformedPayload:
            meant = read_anyway(robot.config.id, body)
            if meant is None:
                raise
            order = meant
        assert isinstance(order, down.Stop)
        return self._answer(robot, boot.desk.receive(order))

    async def _reset(self, request: Request, robot: SimRobot, boot: Boot) -> Response:
        body = await _body(request, codec.MAX_BYTES)
        order = codec.decode_body(Address(robot.config.id, Down.STOP_RESET), body)
        assert isinstance(order, down.StopReset)
        return self._answer(robot, boot.desk.receive(order))

    async def _put_mission(self, request: Request, robot: SimRobot, boot: Boot) -> Response:
        body = await _body(request, codec.MAX_MISSION_BYTES)
        order = codec.decode_body(Address(robot.config.id, Down.MISSION), body)
        assert isinstance(order, down.Mission)
        if order.mission_id != request.path_params["mission_id"]:
            return error(400, "wrong_mission", "Address and content name different missions.")
        return self._answer(robot, boot.desk.receive(order))

    async def _get_mission(self, request: Request, _robot: SimRobot, boot: Boot) -> Response:
        run = boot.brain.run
        if not is_id(request.path_params["mission_id"]) or run is None:
            return error(404, "no_mission", "The robot has no such mission.")
        if run.mission.mission_id != request.path_params["mission_id"]:
            return error(404, "no_mission", "The robot has no such mission.")
        return _json(run.mission)

    async def _safety(self, _request: Request, _robot: SimRobot, boot: Boot) -> Response:
        return _json(boot.reporter.safety())

    async def _state(self, _request: Request, _robot: SimRobot, boot: Boot) -> Response:
        return _json(boot.reporter.state())

    async def _factsheet(self, _request: Request, _robot: SimRobot, boot: Boot) -> Response:
        return _json(boot.reporter.factsheet())

    async def _logs(self, request: Request, _robot: SimRobot, boot: Boot) -> Response:
        wanted = request.query_params.get("lines", "200")
        if not wanted.isascii() or not wanted.isdigit() or len(wanted) > 6:
            return error(400, "bad_request", "lines must be a number.")
        node = request.query_params.get("node", "")
        if node and node not in boot.brain.nodes.lives:
            return error(404, "unknown_node", "The robot has no such node.")
        text = boot.brain.journal.tail(min(int(wanted), MAX_LOG_LINES), node)
        return Response(text, media_type="text/plain; charset=utf-8")

    async def _map(self, _request: Request, _robot: SimRobot, boot: Boot) -> Response:
        run = boot.brain.run
        if run is None:
            return error(404, "no_map", "The robot has no map; it gets one with a mission.")
        geometry = {"type": "Polygon", "coordinates": run.mission.parcel}
        feature = {"type": "Feature", "properties": {"name": run.mission.field_name}, "geometry": geometry}
        return Response(
            msgspec.json.encode({"type": "FeatureCollection", "features": [feature]}),
            media_type="application/geo+json",
        )

    async def _model(self, _request: Request, robot: SimRobot, _boot: Boot) -> Response:
        return Response(urdf(robot.config), media_type="application/xml")

    def _answer(self, robot: SimRobot, ack: up.Ack | None) -> Response:
        assert ack is not None  # these orders are always answered
        self._on_ack(robot.config.id, ack)
        return _json(ack)


def application(endpoint: RobotEndpoint, more: list[Route]) -> Starlette:
    """Return the ASGI application; ``more`` are the simulator's own routes and come first."""
    return Starlette(routes=[*more, *endpoint.routes()])


def error(status: int, code: str, text: str) -> Response:
    """Return an error with a code and a sentence."""
    return JSONResponse({"code": code, "text": text[:400]}, status_code=status)


def _has_token(request: Request, token: str) -> bool:
    scheme, _, given = request.headers.get("authorization", "").partition(" ")
    return scheme.lower() == "bearer" and hmac.compare_digest(given.encode(), token.encode())


def _json(message: msgspec.Struct) -> Response:
    return Response(msgspec.json.encode(message), media_type="application/json")


async def _body(request: Request, limit: int) -> bytes:
    parts, size = [], 0
    async for chunk in request.stream():
        size += len(chunk)
        if size > limit:
            raise OversizedPayload(f"more than {limit} bytes")
        parts.append(chunk)
    return b"".join(parts)

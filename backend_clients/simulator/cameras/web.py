"""The cameras on a robot's HTTP: stream, still, detections and control, as docs/protocols/cameras.md says."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Callable, Iterable, Sequence
from dataclasses import dataclass

import msgspec
from msgspec import Struct
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

from backend_clients.edge import messages_up as up
from backend_clients.simulator.cameras.map_feature import MapFeature
from backend_clients.simulator.cameras.observer import Observer, camera_of, node_of
from backend_clients.simulator.cameras.scene import Look, Picture, Scene
from backend_clients.simulator.cameras.scenery import Scenery
from backend_clients.simulator.cameras.sight import Sight
from backend_clients.simulator.cameras.studio import NoPicture, Studio
from backend_clients.simulator.faults import CameraFreeze, CameraGarbage, NodeSilent, NodeSlow
from backend_clients.simulator.world import Boot, SimRobot, World

BOUNDARY = "frame"
MOST_FPS = 30.0
LOOK_AGAIN_S = 0.1  # while nothing may be sent
RETRY_S = 0.5
TRIGGER_S = 5.0  # as cameras of the published system take pictures
READY_AFTER_S = 10.0  # the demo's other parts start first
SMALL_PX = 64
log = logging.getLogger(__name__)


class Control(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a camera is told; what is left out stays."""

    lamp: bool | None = None
    zoom: float | None = None
    trigger: bool = False


@dataclass(slots=True)
class Shot:
    """A picture with when it was taken, robot wall clock and simulator's monotonic clock, and how old it is."""

    picture: Picture
    wall_ms: int
    taken_s: float
    age_ms: int


class CameraWeb:
    """Answers for the cameras of every robot.

    Args:
        observer: takes the looks.
        studio: draws them.
    """

    def __init__(self, observer: Observer, studio: Studio) -> None:
        self._observer, self._studio = observer, studio
        self._closing = asyncio.Event()
        self.pulled = 0

    def close(self) -> None:
        """End every stream."""
        self._closing.set()

    async def ended(self) -> None:
        """End the drawing process too."""
        self.close()
        await self._studio.close()

    async def prepare(self, robots: Iterable[SimRobot]) -> None:
        """Have the drawing process ready: its start is what a first picture waits longest for."""
        await asyncio.sleep(READY_AFTER_S)
        for robot in robots:
            for camera in robot.config.profile.cameras[:1]:
                with contextlib.suppress(NoPicture):
                    await self._shoot(robot, camera, SMALL_PX, is_hasty=True)
                return

    async def list(self, _request: Request, robot: SimRobot, _boot: Boot) -> Response:
        """``GET cameras``."""
        return _json(list(robot.config.profile.cameras))

    async def still(self, request: Request, robot: SimRobot, boot: Boot) -> Response:
        """``GET cameras/{id}/still``."""
        camera = _camera(request, robot)
        if camera is None:
            return _error(404, "unknown_camera", "The robot has no such camera.")
        reason = why_down(robot, boot, camera.id) or why_silent(robot, camera.id)
        if reason:
            return _error(503, "camera_down", reason)
        try:
            shot = await self._shoot(robot, camera, _number(request, "width", camera.width_px))
        except NoPicture as problem:
            return _error(503, "camera_down", str(problem))
        jpeg = _broken(shot.picture.jpeg, shot.wall_ms) if robot.faults.of(CameraGarbage) else shot.picture.jpeg
        headers = {"X-Captured-Ms": str(shot.wall_ms), "X-Age-Ms": str(shot.age_ms), "Cache-Control": "no-store"}
        return Response(jpeg, media_type="image/jpeg", headers=headers)

    async def stream(self, request: Request, robot: SimRobot, boot: Boot) -> Response:
        """``GET cameras/{id}/stream``."""
        asked_ms = self._observer.wall_ms(robot)
        camera = _camera(request, robot)
        if camera is None:
            return _error(404, "unknown_camera", "The robot has no such camera.")
        reason = why_down(robot, boot, camera.id)
        if reason:
            return _error(503, "camera_down", reason)
        fps = min(max(_number(request, "fps", camera.fps or 15), 0.2), camera.fps or 15, MOST_FPS)
        width = _number(request, "width", camera.width_px)
        parts = self._parts(robot, boot, camera, fps, width)
        headers = {"Cache-Control": "no-store", "X-Asked-Ms": str(asked_ms)}
        return StreamingResponse(parts, media_type=f"multipart/x-mixed-replace; boundary={BOUNDARY}", headers=headers)

    async def detections(self, request: Request, robot: SimRobot, _boot: Boot) -> Response:
        """``GET cameras/{id}/detections``: of the newest picture somebody pulled, none if nobody does."""
        camera = _camera(request, robot)
        if camera is None:
            return _error(404, "unknown_camera", "The robot has no such camera.")
        sight = robot.sights.get(camera.id)
        if sight is None or not sight.is_fresh(self._observer.clock.mono_s()):
            return _json({"camera": camera.id, "captured_ms": None, "boxes": []})
        return _json({"camera": camera.id, "captured_ms": sight.captured_ms, "boxes": sight.boxes})

    async def control(self, request: Request, robot: SimRobot, _boot: Boot) -> Response:
        """``POST cameras/{id}/control``."""
        camera = _camera(request, robot)
        if camera is None:
            return _error(404, "unknown_camera", "The robot has no such camera.")
        try:
            wanted = msgspec.json.decode(await request.body(), type=Control)
        except msgspec.DecodeError as problem:
            return _error(400, "bad_request", str(problem))
        refusal = _refusal(wanted, camera)
        if refusal:
            return _error(409, "not_possible", refusal)
        setting = self._observer.setting(robot.config.id, camera.id)
        now_s = self._observer.clock.mono_s()
        if wanted.trigger and now_s - setting.shot_s < TRIGGER_S:
            text = f"It takes a picture each {TRIGGER_S:g} s. The last one is {now_s - setting.shot_s:.1f} s old."
            return _error(409, "too_soon", text)
        if wanted.lamp is not None:
            setting.lamp = wanted.lamp
        if wanted.zoom is not None:
            setting.zoom = wanted.zoom
        if wanted.trigger:
            setting.shot_s, setting.shots = now_s, setting.shots + 1
        return Response(status_code=204)

    async def told(self, request: Request, robot: SimRobot, _boot: Boot) -> Response:
        """``GET cameras/{id}/control``."""
        camera = _camera(request, robot)
        if camera is None:
            return _error(404, "unknown_camera", "The robot has no such camera.")
        setting = self._observer.setting(robot.config.id, camera.id)
        return _json({"lamp": setting.lamp, "zoom": setting.zoom})

    async def _parts(
        self, robot: SimRobot, boot: Boot, camera: up.Camera, fps: float, width: float
    ) -> AsyncIterator[bytes]:
        loop = asyncio.get_running_loop()
        due_s, is_first = loop.time(), True
        self.pulled += 1
        try:
            while not self._closing.is_set():
                if robot.boot is not None and (robot.boot is not boot or why_down(robot, boot, camera.id)):
                    return  # its computer or its node is not what it was: whoever watches asks again
                if robot.boot is None or why_silent(robot, camera.id):
                    await self._pause(LOOK_AGAIN_S)
                    continue
                try:
                    shot = await self._shoot(robot, camera, width, is_hasty=is_first)
                except NoPicture:
                    await self._pause(RETRY_S)
                    continue
                is_first = False
                is_garbage = robot.faults.of(CameraGarbage) is not None
                yield part(shot, _broken(shot.picture.jpeg, shot.wall_ms) if is_garbage else shot.picture.jpeg)
                slow = robot.faults.of(NodeSlow)
                is_slow = slow is not None and slow.node == node_of(robot.config.family, camera.id)
                pace = fps * (max(slow.share, 0.05) if slow is not None and is_slow else 1.0)
                due_s = max(due_s + 1 / pace, loop.time())
                await self._pause(due_s - loop.time())
        finally:
            self.pulled -= 1

    async def _shoot(self, robot: SimRobot, camera: up.Camera, width: float, *, is_hasty: bool = False) -> Shot:
        taken_s, wall_ms = 0.0, 0

        def take() -> tuple[Look, Callable[[], Scene]]:
            nonlocal taken_s, wall_ms
            look, make_scene = self._observer.take(robot, camera, int(width), is_hasty=is_hasty)
            taken_s, wall_ms = self._observer.clock.mono_s(), look.wall_ms
            return look, make_scene

        try:
            picture = await self._studio.picture(take)
        except NoPicture:
            raise
        except Exception as problem:
            log.exception("camera %s/%s: the scene cannot be made", robot.config.id, camera.id)
            raise NoPicture("The camera's computer failed; its log says why.") from problem
        robot.sights[camera.id] = Sight(camera.id, taken_s, wall_ms, picture.boxes)
        return Shot(picture, wall_ms, taken_s, max(round((self._observer.clock.mono_s() - taken_s) * 1000), 0))

    async def _pause(self, seconds: float) -> None:
        try:
            async with asyncio.timeout(max(seconds, 0.001)):
                await self._closing.wait()
        except TimeoutError:
            pass


def camera_web(world: World, features: Sequence[MapFeature] = (), *, is_always_day: bool = False) -> CameraWeb:
    """Return what answers for the cameras of a world; nothing is started before a picture is asked for."""
    return CameraWeb(Observer(world.robots, world.clock, Scenery(tuple(features)), is_always_day), Studio())


def part(shot: Shot, jpeg: bytes) -> bytes:
    """Return one part of a multipart stream."""
    head = (
        f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n"
        f"X-Captured-Ms: {shot.wall_ms}\r\nX-Age-Ms: {shot.age_ms}\r\n\r\n"
    )
    return head.encode("ascii") + jpeg + b"\r\n"


def why_down(robot: SimRobot, boot: Boot, camera_id: str) -> str:
    """Return why a camera gives no picture, empty if it does."""
    name = node_of(robot.config.family, camera_id)
    life = boot.brain.nodes.lives.get(name)
    if life is None or life.state == "started":
        return ""
    return f"{life.node.label or name} is {'in error' if life.state == 'failure' else life.state}."


def why_silent(robot: SimRobot, camera_id: str) -> str:
    """Return why a camera that is there sends nothing, empty if it does."""
    silent = robot.faults.of(NodeSilent)
    if silent is not None and silent.node == node_of(robot.config.family, camera_id):
        return "Nothing is heard of its software."
    freeze = robot.faults.of(CameraFreeze)
    if freeze is not None and freeze.camera in ("", camera_id):
        return "The camera hangs."
    silence = robot.faults.silence
    return "The robot is silent." if silence is not None and silence.http else ""


def _broken(jpeg: bytes, seed: int) -> bytes:
    """Return what a bad cable makes of a picture: cut off, or bytes of it changed."""
    if seed % 3 == 0:
        return jpeg[: len(jpeg) // 2]
    if seed % 3 == 1:
        return bytes((byte * 31 + seed) & 0xFF for byte in jpeg[:4000])
    middle = len(jpeg) // 3
    return jpeg[:middle] + b"\xff\xd8\xff\x00" * 64 + jpeg[middle + 256 :]


def _refusal(wanted: Control, camera: up.Camera) -> str:
    if wanted.lamp is not None and not camera.has_lamp:
        return "This camera has no lamp."
    if wanted.trigger and not camera.has_trigger:
        return "This camera takes no single pictures."
    if wanted.zoom is not None:
        span = camera.ptz.zoom if camera.ptz is not None else None
        if span is None:
            return "This camera cannot zoom."
        if not span[0] <= wanted.zoom <= span[1]:
            return f"It zooms from {span[0]:g} to {span[1]:g}."
    return ""


def _camera(request: Request, robot: SimRobot) -> up.Camera | None:
    return camera_of(robot.config.profile.cameras, request.path_params["camera_id"])


def _number(request: Request, name: str, usual: float) -> float:
    try:
        value = float(request.query_params.get(name, usual))
    except ValueError:
        return usual
    return value if 0 < value < 1e5 else usual


def _json(content: object) -> Response:
    return Response(msgspec.json.encode(content), media_type="application/json")


def _error(status: int, code: str, text: str) -> Response:
    return Response(
        msgspec.json.encode({"code": code, "text": text}), status_code=status, media_type="application/json"
    )

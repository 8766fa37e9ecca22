"""Cameras in the console: which sources there are, who may see them, and the way to the camera process."""

from __future__ import annotations

import asyncio
import contextlib
import io
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from datetime import UTC, datetime
from typing import Any

import httpx
import msgspec
from fastapi import APIRouter
from starlette.routing import BaseRoute

from hmi.api.cameras import CameraAnswer, CameraRoutes, CamerasAway, camera_routes
from hmi.app.camera_link import CameraLink, CamerasDown
from hmi.app.camera_socket import CameraSockets, OriginRule, viewer_of
from hmi.app.camera_sources import FleetView, SourceRule, robot_sources
from hmi.app.records import Records
from hmi.cameras.door import CAPTURED_HEADER, DATED_HEADER, SEQ_HEADER, VIEWER_HEADER, WATCHER_HEADER
from hmi.commands.lease_service import LeaseService
from hmi.commands.watermark import mark_of, watermarked
from hmi.domain.camera import CameraSetting, Source
from hmi.domain.function_use import camera_obstacle
from hmi.ingest.sender import EdgeSender
from hmi.live.lane import SessionGate
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.settings import Settings

log = logging.getLogger(__name__)
SYNC_S = 1.0
SESSIONS = "/api/v1/cameras"
CLIPS = "/clips"
PASSED_BACK = (CAPTURED_HEADER, DATED_HEADER, SEQ_HEADER)


class CameraDesk:
    """Everything about cameras in the console; costs nothing while nobody looks.

    ``rule`` may be replaced: it turns the robots' own sources into what is really opened. ``on_new`` is called when a
    new camera process knows the sources. ``has_watermark``: whether
    who looks is burnt into single pictures that are sent out.
    """

    def __init__(
        self,
        link: CameraLink,
        own_sources: Callable[[], list[Source]],
        gate: SessionGate,
        authorize: Authorize,
        sender: EdgeSender,
    ) -> None:
        self.link, self._gate, self._authorize, self._sender = link, gate, authorize, sender
        self._own_sources = own_sources
        self.rule: SourceRule = list
        self.has_watermark = False
        self.on_new: Callable[[], Awaitable[None]] | None = None
        self._telling_anew: asyncio.Task[None] | None = None
        self._told: tuple[int | None, bytes] | None = None
        self._telling = asyncio.Lock()
        self._pages = 0
        self._task: asyncio.Task[None] | None = None

    @classmethod
    def of(
        cls, settings: Settings, records: Records, fleet: FleetView, authorize: Authorize, sender: EdgeSender
    ) -> CameraDesk:
        """Make it from what the console has."""
        desk = cls(
            CameraLink(settings.data),
            lambda: robot_sources(records.robots.all(), fleet),
            records.sessions,
            authorize,
            sender,
        )
        desk.has_watermark = settings.picture_watermark
        return desk

    def routes(self, origins: OriginRule) -> list[BaseRoute]:
        """Return the route of ``/cameras/live``."""
        return CameraSockets(self.link, self._gate, self._authorize, origins, self._look).routes()

    def rest(self, records: Records, leases: LeaseService, fleet: FleetView) -> APIRouter:
        """Return the REST routes."""

        def obstacle(robot_id: str) -> str:
            robot = fleet.robot(robot_id)
            return "" if robot is None else camera_obstacle(robot)

        parts = CameraRoutes(
            cameras=self,
            authorize=self._authorize,
            holds=lambda session_id, robot_id: leases.holds(session_id, robot_id) is not None,
            obstacle=obstacle,
            audit=records.audit,
            stamp=_stamped if self.has_watermark else None,
        )
        return camera_routes(parts)

    async def stop(self) -> None:
        """End what runs."""
        tasks = [task for task in (self._task, self._telling_anew) if task is not None]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await self.link.close()

    @property
    def is_open(self) -> bool:
        """Whether any page shows pictures."""
        return self._pages > 0

    def sources(self) -> list[Source]:
        """Return what the camera process may open now."""
        return self.rule(self._own_sources())

    async def sync(self) -> None:
        """Tell the camera process what changed, or everything if it is a new one; raises ``CamerasDown``."""
        async with self._telling:
            pid = self.link.pid()
            if pid is None:  # nobody to tell: of thousands of robots the list alone takes a while
                raise CamerasDown("it was not started")
            sources = msgspec.json.encode({"sources": self.sources()})
            if self._told != (pid, sources):
                _whole(await self.link.ask("PUT", "/sources", sources))
                is_new = self._told is None or self._told[0] != pid
                self._told = (pid, sources)
                if is_new and self.on_new is not None:
                    self._telling_anew = asyncio.create_task(self._tell_anew(self.on_new), name="camera-frames")

    async def all(self) -> list[dict[str, Any]]:
        """See ``CameraAsk``."""
        try:
            await self.sync()
            answer = _whole(await self.link.ask("GET", "/cameras"))
        except CamerasDown as down:
            raise CamerasAway from down
        found: list[dict[str, Any]] = answer.json()["cameras"]
        return found

    async def ask(
        self,
        session: SessionInfo,
        method: str,
        path: str,
        body: bytes | None = None,
        watcher: str = "",
    ) -> CameraAnswer:
        """See ``CameraAsk``."""
        headers = {VIEWER_HEADER: viewer_of(session), **({WATCHER_HEADER: watcher} if watcher else {})}
        try:
            await self.sync()
            answer = await self.link.ask(method, path, body, headers)
        except CamerasDown as down:
            raise CamerasAway from down
        back = {name: answer.headers[name] for name in PASSED_BACK if name in answer.headers}
        if "location" in answer.headers:
            back["location"] = SESSIONS + answer.headers["location"]
        return CameraAnswer(answer.status_code, answer.content, answer.headers.get("content-type", ""), back)

    async def control(self, robot_id: str, camera: str, order: dict[str, Any]) -> None:
        """See ``CameraAsk``."""
        await self._sender.control_camera(robot_id, camera, order)

    async def setting(self, robot_id: str, camera: str) -> CameraSetting:
        """See ``CameraAsk``."""
        return await self._sender.camera_setting(robot_id, camera)

    async def call(self, method: str, path: str, content: bytes | None, limit_s: float) -> httpx.Response:
        """Return what the camera process answers, which knows all sources by then; raises ``CamerasDown``.

        A clip is cut out of what it kept: what it does not know by itself has none, and a STOP ALL asks for thousands.
        """
        if path != CLIPS:
            await self.sync()
        return await self.link.ask(method, path, content, limit_s=limit_s)

    @contextlib.asynccontextmanager
    async def _look(self) -> AsyncIterator[None]:
        """While a page watches, the camera process learns within a second of robots that come and go."""
        self._pages += 1
        try:
            await self.sync()
            self._keep_telling()
            yield
        finally:
            self._pages -= 1

    async def _tell_anew(self, tell: Callable[[], Awaitable[None]]) -> None:
        try:
            await tell()
        except Exception:  # the end of a task: nobody above would say it
            log.exception("the new camera process was not told everything")

    def _keep_telling(self) -> None:
        if self._task is None:
            self._task = asyncio.get_running_loop().create_task(self._tell_while_needed(), name="camera-sources")

    async def _tell_while_needed(self) -> None:
        try:
            while self._pages:
                with contextlib.suppress(CamerasDown):  # it comes back, and is told everything then
                    await self.sync()
                await asyncio.sleep(SYNC_S)
        finally:
            self._task = None


async def _stamped(session: SessionInfo, jpeg: bytes) -> bytes:
    """Burn who looks and when into a picture that is sent out; one that cannot be drawn on is not sent."""
    told = mark_of(session.user_name, datetime.now(UTC))
    return await asyncio.to_thread(watermarked, io.BytesIO(jpeg), told)


def _whole(answer: httpx.Response) -> httpx.Response:
    if answer.status_code >= 400:
        raise CamerasDown(f"it answers {answer.status_code}: {answer.text[:200]}")
    return answer

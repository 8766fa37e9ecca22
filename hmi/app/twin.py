"""The twin in the console: viser's page under our origin, its sockets, and what the media process must know."""

from __future__ import annotations

import asyncio
import contextlib
from collections import Counter
from collections.abc import AsyncIterator, Mapping, Sequence

from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response
from starlette.routing import BaseRoute, Route

from hmi.api.twin import TwinRoutes, twin_routes
from hmi.app.media_link import MediaDown, MediaLink
from hmi.app.media_models import MediaModels
from hmi.app.records import Records
from hmi.app.twin_news import TwinNews
from hmi.app.twin_pictures import TwinPictures
from hmi.app.viser_page import CLIENT_PATH, viser_page
from hmi.app.viser_proxy import OriginRule, TwinSockets
from hmi.clock import Clock
from hmi.commands.camera_ports import CameraProcess
from hmi.commands.ports import FleetReader
from hmi.live.lane import SessionGate
from hmi.security.authorization import Authorize
from hmi.settings import Settings

NEWS_S = 2.0
PICTURES = 2  # for each round of news: two seconds are long for who looks through a camera
FOR_GOOD = "public, max-age=31536000, immutable"


class TwinDesk:
    """Everything about the twin; costs nothing while nobody looks."""

    def __init__(self, link: MediaLink, gate: SessionGate, authorize: Authorize, news: TwinNews) -> None:
        self.link, self._gate, self._authorize, self._news = link, gate, authorize, news
        self.cameras: CameraProcess | None = None
        self._pictures = TwinPictures(link, lambda: self.cameras)
        self._watched: Counter[str] = Counter()
        self._task: asyncio.Task[None] | None = None

    @classmethod
    def of(
        cls, settings: Settings, records: Records, fleet: FleetReader, authorize: Authorize, clock: Clock
    ) -> TwinDesk:
        """Make it from what the console has."""
        link = MediaLink(settings.data)
        news = TwinNews(
            link,
            fleet,
            records.robots,
            records.missions,
            records.features,
            records.history,
            records.database,
            settings.farm_id,
            clock,
        )
        return cls(link, records.sessions, authorize, news)

    def routes(self, origins: OriginRule) -> list[BaseRoute]:
        """Return the routes below ``/viser``."""
        sockets = TwinSockets(self.link, self._gate, self._authorize, origins, self._look)
        return [Route("/viser/", self._page), Route(CLIENT_PATH, self._client), *sockets.routes()]

    async def stop(self) -> None:
        """End what runs."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await self._pictures.close()
        await self.link.close()

    def rest(self, records: Records, clock: Clock) -> APIRouter:
        """Return the REST routes."""
        parts = TwinRoutes(
            MediaModels(self.link),
            records.history,
            records.robots,
            records.database,
            self._authorize,
            records.audit,
            clock,
        )
        return twin_routes(parts)

    @contextlib.asynccontextmanager
    async def _look(self, robot_id: str) -> AsyncIterator[None]:
        """While somebody looks at a robot the media process is told what it works on."""
        self._watched[robot_id] += 1
        self._news.forget(robot_id)
        try:
            await self._news.tell(self._robots())
            if self._task is None:
                self._task = asyncio.get_running_loop().create_task(self._keep_telling(), name="twin-news")
            yield
        finally:
            self._watched[robot_id] -= 1

    def _robots(self) -> list[str]:
        return [robot_id for robot_id, lookers in self._watched.items() if lookers > 0]

    async def _keep_telling(self) -> None:
        while self._robots():
            wanted: Mapping[str, Sequence[str]] = {}
            with contextlib.suppress(MediaDown):  # it comes back, and is told everything then
                wanted = await self._news.tell(self._robots())
            for _ in range(PICTURES):
                self._pictures.carry(wanted)
                await asyncio.sleep(NEWS_S / PICTURES)
        self._task = None

    async def _page(self, request: Request) -> Response:
        if self._gate.of_headers(request.scope["headers"]) is None:
            return Response("Sign in first.", 401, media_type="text/plain")
        page = await asyncio.to_thread(viser_page)
        return HTMLResponse(page.html)

    async def _client(self, request: Request) -> Response:
        page = await asyncio.to_thread(viser_page)
        headers = {"cache-control": FOR_GOOD, "vary": "accept-encoding"}
        if "gzip" in request.headers.get("accept-encoding", ""):
            headers["content-encoding"] = "gzip"
            return Response(page.code_packed, media_type="application/javascript", headers=headers)
        return Response(page.code, media_type="application/javascript", headers=headers)

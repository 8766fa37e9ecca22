"""Base maps in the console: their files, their book and their routes."""

from __future__ import annotations

from fastapi import APIRouter

from hmi.api.base_maps import OnlineMap, base_map_routes
from hmi.app.records import Records
from hmi.base_maps.files import BaseMapFiles
from hmi.base_maps.worker import BaseMapMaker
from hmi.clock import Clock
from hmi.commands.base_map_book import MB, BaseMapBook, BaseMapParts
from hmi.commands.ports import LaneEvent
from hmi.security.authorization import Authorize
from hmi.settings import Settings


class BaseMapDesk:
    """Everything about base maps."""

    def __init__(
        self, settings: Settings, records: Records, clock: Clock, authorize: Authorize, on_event: LaneEvent
    ) -> None:
        url = settings.online_tiles_url
        self._online = OnlineMap(url, settings.online_tiles_credit, settings.online_tiles_max_zoom) if url else None
        self.book = BaseMapBook(
            BaseMapParts(
                records=records.base_maps,
                files=BaseMapFiles(settings.data / "base_maps"),
                maker=BaseMapMaker(),
                database=records.database,
                authorize=authorize,
                audit=records.audit,
                clock=clock,
                on_event=on_event,
                farm_bytes=settings.base_map_mb * MB,
                upload_bytes=settings.base_map_upload_mb * MB,
            )
        )

    def routes(self) -> APIRouter:
        """Return the REST routes of base maps."""
        return base_map_routes(self.book, self._online)

    async def prepare(self) -> None:
        """Throw away uploads that an earlier process did not finish."""
        await self.book.prepare()

    async def stop(self) -> None:
        """Give up what is being made."""
        await self.book.close()

"""The map builder in the console: its book and its routes."""

from __future__ import annotations

from fastapi import APIRouter

from hmi.api.maps import map_routes
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.commands.map_book import MapBook, MapParts
from hmi.commands.map_exchange import MapExchange
from hmi.commands.ports import LaneEvent
from hmi.map_files.worker import MapReader
from hmi.security.authorization import Authorize
from hmi.settings import Settings


class MapDesk:
    """Everything about the farm's map."""

    def __init__(
        self, settings: Settings, records: Records, clock: Clock, authorize: Authorize, on_event: LaneEvent
    ) -> None:
        self._reader = MapReader()
        self.book = MapBook(
            MapParts(
                maps=records.maps,
                database=records.database,
                authorize=authorize,
                audit=records.audit,
                clock=clock,
                on_event=on_event,
            )
        )
        self.exchange = MapExchange(self.book, self._reader, authorize, settings.farm_name)

    def routes(self) -> APIRouter:
        """Return the REST routes of the map."""
        return map_routes(self.book, self.exchange)

    async def stop(self) -> None:
        """Give up a file that is being read."""
        await self._reader.close()

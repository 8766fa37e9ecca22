"""The map builder in the console: its book and its routes."""

from __future__ import annotations

from fastapi import APIRouter

from hmi.api.maps import map_routes
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.commands.map_book import MapBook, MapParts
from hmi.commands.map_exchange import MapExchange
from hmi.commands.map_review import MapReview
from hmi.commands.ports import FleetReader, LaneEvent
from hmi.map_files.worker import MapReader
from hmi.security.authorization import Authorize
from hmi.settings import Settings


class MapDesk:
    """Everything about the farm's map."""

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        records: Records,
        fleet: FleetReader,
        authorize: Authorize,
        on_event: LaneEvent,
    ) -> None:
        self._reader = MapReader()
        self._fleet = fleet
        parts = MapParts(
            maps=records.maps,
            database=records.database,
            authorize=authorize,
            audit=records.audit,
            clock=clock,
            on_event=on_event,
            width_of=self._width_of,
        )
        self.book, self.review = MapBook(parts), MapReview(parts)
        self.exchange = MapExchange(self.book, self._reader, authorize, settings.farm_name)

    def routes(self) -> APIRouter:
        """Return the REST routes of the map."""
        return map_routes(self.book, self.review, self.exchange)

    async def stop(self) -> None:
        """Give up a file that is being read."""
        await self._reader.close()

    def _width_of(self, robot_id: str) -> float | None:
        robot = self._fleet.robot(robot_id)
        return robot.factsheet.width_m if robot is not None and robot.factsheet is not None else None

"""Field sensors in the console. What serves them is loaded some seconds after the start, or when somebody asks."""

from __future__ import annotations

import asyncio
import contextlib
import importlib
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter

from hmi.api.sensors import SensorServices, sensor_routes
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.commands.ports import LaneEvent
from hmi.commands.weather import WeatherBoard
from hmi.domain.alarm.finding import Findings
from hmi.domain.sensors.condition import StationCondition
from hmi.domain.sensors.gate import Gate
from hmi.security.authorization import Authorize
from hmi.settings import Settings
from hmi.store.errors import StoreError
from hmi.store.fleet import FleetStore

if TYPE_CHECKING:
    from hmi.app.pictures import PictureDesk
    from hmi.app.sensor_work import SensorWork
    from hmi.ingest.field import MakeLink

LATER_S = 4.0  # before the cloud, and long after the first page
RETRY_S = 10.0
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SensorWiring:
    """What the room is plugged into; ``make_link`` instead of a real broker, in tests."""

    settings: Settings
    clock: Clock
    records: Records
    fleet: FleetStore
    authorize: Authorize
    on_event: LaneEvent
    weather: WeatherBoard
    pictures: PictureDesk
    make_link: MakeLink | None = None


class SensorRoom:
    """Everything about field sensors; before it is loaded it knows nothing and says so."""

    def __init__(self, wiring: SensorWiring) -> None:
        self._wiring = wiring
        self._work: SensorWork | None = None
        self._task: asyncio.Task[None] | None = None
        self._loading = asyncio.Lock()
        self.forecast: Callable[[], dict[str, Any] | None] = lambda: None
        self.on_loaded: list[Callable[[SensorWork], None]] = []

    def routes(self) -> APIRouter:
        """Return the REST routes."""
        return sensor_routes(self._services)

    def start(self) -> None:
        """Begin, a little later."""
        self._task = asyncio.create_task(self._begin(), name="sensors")

    async def stop(self) -> None:
        """End; what is to be kept is written."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        async with self._loading:
            if self._work is not None:
                await self._work.stop()

    def gate(self) -> Gate | None:
        """Return what the farm's stations say of its treatment limits, ``None`` while nobody can."""
        return None if self._work is None else self._work.gate()

    def findings(self) -> Mapping[str, tuple[str, Findings]] | None:
        """Return what an alarm should say, by source: name for people and findings; ``None`` while nobody can."""
        return None if self._work is None else self._work.findings()

    def condition_of(self, source: str) -> StationCondition | None:
        """Return how the station behind the source of an alarm does."""
        return None if self._work is None else self._work.condition_of(source)

    def place_of(self, station_id: str) -> tuple[float, float] | None:
        """Return latitude and longitude of an accepted station, ``None`` of any other id."""
        known = None if self._work is None else self._work.board.get(station_id)
        is_ours = known is not None and known.station.is_accepted
        return (known.station.lat_deg, known.station.lon_deg) if known is not None and is_ours else None

    def diagnostics(self) -> dict[str, Any]:
        """Return counters for the diagnostics page."""
        return {"state": "not loaded"} if self._work is None else self._work.diagnostics()

    async def map_published(self) -> None:
        """Take the parcels of a map that was published."""
        if self._work is not None:
            with contextlib.suppress(StoreError):  # the next published map, or start, brings them
                await self._work.treatment.load()

    async def _services(self) -> SensorServices:
        return (await self._loaded()).services()

    async def _loaded(self) -> SensorWork:
        async with self._loading:
            if self._work is None:
                await asyncio.to_thread(importlib.import_module, "hmi.app.sensor_work")
                from hmi.app.sensor_work import SensorWork  # loaded above, beside the event loop

                work = SensorWork(self._wiring, lambda: self.forecast())
                await work.start()
                self._work = work
                for listener in self.on_loaded:
                    listener(work)
            return self._work

    async def _begin(self) -> None:
        await asyncio.sleep(LATER_S)
        while True:
            try:
                await self._loaded()
                return
            except StoreError as error:
                log.warning("field sensors wait for the database: %s", error)
                await asyncio.sleep(RETRY_S)

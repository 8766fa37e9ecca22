"""The weather forecast in the console; nothing at all if none is set, and what asks for it is loaded late."""

from __future__ import annotations

import asyncio
import importlib
import logging
from typing import TYPE_CHECKING, Any
from zoneinfo import ZoneInfo

from backend_clients.service.errors import ServiceError
from hmi.app.queue import farm_zone
from hmi.app.records import Records
from hmi.app.service_report import away_finding, clock_finding, service_off, service_report
from hmi.clock import Clock
from hmi.domain.alarm.finding import NOTHING, Findings
from hmi.domain.forecast import Forecast
from hmi.presenters.forecast import age_text, forecast_row
from hmi.presenters.services import service_words
from hmi.service_link import ServiceLink
from hmi.settings import Settings
from hmi.store.errors import StoreError

if TYPE_CHECKING:
    from hmi.forecast.book import ForecastBook

KEY, NAME = "forecast", "Weather forecast"
LATER_S = 12.0  # after everything that somebody waits for
LOOK_EVERY_S = 60.0
LOOK_SOON_S = 10.0
log = logging.getLogger(__name__)


class ForecastRoom:
    """The forecast of one farm: the newest one, how the link is, and the rows that show both."""

    def __init__(self, settings: Settings, clock: Clock, records: Records) -> None:
        self._settings, self._clock, self._records = settings, clock, records
        self._zone: ZoneInfo = farm_zone(settings.time_zone)
        self._link = ServiceLink(clock, name="weather forecast")
        self._book: ForecastBook | None = None
        self._task: asyncio.Task[None] | None = None

    @property
    def is_on(self) -> bool:
        """Whether a forecast service is set."""
        return self._settings.forecast_url is not None

    def latest(self) -> Forecast | None:
        """Return the newest forecast that may be relied on."""
        return None if self._book is None else self._book.latest

    def row(self) -> dict[str, Any]:
        """Return the ``forecast`` field of ``GET /sensors``."""
        kept = None if self._book is None else self._book.kept
        words = service_words(KEY, self._link.state.value)
        trouble = "" if self._link.is_well else f"The service: {words.head[0].lower()}{words.head[1:]}"
        return forecast_row(kept, trouble, self._clock.utc(), self._zone, is_set=self.is_on)

    def start(self) -> None:
        """Begin to ask, if a service is set."""
        if self.is_on:
            self._task = asyncio.create_task(self._run(), name="forecast")

    async def stop(self) -> None:
        """End it; what is still to come is dropped."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)

    def findings(self) -> Findings:
        """Return what is wrong with the link for the alarms."""
        return (*away_finding("forecast-away", self._link), *clock_finding(NAME, self._link)) if self.is_on else NOTHING

    def report(self) -> dict[str, Any]:
        """Return the row for Admin, Cloud."""
        url = self._settings.forecast_url
        if url is None:
            return service_off(KEY, NAME)
        kept = None if self._book is None else self._book.kept
        age = "none yet" if kept is None else f"{age_text(kept.age(self._clock.utc()))} old"
        facts = [("Newest forecast", age)]
        if kept is not None:
            facts.append(("Reaches ahead", age_text(kept.ends_at - self._clock.utc())))
        return service_report(KEY, NAME, url, self._link, self._clock, facts)

    async def _run(self) -> None:
        await asyncio.sleep(LATER_S)
        await asyncio.to_thread(importlib.import_module, "hmi.app.forecast_work")
        from hmi.app.forecast_work import make_source
        from hmi.forecast.book import ForecastBook

        try:
            source = await asyncio.to_thread(make_source, self._settings)  # reads certificates
        except ServiceError as error:
            self._link.failed(error)
            return
        self._book = ForecastBook(source, self._link, self._clock, self._place)
        try:
            while True:
                try:
                    await self._book.look()
                except StoreError as error:  # the next look must come
                    log.warning("no forecast: %s", error)
                await asyncio.sleep(LOOK_EVERY_S if self._link.is_well else LOOK_SOON_S)
        finally:
            await source.close()

    async def _place(self) -> tuple[float, float] | None:
        """Return the middle of the farm, else of its first field."""
        records, farm = self._records, self._settings.farm_id
        found = await records.database.run(records.features.all, farm, ("farm", "parcel"))
        found = sorted(found, key=lambda one: one.kind != "farm")
        return middle_of(found[0].geometry) if found else None


def middle_of(geometry: dict[str, Any]) -> tuple[float, float]:
    """Return the middle of the box around the first ring of a polygon, longitude and latitude."""
    ring = geometry["coordinates"][0] if geometry["type"] == "Polygon" else geometry["coordinates"][0][0]
    lons, lats = [float(p[0]) for p in ring], [float(p[1]) for p in ring]
    return (min(lons) + max(lons)) / 2, (min(lats) + max(lats)) / 2

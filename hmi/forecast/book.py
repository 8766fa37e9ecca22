"""The newest forecast and how the link to its service is; asks again when it is time."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from backend_clients.service.errors import ServiceError, Unreadable
from hmi.clock import Clock
from hmi.domain.forecast import AHEAD, Forecast, ForecastAge
from hmi.forecast.port import ForecastSource
from hmi.service_link import ServiceLink

HOURS = 48
ASK_EVERY_S = 1800.0  # services make a new one each hour at most; asking costs a line where nothing changed
Place = Callable[[], Awaitable[tuple[float, float] | None]]


class ForecastBook:
    """One farm's forecast. Calls belong to one task.

    Args:
        place: longitude and latitude of the farm; ``None`` while nothing is on its map.
    """

    def __init__(self, source: ForecastSource, link: ServiceLink, clock: Clock, place: Place) -> None:
        self._source, self._link, self._clock, self._place = source, link, clock, place
        self._newest: Forecast | None = None
        self._next_s = float("-inf")

    @property
    def latest(self) -> Forecast | None:
        """The newest forecast that may still be relied on."""
        if self._newest is None or self._newest.reliance(self._clock.utc()) is ForecastAge.REFUSED:
            return None
        return self._newest

    @property
    def kept(self) -> Forecast | None:
        """The newest forecast, however old."""
        return self._newest

    async def look(self) -> None:
        """Ask if it is time; a service that failed is left alone for a while."""
        now_s = self._clock.mono_s()
        if now_s < self._next_s or not self._link.may_ask:
            return
        place = await self._place()
        if place is None:
            return
        begin_s = self._clock.mono_s()
        try:
            told = await self._source.ask(place, HOURS)
            if told.forecast is not None:
                self._take(told.forecast)
        except ServiceError as error:
            self._source.forget()
            self._link.failed(error)
            return
        self._next_s = self._clock.mono_s() + ASK_EVERY_S
        self._link.well(self._clock.mono_s() - begin_s, told.date)

    def _take(self, found: Forecast) -> None:
        now = self._clock.utc()
        if found.made_at > now + AHEAD:
            ahead_min = (found.made_at - now).total_seconds() / 60
            raise Unreadable(f"the forecast was made {ahead_min:.0f} min in the future; check both clocks")
        if found.reliance(now) is ForecastAge.REFUSED:
            raise Unreadable(f"the forecast is {found.age(now).total_seconds() / 3600:.0f} h old, or over")
        if self._newest is None or found.made_at >= self._newest.made_at or self.latest is None:
            self._newest = found

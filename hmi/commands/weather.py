"""What weather stations tell, kept until something newer comes. Missing is missing: no forecast is made up."""

from __future__ import annotations

from datetime import datetime, timedelta

from hmi.clock import Clock
from hmi.commands.refusal import OrderRefused
from hmi.domain.queue.facts import WEATHER_FRESH_S, Weather
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo

AHEAD = timedelta(minutes=1)  # a station's clock may be this far ahead


class WeatherBoard:
    """The newest report of the farm, in memory: after a restart the station has to speak again.

    ``is_measured_here``: the newest comes from field stations of the farm, not from a program that reported it.
    """

    def __init__(self, clock: Clock, authorize: Authorize, farm_id: str) -> None:
        self._clock, self._authorize, self._farm_id = clock, authorize, farm_id
        self._latest: Weather | None = None
        self.is_measured_here = False

    @property
    def latest(self) -> Weather | None:
        """The newest report, however old."""
        return self._latest

    def report(
        self,
        session: SessionInfo,
        *,
        station: str,
        rain_mm_h: float | None,
        wind_mps: float | None,
        at: datetime | None = None,
    ) -> Weather:
        """Take a station's report; rain in mm/h, wind in m/s, ``at`` when it was measured (now if left out).

        Raises:
            OrderRefused: measured in the future, or older than what is known.
        """
        self._authorize(session, Permission.SEND_MISSION)
        measured = Weather(at or self._clock.utc(), rain_mm_h, wind_mps, station)
        self._check(measured)
        self._latest, self.is_measured_here = measured, False
        return measured

    def take(self, measured: Weather) -> None:
        """Take what the farm's own field stations measured; who reports by REST goes before them while it is fresh."""
        latest, now = self._latest, self._clock.utc()
        is_reported = latest is not None and not self.is_measured_here
        if is_reported and latest is not None and 0 <= (now - latest.at).total_seconds() <= WEATHER_FRESH_S:
            return
        self._latest, self.is_measured_here = measured, True

    def take_back(self) -> None:
        """Forget what the farm's own field stations measured; what was reported by REST stays."""
        if self.is_measured_here:
            self._latest, self.is_measured_here = None, False

    def _check(self, measured: Weather) -> None:
        now = self._clock.utc()
        if measured.at > now + AHEAD:
            raise OrderRefused("from_the_future", "This was measured in the future. Set the station's clock.")
        latest = None if self.is_measured_here else self._latest
        if latest is not None and measured.at < latest.at and latest.at <= now + AHEAD:
            raise OrderRefused("older", "A newer report is known already.")

"""The open HTTP format as a source of forecasts."""

from __future__ import annotations

from backend_clients.forecast.client import ForecastClient
from backend_clients.forecast.messages import ForecastReport
from hmi.domain.forecast import Expected, Forecast, Hour
from hmi.forecast.port import Told


class HttpForecast:
    """A ``ForecastSource`` over ``backend_clients.forecast``."""

    def __init__(self, client: ForecastClient) -> None:
        self._client = client

    async def ask(self, place: tuple[float, float], hours: int) -> Told:
        """See ``ForecastSource``."""
        lon_deg, lat_deg = place
        report, date = await self._client.forecast(lat_deg, lon_deg, hours)
        return Told(None if report is None else forecast_of(report), date)

    def forget(self) -> None:
        """See ``ForecastSource``."""
        self._client.forget()

    async def close(self) -> None:
        """See ``ForecastSource``."""
        await self._client.close()


def forecast_of(report: ForecastReport) -> Forecast:
    """Return a report as the console keeps it."""
    hours = tuple(
        Hour(one.utc, **{quantity.value: getattr(one, quantity.value) for quantity in Expected}) for one in report.hours
    )
    source = "".join(c for c in report.source if c.isprintable())
    return Forecast(report.made_utc, hours, (report.lon_deg, report.lat_deg), source)

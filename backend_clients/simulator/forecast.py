"""A simulated forecast service: the simulated weather ahead of time, less sure the further ahead."""

from __future__ import annotations

import hashlib
import hmac
from datetime import UTC, datetime, timedelta

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from backend_clients.forecast.messages import MAX_HOURS, ForecastReport, HourForecast, Problem
from backend_clients.simulator.field.noise import smooth
from backend_clients.simulator.field.weather import Weather
from hmi.clock import Clock, SystemClock

SOURCE = "Simulated service"
HOUR = timedelta(hours=1)
ERROR_AT_ONCE, ERROR_PER_H = 0.2, 0.025  # of a forecast, in its unit: wind m/s, temperature degC
WIND_ERROR, AIR_ERROR = 300, 301  # streams of noise
CELL_S = 6 * 3600.0


class ForecastEndpoint:
    """Answers for any place; the same seed and hour is the same forecast.

    Args:
        seed: of the simulated weather; a station with the same one measures what is forecast, about.
        token: bearer token every request has to carry; empty lets everybody in.
    """

    def __init__(self, seed: int = 1, token: str = "", clock: Clock | None = None) -> None:
        self._seed, self._token, self._clock = seed, token, clock or SystemClock()

    def application(self) -> Starlette:
        """Return the ASGI application."""
        return Starlette(routes=[Route("/forecast", self._forecast)])

    async def _forecast(self, request: Request) -> Response:
        given = request.headers.get("authorization", "")
        if self._token and not hmac.compare_digest(given.encode(), f"Bearer {self._token}".encode()):
            return _problem(401, "not_allowed", "The token is missing or wrong.")
        try:
            lat_deg, lon_deg = (float(request.query_params[name]) for name in ("lat_deg", "lon_deg"))
            hours = int(request.query_params.get("hours", 48))
            if not (abs(lat_deg) <= 90 and abs(lon_deg) <= 180 and 1 <= hours <= MAX_HOURS):
                raise ValueError("out of range")
        except (KeyError, ValueError):
            return _problem(422, "bad_place", "Say lat_deg, lon_deg, and 1 to 240 hours.")
        made = self._clock.utc().astimezone(UTC).replace(minute=0, second=0, microsecond=0)
        tag = f'"{hashlib.sha256(f"{self._seed} {made} {lat_deg} {lon_deg} {hours}".encode()).hexdigest()[:16]}"'
        headers = {"ETag": tag, "Cache-Control": "private, max-age=600"}
        if request.headers.get("if-none-match") == tag:
            return Response(status_code=304, headers=headers)
        weather = Weather(self._seed, lat_deg, lon_deg)
        report = ForecastReport(
            made_utc=made,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            source=SOURCE,
            hours=[self._hour(weather, made, ahead) for ahead in range(hours)],
        )
        return Response(report.model_dump_json(), headers=headers, media_type="application/json")

    def _hour(self, weather: Weather, made: datetime, ahead: int) -> HourForecast:
        begin = made + ahead * HOUR
        middle_s = begin.timestamp() + 1800
        unsure = ERROR_AT_ONCE + ERROR_PER_H * ahead
        wind = max(0.1, weather.wind_mps(middle_s) + unsure * smooth(self._seed, WIND_ERROR, middle_s, CELL_S))
        air = weather.temperature_c(middle_s) + unsure * smooth(self._seed, AIR_ERROR, middle_s, CELL_S)
        gust = max(wind, weather.gust_mps(middle_s))
        return HourForecast(
            utc=begin,
            air_temperature=round(air, 1),
            rain_rate=round(weather.rain_mm(begin.timestamp(), begin.timestamp() + 3600), 2),
            wind_speed=round(wind, 1),
            wind_gust=round(gust, 1),
        )


def _problem(status: int, code: str, text: str) -> Response:
    body = Problem(code=code, text=text).model_dump_json()
    return Response(body, status, media_type="application/json")

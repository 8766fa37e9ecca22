"""A simulated weather station: signs in and reports over REST, as a real one beside a farm would."""

from __future__ import annotations

import time
from collections.abc import Callable

import httpx

from hmi.demo.farm import WEATHER_MAST

STATION = "Simulated station"
PERIOD_S = 60.0
RETRY_S = 10.0


class WeatherStation:
    """Wind and rain of the demo farm, the same for the same seed and as its field sensors measure them.

    Args:
        seed: makes it repeatable.
    """

    def __init__(self, seed: int = 1) -> None:
        from backend_clients.simulator.field.weather import Weather  # a console starts without a simulator

        self._weather = Weather(seed, *WEATHER_MAST)

    def wind_mps(self, at_s: float) -> float:
        """Return the wind at a time in seconds since the epoch, 0.2 to 9 m/s."""
        return round(self._weather.wind_mps(at_s), 1)

    def rain_mm_h(self, at_s: float) -> float:
        """Return the rain; most of the time there is none."""
        return round(self._weather.rain_mm_h(at_s), 1)

    def report(self, at_s: float) -> dict[str, object]:
        """Return the body of one report."""
        return {"station": STATION, "rain_mm_h": self.rain_mm_h(at_s), "wind_mps": self.wind_mps(at_s)}


def sign_in(client: httpx.Client, name: str, password: str) -> None:
    """Sign a client in; raises ``httpx.HTTPError`` when the console refuses or is not there."""
    answer = client.post("/api/v1/session", json={"name": name, "password": password})
    answer.raise_for_status()
    client.headers["X-Headland-CSRF"] = answer.json()["csrf"]


def run_station(
    client: httpx.Client,
    name: str,
    password: str,
    station: WeatherStation,
    *,
    say: Callable[[str], None],
    wait: Callable[[float], None] = time.sleep,
    rounds: int | None = None,
) -> None:
    """Report each minute until interrupted; a console that is away is asked again.

    Args:
        rounds: how many reports, without end if ``None``.
    """
    is_in, made = False, 0
    while rounds is None or made < rounds:
        try:
            if not is_in:
                sign_in(client, name, password)
                is_in = True
            body = station.report(time.time())
            client.post("/api/v1/weather", json=body).raise_for_status()
            say(f"wind {body['wind_mps']} m/s, rain {body['rain_mm_h']} mm/h")
            made += 1
            wait(PERIOD_S)
        except httpx.HTTPError as error:
            is_in = False
            say(f"Not reported: {error}. Trying again.")
            wait(RETRY_S)

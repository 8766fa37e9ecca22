"""The simulated weather station."""

from __future__ import annotations

import json

import httpx
from hypothesis import given
from hypothesis import strategies as st

from hmi.demo.weather import WeatherStation, run_station


@given(st.integers(0, 1000), st.floats(1.7e9, 1.9e9))
def test_the_weather_is_plausible_and_repeatable(seed: int, at_s: float) -> None:
    station = WeatherStation(seed)
    assert 0.2 <= station.wind_mps(at_s) <= 9.0
    assert 0.0 <= station.rain_mm_h(at_s) <= 20.0
    assert station.report(at_s) == WeatherStation(seed).report(at_s)


def test_the_station_signs_in_again_after_the_console_was_away() -> None:
    asked: list[str] = []

    def console(request: httpx.Request) -> httpx.Response:
        asked.append(request.url.path)
        if len(asked) == 2:
            return httpx.Response(503)
        if request.url.path == "/api/v1/session":
            return httpx.Response(200, json={"csrf": "token"})
        assert request.headers["X-Headland-CSRF"] == "token"
        assert set(json.loads(request.content)) == {"station", "rain_mm_h", "wind_mps"}
        return httpx.Response(200, json={})

    said: list[str] = []
    with httpx.Client(base_url="http://console.local", transport=httpx.MockTransport(console)) as client:
        run_station(client, "operator", "operator", WeatherStation(), say=said.append, wait=lambda _s: None, rounds=2)
    session, weather = "/api/v1/session", "/api/v1/weather"
    assert asked == [session, weather, session, weather, weather]
    assert said[0].startswith("Not reported")

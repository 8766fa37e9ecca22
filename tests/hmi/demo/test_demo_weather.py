"""The demo's own weather."""

from __future__ import annotations

from datetime import timedelta

from hmi.app.demo import DemoWeather
from hmi.clock import FakeClock
from hmi.commands.weather import WeatherBoard
from hmi.demo.weather import STATION
from hmi.domain.queue.facts import WEATHER_FRESH_S, Weather


def a_board(clock: FakeClock) -> WeatherBoard:
    return WeatherBoard(clock, lambda _session, _permission: None, "polder")


def test_a_demo_has_weather_from_the_first_moment_and_says_that_it_is_simulated() -> None:
    clock = FakeClock()
    board = a_board(clock)
    DemoWeather(board, clock).measure()
    assert board.latest is not None
    assert board.latest.station == STATION
    assert "Simulated" in STATION
    assert board.latest.at == clock.utc()


def test_a_real_station_is_not_talked_over_as_long_as_it_speaks() -> None:
    clock = FakeClock()
    board = a_board(clock)
    weather = DemoWeather(board, clock)
    weather.measure()
    board.take(Weather(clock.utc(), 2.0, 7.5, "Yard"))
    weather.measure()
    assert board.latest is not None
    assert board.latest.station == "Yard"
    clock.advance(WEATHER_FRESH_S + 1)
    weather.measure()
    assert board.latest.station == STATION
    assert clock.utc() - board.latest.at == timedelta(0)

"""A forecast says when weather is expected to clear; too old, or from the future, it says nothing."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.forecast import Clearing, Expected, Forecast, ForecastAge, Hour, clearing

NOW = datetime(2026, 6, 15, 12, 20, tzinfo=UTC)
WIND = Expected.WIND_SPEED


def forecast(*winds: float | None, age: timedelta = timedelta(minutes=20)) -> Forecast:
    """Return a forecast of winds from 12:00 on."""
    begin = NOW.replace(minute=0)
    hours = tuple(Hour(begin + timedelta(hours=k), wind_speed=wind) for k, wind in enumerate(winds))
    return Forecast(NOW - age, hours, (4.26, 51.78), "Test")


def at(hour: int) -> datetime:
    return NOW.replace(hour=hour, minute=0)


def test_it_clears_where_it_falls_below_the_limit_and_stays_there() -> None:
    assert clearing(forecast(6, 6, 4.9, 5.5, 4, 4, 4), WIND, 5.0, NOW) == Clearing(at(16), at(19))
    assert clearing(forecast(6, 6, 6), WIND, 5.0, NOW) == Clearing(None, at(15))
    assert clearing(forecast(6, 4), WIND, 5.0, NOW) == Clearing(at(13), at(14))


def test_nothing_is_said_that_the_measurement_belies_or_nobody_forecast() -> None:
    assert clearing(forecast(4, 4, 4), WIND, 5.0, NOW) is None
    assert clearing(forecast(6, 4), Expected.RAIN_RATE, 5.0, NOW) is None
    assert clearing(forecast(None, 4, 4), WIND, 5.0, NOW) is None
    assert clearing(None, WIND, 5.0, NOW) is None
    assert clearing(forecast(6, None, 4, 4), WIND, 5.0, NOW) == Clearing(None, at(13))


@pytest.mark.parametrize(
    ("age", "state"),
    [
        (timedelta(hours=2, minutes=59), ForecastAge.FRESH),
        (timedelta(hours=3), ForecastAge.OLD),
        (timedelta(hours=23, minutes=59), ForecastAge.OLD),
        (timedelta(hours=24), ForecastAge.REFUSED),
        (-timedelta(minutes=4), ForecastAge.FRESH),
        (-timedelta(minutes=6), ForecastAge.REFUSED),
    ],
)
def test_it_is_old_after_three_hours_and_none_after_a_day_or_from_the_future(
    age: timedelta, state: ForecastAge
) -> None:
    made = forecast(6, 6, 4, 4, age=age)
    assert made.reliance(NOW) is state
    found = clearing(made, WIND, 5.0, NOW)
    assert (found is None) == (state is ForecastAge.REFUSED)
    if found is not None:
        assert found.age == (age if state is ForecastAge.OLD else None)


def test_one_whose_hours_are_over_is_none() -> None:
    assert forecast(6, 4).reliance(NOW + timedelta(hours=2)) is ForecastAge.REFUSED


@given(st.lists(st.floats(0, 20) | st.none(), min_size=1, max_size=60), st.floats(0.1, 15), st.floats(0, 30))
def test_what_is_said_to_clear_is_forecast_to_be_below_the_limit(
    winds: list[float | None], limit: float, ahead_h: float
) -> None:
    made, now = forecast(*winds), NOW + timedelta(hours=ahead_h)
    found = clearing(made, WIND, limit, now)
    if found is None or found.at is None:
        return
    by_hour = {one.utc: one.wind_speed for one in made.hours}
    value = by_hour[found.at]
    assert value is not None
    assert value < limit
    assert now < found.at < found.until


def test_it_is_for_places_near_it_only() -> None:
    made = forecast(6.0)
    assert made.is_near((4.3, 51.8))
    assert not made.is_near((4.26, 53.0))
    assert not made.is_near((-3.9, 40.4))

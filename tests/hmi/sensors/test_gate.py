"""May treatment go on? What is not known never counts as good, and the queue says what it waits for."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.clock import FakeClock
from hmi.commands.refusal import OrderRefused
from hmi.commands.weather import WeatherBoard
from hmi.domain.queue.facts import WEATHER_FRESH_S, Weather
from hmi.domain.queue.waiting import Step, why_waiting
from hmi.domain.role import Role
from hmi.domain.sensors.gate import Gate, GateState, Measured, gate
from hmi.domain.sensors.limit import SensorLimit
from hmi.domain.sensors.place import Parcel
from hmi.domain.sensors.quantity import Channel
from tests.hmi.commands.field import person
from tests.hmi.queue.test_waiting import ENTRY, GOOD
from tests.hmi.sensors.rig import SensorRig

WIND, RAIN = Channel("wind_speed"), Channel("rain_rate")
LIMITS = [SensorLimit(WIND, high=5.0, is_treatment=True), SensorLimit(RAIN, high=0.5, is_treatment=True)]


def judged(*measured: tuple[Channel, float, bool]) -> Gate:
    """Judge by wind and rain."""
    return gate(LIMITS, [Measured(*one) for one in measured])


def test_it_is_open_only_when_each_limit_is_known_to_be_kept() -> None:
    assert judged((WIND, 4.0, True), (RAIN, 0.0, True)).state is GateState.OPEN
    assert judged((WIND, 4.0, True)).state is GateState.UNKNOWN
    assert judged((WIND, 4.0, True), (RAIN, 0.0, False)).state is GateState.UNKNOWN
    found = judged((WIND, 6.1, True))
    assert (found.state, found.sentence) == (GateState.WAITS, "Wind 6.1 m/s, limit 5.0: waits")


def test_of_several_stations_the_worst_counts() -> None:
    assert judged((WIND, 4.0, True), (WIND, 5.6, True), (RAIN, 0.0, True)).reason == "Wind 5.6 m/s, limit 5.0"


@given(
    wind=st.lists(st.tuples(st.floats(0, 20), st.booleans()), max_size=4),
    rain=st.lists(st.tuples(st.floats(0, 3), st.booleans()), max_size=4),
)
def test_what_is_not_known_never_opens_it(wind: list[tuple[float, bool]], rain: list[tuple[float, bool]]) -> None:
    found = judged(*((WIND, *one) for one in wind), *((RAIN, *one) for one in rain))
    is_known = any(usable for _, usable in wind) and any(usable for _, usable in rain)
    is_good = all(value <= 5.0 for value, usable in wind if usable) and all(
        value <= 0.5 for value, usable in rain if usable
    )
    assert (found.state is GateState.OPEN) == (is_known and is_good)
    assert found.sentence


def test_a_limit_below_counts_too() -> None:
    cold = SensorLimit(Channel("air_temperature"), low=8.0, is_treatment=True)
    found = gate([cold], [Measured(Channel("air_temperature"), 6.5, True)])
    assert found.sentence == "Air 6.5 °C, limit 8.0: waits"


def test_a_depth_with_a_treatment_limit_of_its_own_is_judged_by_that_alone() -> None:
    every, at_60 = Channel("soil_moisture"), Channel("soil_moisture", 60)
    limits = [SensorLimit(every, high=0.35, is_treatment=True), SensorLimit(at_60, high=0.45, is_treatment=True)]
    shallow, deep = Measured(Channel("soil_moisture", 10), 0.2, True), Measured(at_60, 0.4, True)
    assert gate(limits, [shallow, deep]).state is GateState.OPEN
    assert gate(limits, [deep]).state is GateState.OPEN
    assert gate(limits, [replace(shallow, value=0.4), deep]).state is GateState.WAITS
    assert gate(limits, [shallow, replace(deep, value=0.5)]).state is GateState.WAITS
    assert gate(limits, [shallow]).state is GateState.UNKNOWN
    assert gate(limits, [replace(shallow, is_usable=False), deep]).state is GateState.UNKNOWN
    only_warns = [limits[0], replace(limits[1], is_treatment=False)]
    assert gate(only_warns, [shallow, deep]).state is GateState.WAITS, "a limit that only warns opens nothing"


# ---- the queue ----

ASKS = replace(ENTRY, conditions=replace(ENTRY.conditions, needs_treatment_weather=True))


@pytest.mark.parametrize(
    ("found", "code", "text"),
    [
        (None, "treatment_unknown",
         "What the field sensors say is not known yet, so the treatment limits cannot be checked."),
        (gate([], []), "treatment_unknown",
         "No treatment limits are set, so the weather cannot be checked. Set them under Sensors."),
        (judged((WIND, 6.1, True), (RAIN, 0.0, True)), "treatment", "Waits: wind 6.1 m/s, limit 5.0."),
        (judged((RAIN, 0.0, True), (WIND, 1.0, False)), "treatment_unknown",
         "Wind: nothing fresh is known. The treatment limits cannot be checked."),
    ],
)  # fmt: skip
def test_an_entry_that_asks_for_the_limits_waits_with_one_sentence(found: Gate | None, code: str, text: str) -> None:
    verdict = why_waiting(ASKS, replace(GOOD, treatment=found))
    assert (verdict.step, verdict.waiting.code, verdict.waiting.text) == (Step.WAIT, code, text)


def test_an_entry_starts_within_the_limits_and_one_that_does_not_ask_whatever_they_say() -> None:
    good, bad = judged((WIND, 1.0, True), (RAIN, 0.0, True)), judged((WIND, 9.0, True))
    assert why_waiting(ASKS, replace(GOOD, treatment=good)).step is Step.START
    assert why_waiting(ENTRY, replace(GOOD, treatment=bad)).step is Step.START


# ---- weather of the stations for the queue ----


async def test_the_queue_goes_by_the_worst_of_fresh_stations(rig: SensorRig) -> None:
    for station in ("weather-01", "weather-02"):
        await rig.accepted(station, "weather")
    rig.measures("weather-01", wind_speed=3.0, rain_rate=0.4)
    await rig.passes(60)
    rig.measures("weather-02", wind_speed=4.5, rain_rate=0.0)
    latest = rig.weather.latest
    assert latest is not None
    assert (latest.wind_mps, latest.rain_mm_h, latest.station) == (4.5, 0.4, "Weather 1, Weather 2")
    assert (rig.clock.utc() - latest.at).total_seconds() == 60
    rig.clock.advance(WEATHER_FRESH_S)
    rig.measures("weather-02", wind_speed=1.0, rain_rate=0.0)
    assert (rig.weather.latest.wind_mps, rig.weather.latest.station) == (1.0, "Weather 2")  # type: ignore[union-attr]


async def test_a_station_that_nobody_took_in_does_not_make_the_farms_weather(rig: SensorRig) -> None:
    rig.says(rig.about("weather-01", "weather"), is_retained=True)
    rig.measures("weather-01", wind_speed=3.0)
    assert rig.weather.latest is None


def test_who_reports_goes_before_the_stations_while_that_is_fresh() -> None:
    clock = FakeClock()
    board = WeatherBoard(clock, lambda *_: None, "farm")
    session = person("Pieter Bos", Role.OPERATOR)
    board.take(Weather(clock.utc(), 0.0, 9.0, "Weather 1"))
    clock.advance(10)
    board.report(session, station="Yard", rain_mm_h=0.0, wind_mps=2.0)
    board.take(Weather(clock.utc(), 0.0, 9.0, "Weather 1"))
    assert (board.latest.station, board.is_measured_here) == ("Yard", False)  # type: ignore[union-attr]
    with pytest.raises(OrderRefused, match="newer report"):
        board.report(session, station="Yard", rain_mm_h=0.0, wind_mps=1.0, at=FakeClock().utc())
    clock.advance(WEATHER_FRESH_S + 1)
    board.take(Weather(clock.utc(), 0.0, 9.0, "Weather 1"))
    assert (board.latest.station, board.is_measured_here) == ("Weather 1", True)  # type: ignore[union-attr]


# ---- parcels ----

SQUARE = [[5.0, 52.0], [5.01, 52.0], [5.01, 52.01], [5.0, 52.01], [5.0, 52.0]]
HOLE = [[5.004, 52.004], [5.006, 52.004], [5.006, 52.006], [5.004, 52.006], [5.004, 52.004]]


@pytest.mark.parametrize(
    ("lat_deg", "lon_deg", "is_in"), [(52.002, 5.002, True), (52.005, 5.005, False), (52.02, 5.002, False)]
)
def test_a_hole_is_not_the_parcel(lat_deg: float, lon_deg: float, *, is_in: bool) -> None:
    one = Parcel.of("p", "P", {"type": "Polygon", "coordinates": [SQUARE, HOLE]})
    many = Parcel.of("p", "P", {"type": "MultiPolygon", "coordinates": [[SQUARE, HOLE]]})
    assert one.holds(lat_deg, lon_deg) == many.holds(lat_deg, lon_deg) == is_in
    assert not Parcel.of("p", "P", {"type": "Point", "coordinates": [5.0, 52.0]}).holds(lat_deg, lon_deg)

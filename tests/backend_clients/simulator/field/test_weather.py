"""Weather, soil and respiration are plausible at any moment, and the same for the same seed."""

from __future__ import annotations

import math
from statistics import correlation, mean

import pytest
from hypothesis import given
from hypothesis import strategies as st

from backend_clients.simulator.field.instrument import INSTRUMENTS
from backend_clients.simulator.field.respiration import co2_umol_mol, h2o_mmol_mol
from backend_clients.simulator.field.soil import DEPTHS_M, FILL_MM, Column, Ground, Texture
from backend_clients.simulator.field.station import KEYS, TEXTURES, Probe, StationConfig, battery
from backend_clients.simulator.field.sun import DAY_S, sin_height
from backend_clients.simulator.field.weather import HOUR_S, Shower, Weather

LAT_DEG, LON_DEG = 51.786, 4.261
JUNE_S = 1_782_000_000.0 // DAY_S * DAY_S  # 21 June 2026
seeds = st.integers(0, 10_000)
moments = st.floats(1.5e9, 2.2e9)


def hours(from_s: float, days: int) -> list[float]:
    return [from_s + n * HOUR_S for n in range(days * 24)]


@given(seeds, moments, st.floats(-60, 60))
def test_weather_is_within_what_a_temperate_place_has(seed: int, at_s: float, lat_deg: float) -> None:
    weather = Weather(seed, lat_deg, LON_DEG)
    assert -25 < weather.temperature_c(at_s) < 42
    assert 0.2 <= weather.humidity(at_s) <= 1
    assert 0 <= weather.rain_mm_h(at_s) < 20
    assert 0.2 <= weather.wind_mps(at_s) < 12
    assert weather.gust_mps(at_s) > weather.wind_mps(at_s)
    assert 0 <= weather.bearing_deg(at_s) < 360
    assert 0 <= weather.radiation_w_m2(at_s) < 1100
    assert 0 <= weather.evaporation_mm_h(at_s) < 1.2
    assert 0 <= weather.cloud(at_s) <= 1


@given(seeds, moments)
def test_the_same_seed_is_the_same_weather_and_another_seed_is_not(seed: int, at_s: float) -> None:
    one, again, other = (Weather(number, LAT_DEG, LON_DEG) for number in (seed, seed, seed + 1))
    assert one.temperature_c(at_s) == again.temperature_c(at_s)
    assert one.wind_mps(at_s) == again.wind_mps(at_s)
    assert one.mean_c(at_s) != other.mean_c(at_s)


@given(seeds, moments)
def test_weather_has_no_steps(seed: int, at_s: float) -> None:
    weather = Weather(seed, LAT_DEG, LON_DEG)
    for value, most in (
        (weather.temperature_c, 0.2), (weather.wind_mps, 0.2), (weather.rain_mm_h, 1.5),
        (weather.humidity, 0.2), (lambda at: weather.soil_c(at, 0.1), 0.02),
    ):  # fmt: skip
        assert abs(value(at_s + 30) - value(at_s)) < most


@pytest.mark.parametrize("seed", range(4))
def test_temperature_lags_radiation_and_humidity_goes_against_it(seed: int) -> None:
    weather, times = Weather(seed, LAT_DEG, LON_DEG), hours(JUNE_S, 20)
    warm = [weather.temperature_c(at) for at in times]
    humid = [weather.humidity(at) for at in times]
    assert correlation(warm, humid) < -0.5
    lags = {lag: correlation(warm, [weather.radiation_w_m2(at - lag * HOUR_S) for at in times]) for lag in range(-3, 7)}
    assert max(lags, key=lags.__getitem__) in (2, 3, 4)
    assert mean(weather.wind_mps(at) for at in times if at % DAY_S == 13 * HOUR_S) > mean(
        weather.wind_mps(at) for at in times if at % DAY_S == 1 * HOUR_S
    )


@given(seeds, moments)
def test_there_is_no_radiation_without_the_sun(seed: int, at_s: float) -> None:
    is_night = sin_height(at_s, LAT_DEG, LON_DEG) < 0
    assert not is_night or Weather(seed, LAT_DEG, LON_DEG).radiation_w_m2(at_s) == 0


@given(st.floats(0, 1e5), st.floats(1, 1e4), st.floats(0.1, 10), st.floats(-1e4, 1e5), st.floats(0, 2e4))
def test_the_sum_of_a_shower_is_that_of_its_rate(
    start_s: float, length_s: float, peak: float, from_s: float, span_s: float
) -> None:
    shower = Shower(start_s, length_s, peak)
    whole = shower.sum_mm(start_s - 1, start_s + length_s + 1)
    assert whole == pytest.approx(peak * length_s / HOUR_S / 2)
    part = shower.sum_mm(from_s, from_s + span_s)
    assert -1e-9 <= part <= whole + 1e-9
    assert part == pytest.approx(
        shower.sum_mm(from_s, from_s + span_s / 3) + shower.sum_mm(from_s + span_s / 3, from_s + span_s), abs=1e-6
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_year_has_the_rain_of_the_place(seed: int) -> None:
    assert 500 < Weather(seed, LAT_DEG, LON_DEG).rain_mm(JUNE_S, JUNE_S + 365 * DAY_S) < 1100


waters = st.tuples(*[st.floats(0.1, 0.42)] * 3)


@given(waters, st.floats(0, 60), st.floats(0, 2), st.sampled_from(TEXTURES))
def test_soil_keeps_its_water_within_its_pores_and_makes_none(
    water: tuple[float, float, float], rain_mm: float, dry_mm: float, texture: Texture
) -> None:
    before = Column(texture, tuple(min(max(one, texture.residual), texture.full) for one in water))  # type: ignore[arg-type]
    after = before.after(rain_mm, dry_mm)
    assert all(texture.residual <= one <= texture.full for one in after.water)
    held = [sum(w * mm for w, mm in zip(one.water, FILL_MM, strict=True)) for one in (before, after)]
    assert held[1] <= held[0] + rain_mm + 1e-6


def test_rain_raises_soil_moisture_from_the_top_downwards() -> None:
    column = Column(Texture(), (0.26, 0.29, 0.30))
    dry = [column]
    wet = [column]
    for hour in range(240):
        dry.append(dry[-1].after(0.0, 0.05))
        wet.append(wet[-1].after(6.0 if hour < 6 else 0.0, 0.05))
    more = [[w - d for w, d in zip(a.water, b.water, strict=True)] for a, b in zip(wet, dry, strict=True)]
    assert more[6][0] > 0.1
    peaks = [max(range(len(more)), key=lambda n, z=layer: more[n][z]) for layer in range(3)]  # type: ignore[misc]
    assert peaks[0] < peaks[1] < peaks[2]
    heights = [max(one[layer] for one in more) for layer in range(3)]
    assert heights[0] > heights[1] > heights[2] > 0


def test_soil_dries_in_summer_from_the_top_downwards() -> None:
    column = Column(Texture(), (0.31, 0.31, 0.31))
    for _ in range(14 * 24):
        column = column.after(0.0, 4 / 24)
    top, middle, low = column.water
    assert 0.31 - top > 0.31 - middle > 0.31 - low > 0


@given(seeds)
def test_deeper_soil_is_steadier_and_later(seed: int) -> None:
    weather, times = Weather(seed, LAT_DEG, LON_DEG), hours(JUNE_S, 2)
    series = [[weather.soil_c(at, depth) for at in times] for depth in (0.05, *DEPTHS_M)]
    swings = [max(one) - min(one) for one in series]
    assert swings == sorted(swings, reverse=True)


@given(st.floats(-5, 35), st.floats(0.08, 0.44))
def test_respiration_is_plausible_and_rises_with_warmth(soil_c: float, water: float) -> None:
    texture = Texture()
    low, high = co2_umol_mol(soil_c, water, texture), co2_umol_mol(soil_c + 5, water, texture)
    assert 415 < low < high < 9000
    assert 0 < h2o_mmol_mol(soil_c, water, texture) < h2o_mmol_mol(soil_c + 5, water, texture) < 80


@pytest.mark.slow
@given(seeds, st.sampled_from(["weather", "soil", "respiration"]), st.floats(0, 30 * DAY_S))
def test_every_instrument_shows_a_number_in_its_range(seed: int, kind: str, later_s: float) -> None:
    config = StationConfig("s", "S", kind, LAT_DEG, LON_DEG, number=seed % 3 + 1)  # type: ignore[arg-type]
    weather = Weather(1, LAT_DEG, LON_DEG)
    found = Probe(config, weather, GROUND).read(JUNE_S + later_s)
    assert [one[:2] for one in found] == list(KEYS[config.kind])
    for one in found:
        assert math.isfinite(one.value)
        assert INSTRUMENTS[one.quantity].low <= one.value <= INSTRUMENTS[one.quantity].high
    assert 0 <= battery(config, weather, JUNE_S + later_s) <= 1


GROUND = Ground(Weather(1, LAT_DEG, LON_DEG), JUNE_S)


def test_soil_before_its_beginning_is_not_known() -> None:
    with pytest.raises(ValueError, match="reckoned from"):
        GROUND.water(Texture(), JUNE_S - 400 * DAY_S)

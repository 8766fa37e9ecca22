"""The season before the demo began: complete, plausible, and what the simulator goes on from."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from itertools import pairwise

import pytest

from backend_clients.simulator.field.instrument import INSTRUMENTS
from backend_clients.simulator.field.season import Season, season_of
from backend_clients.simulator.field.soil import Ground
from backend_clients.simulator.field.station import KEYS, Probe, StationConfig
from backend_clients.simulator.field.weather import Weather

NOW = datetime(2026, 7, 22, 14, 3, 20, tzinfo=UTC)
STATIONS = tuple(
    StationConfig(f"{kind}-01", kind, kind, 51.786, 4.261) for kind in ("weather", "soil", "respiration", "camera")
)


@pytest.fixture(scope="module")
def season() -> Season:
    return season_of(STATIONS, 1, NOW, 10)


def test_every_quantity_has_every_day_and_every_ten_minutes(season: Season) -> None:
    keys = {(one.id, *key) for one in STATIONS for key in KEYS[one.kind]}
    days = {NOW.date() - timedelta(days=n) for n in range(10)}
    assert {(one.station, one.quantity, one.depth_m) for one in season.days} == keys
    assert {one.day for one in season.days} == days
    assert len(season.days) == len(keys) * 10
    assert len(season.recent) == len(keys) * 48 * 6
    moments = sorted({one.utc for one in season.recent})
    assert moments[-1] == NOW.replace(minute=0, second=0)
    assert {b - a for a, b in pairwise(moments)} == {timedelta(minutes=10)}


def test_values_are_in_the_range_of_their_instruments(season: Season) -> None:
    for one in season.days:
        assert INSTRUMENTS[one.quantity].low <= one.low <= one.high <= INSTRUMENTS[one.quantity].high
        assert one.quantity == "wind_bearing" or one.low <= one.mean <= one.high
    assert all(INSTRUMENTS[r.quantity].low <= r.value <= INSTRUMENTS[r.quantity].high for r in season.recent)


def test_it_is_a_function_of_seed_and_time() -> None:
    first = season_of(STATIONS[:1], 1, NOW, 3)
    assert season_of(STATIONS[:1], 1, NOW, 3) == first
    assert season_of(STATIONS[:1], 2, NOW, 3) != first


def test_the_simulator_goes_on_where_the_season_ends(season: Season) -> None:
    weather = Weather(1, STATIONS[0].lat_deg, STATIONS[0].lon_deg)
    ground = Ground(weather, (NOW + timedelta(minutes=3)).timestamp())
    for station in STATIONS[:3]:
        probe = Probe(station, weather, ground)
        last = [r for r in season.recent if r.station == station.id][-len(KEYS[station.kind]) :]
        assert [one.value for one in probe.read(last[0].utc.timestamp())] == [one.value for one in last]


@pytest.mark.parametrize("days", [0, 151])
def test_a_season_of_no_or_too_many_days_is_refused(days: int) -> None:
    with pytest.raises(ValueError, match="1 to 150"):
        season_of(STATIONS, 1, NOW, days)

"""What stations measured: kept whole, then coarser, never twice, each farm its own."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.clock import FakeClock
from hmi.domain.sensors.quantity import QUANTITIES, Channel
from hmi.domain.sensors.series import Point, Span, folded, stepped, with_gaps
from hmi.store.database import Database
from hmi.store.farms import Farms
from hmi.store.sensor_history import DAY_S, TEN_MINUTES_S, SensorHistory
from tests.hmi.store.conftest import database as database
from tests.hmi.store.conftest import migrated as migrated
from tests.hmi.store.conftest import server as server

NOW = datetime(2026, 6, 15, 12, 34, tzinfo=UTC)
WIND, FROM = Channel("wind_speed"), Channel("wind_bearing")
FOREVER = NOW - timedelta(days=5000)


@pytest.fixture
def history(database: Database) -> SensorHistory:
    """Return the history of a farm."""
    return SensorHistory(database, "farm", linger_s=0.0)


def minutes(count: int, end: datetime, value: float = 3.0) -> list[Point]:
    """Return a value each minute until then."""
    return [Point(end - timedelta(minutes=k), value + k % 3, value + k % 3, value + k % 3) for k in range(count)]


def steps(history: SensorHistory, channel: Channel = WIND) -> list[int]:
    """Return how far apart what is kept lies, in seconds, oldest first."""
    at = [one.at for one in history.points("w", channel, FOREVER)]
    return [round((b - a).total_seconds()) for a, b in pairwise(at)]


def test_what_is_young_stays_as_it_was_measured(history: SensorHistory) -> None:
    history.put("w", WIND, 0, minutes(120, NOW))
    assert history.thin(NOW) == 0
    assert steps(history) == [60] * 119


def test_after_two_days_ten_minutes_are_left_and_after_two_weeks_a_day(history: SensorHistory) -> None:
    history.put("w", WIND, 0, minutes(60, NOW - timedelta(days=3)))
    history.put("w", WIND, 0, minutes(60, NOW - timedelta(days=20)))
    history.thin(NOW)
    kept = history.points("w", WIND, FOREVER)
    assert kept[0] == Point(datetime(2026, 5, 26, tzinfo=UTC), pytest.approx(4.0), 3.0, 5.0, 60)
    assert set(steps(history)[1:]) == {TEN_MINUTES_S}
    assert sum(one.count for one in kept) == 120


def test_what_comes_late_is_folded_into_what_is_coarse_already(history: SensorHistory) -> None:
    old = NOW - timedelta(days=20)
    history.put("w", WIND, DAY_S, [Point(old.replace(hour=0, minute=0), 2.0, 1.0, 3.0, 10)])
    history.put("w", WIND, 0, [Point(old, 13.0, 13.0, 13.0)])
    history.thin(NOW)
    [day] = history.points("w", WIND, FOREVER)
    assert (day.mean, day.low, day.high, day.count) == (3.0, 1.0, 13.0, 11)


def test_after_three_years_it_goes(history: SensorHistory) -> None:
    history.put("w", WIND, DAY_S, [Point(NOW - timedelta(days=1200), 2.0, 1.0, 3.0, 10)])
    history.thin(NOW)
    assert history.points("w", WIND, FOREVER) == []


def test_the_same_value_again_is_kept_once_and_another_farms_is_not_seen(
    history: SensorHistory, database: Database
) -> None:
    Farms(database, FakeClock()).ensure("other", "Other")
    other = SensorHistory(database, "other")
    for one in (history, history, other):
        one.put("w", WIND, 0, [Point(NOW, 2.0, 2.0, 2.0)])
    assert len(history.points("w", WIND, FOREVER)) == 1
    assert [row[0] for row in other.newest()] == ["w"]
    history.put("w", WIND, 0, minutes(60, NOW - timedelta(days=3)))
    other.thin(NOW)
    assert 60 in steps(history)


def test_a_writer_takes_values_without_waiting_and_close_loses_none(history: SensorHistory) -> None:
    history.start()
    for k in range(500):
        history.see("w", WIND, NOW - timedelta(seconds=k), float(k))
    assert history.close(10.0)
    assert len(history.points("w", WIND, FOREVER)) == 500
    assert history.health().dropped == 0


def test_the_newest_of_each_channel_is_found_again(history: SensorHistory) -> None:
    history.put("w", WIND, 0, minutes(5, NOW))
    history.put("w", FROM, TEN_MINUTES_S, [Point(NOW - timedelta(hours=1), 270.0, 260.0, 280.0)])
    assert sorted((row[1].quantity, row[2], row[3]) for row in history.newest()) == [
        ("wind_bearing", NOW - timedelta(hours=1), 270.0), ("wind_speed", NOW, 3.0)
    ]  # fmt: skip


# ---- folding ----

values = st.lists(st.floats(-50, 50), min_size=1, max_size=30)


@given(found=values, cut=st.integers(0, 30))
def test_folding_in_two_goes_is_folding_at_once(found: list[float], cut: int) -> None:
    points = [Point(NOW, one, one, one) for one in found]
    whole = folded("wind_speed", points, NOW)
    parts = [folded("wind_speed", part, NOW) for part in (points[:cut], points[cut:]) if part]
    again = folded("wind_speed", parts, NOW)
    assert (again.low, again.high, again.count) == (whole.low, whole.high, whole.count)
    assert again.mean == pytest.approx(whole.mean, abs=1e-9)
    assert whole.low - 1e-9 <= whole.mean <= whole.high + 1e-9


def test_between_350_and_10_degrees_lies_north() -> None:
    points = [Point(NOW, bearing, bearing, bearing) for bearing in (350.0, 10.0)]
    mean = folded("wind_bearing", points, NOW).mean
    assert min(mean, 360 - mean) == pytest.approx(0.0, abs=1e-6)


@given(period_s=st.floats(1, 86_400), span=st.sampled_from(Span))
def test_each_step_of_a_chart_is_wide_enough_for_a_report(period_s: float, span: Span) -> None:
    assert span.step_s(period_s) >= min(period_s, 86_400)
    assert span.length.total_seconds() / span.step_s(period_s) <= 200


def test_a_step_without_a_value_is_a_gap() -> None:
    points = [Point(NOW, 1.0, 1.0, 1.0), Point(NOW + timedelta(minutes=30), 2.0, 2.0, 2.0)]
    found = with_gaps(stepped("wind_speed", points, 600), 600, NOW + timedelta(minutes=40))
    assert [one is None for _, one in found] == [False, True, True, False, True]
    assert with_gaps({}, 600, NOW) == []


# ---- quantities ----


@pytest.mark.parametrize("name", QUANTITIES)
def test_each_quantity_has_bounds_a_unit_and_a_name(name: str) -> None:
    one = QUANTITIES[name]
    assert one.low < one.high
    assert one.unit
    assert one.shown_unit
    assert Channel(name).label
    assert not one.is_plausible(float("nan"))
    assert one.is_plausible(one.low)
    assert not one.is_plausible(one.high + 1)


@pytest.mark.parametrize(
    ("depth_m", "key"), [(0.1, "soil_moisture@0.10"), (0.30, "soil_moisture@0.30"), (None, "soil_moisture")]
)
def test_a_channel_is_called_by_quantity_and_depth(depth_m: float | None, key: str) -> None:
    channel = Channel.of("soil_moisture", depth_m)
    assert channel.key == key
    assert Channel.of("soil_moisture", channel.depth_m) == channel


def test_what_is_not_in_the_catalogue_is_shown_as_it_comes() -> None:
    about = Channel("leaf_wetness").about("%")
    assert (Channel("leaf_wetness").label, about.text(12.345)) == ("Leaf wetness", "12.35 %")


def test_nothing_of_the_demos_past_is_written_twice(database: Database, tmp_path: Path) -> None:
    from hmi.demo.field_past import seed_stations
    from hmi.store.sensor_stations import SensorStations

    stations = SensorStations(database, "farm")
    assert len(seed_stations(stations, NOW)) == 9
    assert seed_stations(stations, NOW) == []
    for one in stations.all():
        stations.remove(one.id)
    assert seed_stations(stations, NOW) == []  # whoever took them out keeps it so

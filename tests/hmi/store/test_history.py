"""History: never more points than asked for, nothing hidden by averaging, coarser with age."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import delete, func, insert, select

from hmi.store.database import Database
from hmi.store.history import History
from hmi.store.tables import SampleRow
from hmi.store.thinning import Thinning
from tests.hmi.store.conftest import FARM

START = datetime(2026, 5, 4, 12, tzinfo=UTC)


def keep(database: Database, values: list[tuple[float, float | None]], robot_id: str = "weeder-01") -> None:
    """Store samples ``(seconds after START, speed)``; cross-track error is the negative speed."""
    rows = [
        {
            "farm_id": FARM, "robot_id": robot_id, "at": START + timedelta(seconds=at), "speed_mps": speed,
            "cross_track_m": None if speed is None else -speed, "lat_deg": 52 + at / 1e6, "lon_deg": 5.0, "period_s": 1,
        }
        for at, speed in values
    ]  # fmt: skip
    with database.connect_writing() as connection:
        connection.execute(insert(SampleRow), rows)


def rows(database: Database) -> list[SampleRow]:
    """Return every stored sample, oldest first."""
    with database.read() as session:
        return list(session.scalars(select(SampleRow).order_by(SampleRow.at)))


@pytest.fixture
def history(database: Database) -> History:
    """Return what reads the records."""
    return History(database, FARM)


def test_a_short_stretch_comes_back_value_by_value(database: Database, history: History) -> None:
    keep(database, [(n, n / 10) for n in range(60)])
    points = history.history("weeder-01", ["speed_mps"], START, START + timedelta(minutes=1), 100)
    assert [point.mean[0] for point in points] == [n / 10 for n in range(60)]
    assert points[0].at == START


def test_a_long_stretch_keeps_its_peaks(database: Database, history: History) -> None:
    keep(database, [(n, 9.0 if n == 1234 else 0.5) for n in range(7200)])
    points = history.history("weeder-01", ["speed_mps", "cross_track_m"], START, START + timedelta(hours=2), 50)
    assert 25 <= len(points) <= 50
    assert max(point.high[0] or 0 for point in points) == 9.0
    assert min(point.low[1] or 0 for point in points) == -9.0
    assert sum(point.count for point in points) == 7200


def test_gaps_stay_gaps(database: Database, history: History) -> None:
    keep(database, [(0, 1.0), (1, None), (2000, 2.0)])
    points = history.history("weeder-01", ["speed_mps"], START, START + timedelta(hours=1), 3600)
    assert [point.mean[0] for point in points] == [1.0, None, 2.0]


def test_other_robots_and_times_are_left_out(database: Database, history: History) -> None:
    keep(database, [(0, 1.0), (10, 2.0), (20, 3.0)])
    keep(database, [(10, 9.0)], "weeder-02")
    points = history.history("weeder-01", ["speed_mps"], START + timedelta(seconds=10), START + timedelta(seconds=20))
    assert [point.mean[0] for point in points] == [2.0]


def test_another_farm_sees_nothing(database: Database) -> None:
    keep(database, [(0, 1.0)])
    elsewhere = History(database, "elsewhere")
    assert elsewhere.history("weeder-01", ["speed_mps"], START, START + timedelta(1)) == []
    assert elsewhere.track("weeder-01", START, START + timedelta(1)) == []


def test_a_track_is_thinned_to_the_points_asked_for(database: Database, history: History) -> None:
    keep(database, [(n, 0.5) for n in range(3600)])
    track = history.track("weeder-01", START, START + timedelta(hours=1), 100)
    assert 50 <= len(track) <= 100
    assert track == sorted(track, key=lambda point: point.at)


def test_unknown_fields_are_refused(history: History) -> None:
    with pytest.raises(ValueError, match="no history of password"):
        history.history("weeder-01", ["password"], START, START + timedelta(1))


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 200_000), st.floats(-5, 5) | st.none()), min_size=1, max_size=60),
    st.integers(1, 40),
)
def test_no_more_points_than_asked_for_and_no_value_lost(
    database: Database, values: list[tuple[float, float | None]], most: int
) -> None:
    with database.connect_writing() as connection:
        connection.execute(delete(SampleRow))
    keep(database, values)
    points = History(database, FARM).history("weeder-01", ["speed_mps"], START, START + timedelta(days=3), most)
    known = [speed for _, speed in values if speed is not None]
    assert len(points) <= most
    assert sum(point.count for point in points) == len(values)
    assert max((p.high[0] for p in points if p.high[0] is not None), default=None) == max(known, default=None)
    assert min((p.low[0] for p in points if p.low[0] is not None), default=None) == min(known, default=None)


def test_fresh_samples_stay_as_they_are(database: Database) -> None:
    keep(database, [(n, 0.5) for n in range(100)])
    assert Thinning(database).run(START + timedelta(hours=23)) == 0
    assert len(rows(database)) == 100


def test_after_a_day_one_row_stands_for_ten_seconds(database: Database) -> None:
    keep(database, [(n, 0.1 * (n % 10)) for n in range(1800)])
    Thinning(database).run(START + timedelta(days=1, hours=1))
    kept = rows(database)
    assert len(kept) == 180
    assert {row.period_s for row in kept} == {10}
    assert kept[0].at == START + timedelta(seconds=9)
    assert kept[0].speed_mps == pytest.approx(0.45)
    assert kept[0].cross_track_m == pytest.approx(-0.9)


def test_after_a_month_one_row_stands_for_a_minute(database: Database) -> None:
    keep(database, [(n, 0.5) for n in range(1800)])
    thinning = Thinning(database)
    thinning.run(START + timedelta(days=2))
    thinning.run(START + timedelta(days=40))
    assert len(rows(database)) == 30
    assert {row.period_s for row in rows(database)} == {60}


def test_missions_and_robots_are_not_mixed(database: Database) -> None:
    keep(database, [(n, 0.5) for n in range(10)])
    keep(database, [(n, 0.7) for n in range(10)], "weeder-02")
    Thinning(database).run(START + timedelta(days=2))
    assert [(row.robot_id, row.speed_mps) for row in rows(database)] == [
        ("weeder-01", pytest.approx(0.5)), ("weeder-02", pytest.approx(0.7)),
    ]  # fmt: skip


def test_thinning_again_changes_nothing(database: Database) -> None:
    keep(database, [(n, 0.5) for n in range(700)])
    now = START + timedelta(days=2)
    Thinning(database).run(now)
    before = [(row.id, row.at, row.speed_mps) for row in rows(database)]
    assert Thinning(database).run(now) == 0
    assert [(row.id, row.at, row.speed_mps) for row in rows(database)] == before


def test_thinning_ends_with_the_database(database: Database) -> None:
    keep(database, [(n, 0.5) for n in range(0, 7200, 60)])
    assert Thinning(database).step(START + timedelta(days=2))
    database.close()
    assert Thinning(database).run(START + timedelta(days=2)) == 0


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.lists(st.tuples(st.integers(0, 3000), st.floats(-5, 5) | st.none()), min_size=1, max_size=80))
def test_thinning_keeps_the_worst_error_and_leaves_one_row_a_stretch(
    database: Database, values: list[tuple[float, float | None]]
) -> None:
    with database.connect_writing() as connection:
        connection.execute(delete(SampleRow))
    keep(database, values)
    Thinning(database).run(START + timedelta(days=3))
    worst = max((abs(speed) for _, speed in values if speed is not None), default=None)
    with database.read() as session:
        kept = session.scalar(select(func.max(func.abs(SampleRow.cross_track_m))))
    assert kept == (pytest.approx(worst) if worst is not None else None)
    assert len(rows(database)) == len({at // 10 for at, _ in values})

"""Repeats, blackout windows and daylight on a farm's clock, through its changes."""

from __future__ import annotations

from datetime import UTC, date, datetime, time, timedelta
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.queue.blackout import Blackout, blocked_until
from hmi.domain.queue.daylight import daylight, sun_day
from hmi.domain.queue.repeat import Repeat, RepeatKind, kept, local_instant, next_start
from hmi.store.queue import repeat_fields, repeat_of

AMSTERDAM = ZoneInfo("Europe/Amsterdam")
moments = st.integers(0, 7 * 365 * 86_400).map(lambda s: datetime(2024, 1, 1, tzinfo=UTC) + timedelta(seconds=s))
zones = st.sampled_from(
    [ZoneInfo(name) for name in ("Europe/Amsterdam", "America/Chicago", "Australia/Lord_Howe", "UTC")]
)
rules = st.one_of(
    st.just(Repeat(RepeatKind.DAILY)),
    st.just(Repeat(RepeatKind.WORKDAYS)),
    st.builds(lambda days: Repeat(RepeatKind.WEEKLY, days), st.frozensets(st.integers(0, 6), min_size=1)),
    st.builds(lambda n: Repeat(RepeatKind.EVERY_N_DAYS, every_days=n), st.integers(1, 60)),
)
windows = st.builds(
    lambda days, begin, end: Blackout("b-1", "farm", "Night", days, begin, end),
    st.frozensets(st.integers(0, 6), min_size=1),
    st.integers(0, 1439),
    st.integers(0, 1439),
)


def local(text: str, zone: ZoneInfo = AMSTERDAM) -> datetime:
    """Return an instant from a time on the farm's clock."""
    return datetime.fromisoformat(text).replace(tzinfo=zone).astimezone(UTC)


@given(rules, moments, st.timedeltas(timedelta(0), timedelta(days=500)), zones)
def test_the_next_day_of_a_job_is_never_in_the_past_and_keeps_its_time_of_day(
    rule: Repeat, start: datetime, later: timedelta, zone: ZoneInfo
) -> None:
    now = start + later
    found = next_start(rule, start, now, zone)
    assert found is not None
    assert found > now
    assert found.astimezone(zone).date() > start.astimezone(zone).date()
    day, wanted = found.astimezone(zone), start.astimezone(zone).time().replace(fold=0)
    # equal, but for a time that the clocks leave out that day
    assert day.time() == wanted or found == local_instant(day.date(), wanted, zone)
    if rule.kind is RepeatKind.WORKDAYS:
        assert day.weekday() < 5
    if rule.kind is RepeatKind.WEEKLY:
        assert day.weekday() in rule.days


def test_a_job_at_half_past_two_comes_an_hour_later_when_the_clocks_go_forward() -> None:
    found = next_start(Repeat(RepeatKind.DAILY), local("2026-03-28T02:30"), local("2026-03-28T12:00"), AMSTERDAM)
    assert found == local("2026-03-29T03:30")


def test_a_job_that_was_moved_by_the_clocks_is_back_at_its_time_the_day_after() -> None:
    rule, start = Repeat(RepeatKind.DAILY), local("2026-03-28T02:30")
    times = []
    for _ in range(3):
        rule = repeat_of(repeat_fields(kept(rule, start, AMSTERDAM)))  # as it is stored
        following = next_start(rule, start, start, AMSTERDAM)
        assert following is not None
        start = following
        times.append(start)
    assert times == [local("2026-03-29T03:30"), local("2026-03-30T02:30"), local("2026-03-31T02:30")]


def test_a_job_at_half_past_two_comes_once_when_the_clocks_go_back() -> None:
    first = next_start(Repeat(RepeatKind.DAILY), local("2026-10-24T02:30"), local("2026-10-24T12:00"), AMSTERDAM)
    assert first == datetime(2026, 10, 25, 0, 30, tzinfo=UTC)
    assert first is not None
    second = next_start(Repeat(RepeatKind.DAILY), first, first, AMSTERDAM)
    assert second == local("2026-10-26T02:30")


def test_a_rule_ends_after_its_last_day() -> None:
    rule = Repeat(RepeatKind.DAILY, until=date(2026, 6, 16))
    start = local("2026-06-15T06:00")
    assert next_start(rule, start, start, AMSTERDAM) == local("2026-06-16T06:00")
    assert next_start(rule, start, local("2026-06-16T07:00"), AMSTERDAM) is None


@pytest.mark.parametrize("bad", [{"kind": RepeatKind.WEEKLY}, {"kind": RepeatKind.EVERY_N_DAYS, "every_days": 0}])
def test_a_rule_without_days_is_refused(bad: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"day|days"):
        Repeat(**bad)  # type: ignore[arg-type]


NIGHT = Blackout("b-1", "farm", "Night", frozenset(range(7)), 22 * 60, 6 * 60)


@pytest.mark.parametrize(
    ("now", "free"),
    [
        ("2026-06-15T21:59", None),
        ("2026-06-15T22:00", "2026-06-16T06:00"),
        ("2026-06-16T05:59", "2026-06-16T06:00"),
        ("2026-06-16T06:00", None),
        ("2026-03-28T23:00", "2026-03-29T06:00"),  # an hour shorter: the clocks go forward
        ("2026-10-25T02:30", "2026-10-25T06:00"),  # an hour longer
    ],
)
def test_a_night_is_blocked_across_midnight(now: str, free: str | None) -> None:
    found = blocked_until([NIGHT], "weeder-01", local(now), AMSTERDAM)
    assert (None if found is None else found[1]) == (None if free is None else local(free))


def test_a_window_of_saturday_reaches_into_sunday_and_not_into_saturday_morning() -> None:
    window = Blackout("b-1", "farm", "Market", frozenset({5}), 22 * 60, 6 * 60)
    assert window.ends(local("2026-06-20T05:00"), AMSTERDAM) is None
    assert window.ends(local("2026-06-21T05:00"), AMSTERDAM) == local("2026-06-21T06:00")


def test_windows_that_join_end_together_and_another_robots_window_does_not_count() -> None:
    morning = Blackout("b-2", "farm", "School", frozenset(range(5)), 6 * 60, 8 * 60)
    other = Blackout("b-3", "farm", "Other", frozenset(range(7)), 8 * 60, 20 * 60, ("weeder-02",))
    found = blocked_until([NIGHT, morning, other], "weeder-01", local("2026-06-16T03:00"), AMSTERDAM)
    assert found is not None
    assert (found[0].name, found[1]) == ("Night", local("2026-06-16T08:00"))


@given(windows, moments, zones)
def test_a_window_that_holds_now_ends_later_and_within_a_day(window: Blackout, now: datetime, zone: ZoneInfo) -> None:
    ends = window.ends(now, zone)
    if ends is not None:
        assert now < ends <= now + timedelta(hours=25)


@given(st.lists(windows, max_size=6), moments, zones)
def test_the_end_of_a_blackout_is_outside_of_every_window(every: list[Blackout], now: datetime, zone: ZoneInfo) -> None:
    found = blocked_until(every, "weeder-01", now, zone)
    if found is None:
        assert all(one.ends(now, zone) is None for one in every)
    elif found[1] < now + timedelta(days=14):  # windows that fill every hour never end
        assert all(one.ends(found[1], zone) is None for one in every)


# published by national services and almanacs, local time to the minute
PUBLISHED = [
    ("Greenwich", 51.477, 0.0, date(2026, 6, 21), "Europe/London", time(4, 43), time(21, 21)),
    ("Greenwich", 51.477, 0.0, date(2026, 12, 21), "Europe/London", time(8, 4), time(15, 53)),
    ("Madrid", 40.4168, -3.7038, date(2026, 6, 21), "Europe/Madrid", time(6, 44), time(21, 48)),
    ("Sydney", -33.8688, 151.2093, date(2026, 12, 21), "Australia/Sydney", time(5, 41), time(20, 5)),
    ("Quito", -0.1807, -78.4678, date(2026, 3, 20), "America/Guayaquil", time(6, 18), time(18, 24)),
]


@pytest.mark.parametrize(("place", "lat", "lon", "day", "zone", "rises", "sets"), PUBLISHED)
def test_sunrise_and_sunset_are_those_published(
    place: str, lat: float, lon: float, day: date, zone: str, rises: time, sets: time
) -> None:
    sun = sun_day(day, lat, lon)
    for found, published in ((sun.rises, rises), (sun.sets, sets)):
        assert found is not None
        wanted = datetime.combine(day, published, tzinfo=ZoneInfo(zone))
        assert abs((found - wanted).total_seconds()) <= 120, (place, found.astimezone(ZoneInfo(zone)), published)


def test_the_sun_stays_up_and_down_in_the_far_north() -> None:
    assert sun_day(date(2026, 6, 21), 69.65, 18.96).is_always_up
    night = sun_day(date(2026, 12, 21), 69.65, 18.96)
    assert (night.rises, night.is_always_up) == (None, False)
    is_day, begins = daylight(
        datetime(2026, 12, 21, 12, tzinfo=UTC), 69.65, 18.96, after_rise=timedelta(0), before_set=timedelta(0)
    )
    assert not is_day
    assert begins is not None
    assert begins.month == 1


@given(moments, st.floats(-60, 60), st.floats(-180, 180))
def test_it_is_day_exactly_from_the_moment_that_was_named(now: datetime, lat: float, lon: float) -> None:
    none = timedelta(0)
    is_day, begins = daylight(now, lat, lon, after_rise=none, before_set=none)
    if is_day:
        return
    assert begins is not None
    assert now < begins < now + timedelta(hours=24)
    assert daylight(begins + timedelta(seconds=1), lat, lon, after_rise=none, before_set=none)[0]
    assert not daylight(begins - timedelta(seconds=1), lat, lon, after_rise=none, before_set=none)[0]


def test_offsets_shorten_the_day() -> None:
    hour = timedelta(hours=1)
    at = datetime(2026, 6, 21, 4, 10, tzinfo=UTC)  # Greenwich: up since 03:43
    assert daylight(at, 51.477, 0.0, after_rise=timedelta(0), before_set=timedelta(0))[0]
    is_day, begins = daylight(at, 51.477, 0.0, after_rise=hour, before_set=hour)
    assert not is_day
    assert begins is not None
    assert abs((begins - datetime(2026, 6, 21, 4, 43, tzinfo=UTC)).total_seconds()) < 120

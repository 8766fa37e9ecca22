"""Limits, delays and chattering: a restless value makes one alarm, a short one none."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.alarm.flood import Flood
from hmi.domain.alarm.steady import Chatter, Limit, Steady

values = st.floats(-1e6, 1e6)


def test_a_limit_is_left_only_beyond_its_dead_band() -> None:
    wind = Limit(11.0, deadband=1.0)
    seen, is_passed = [], False
    for value in (10.9, 11.0, 10.5, 10.0, 10.5, 11.2):
        is_passed = wind.is_passed(value, was_passed=is_passed)
        seen.append(is_passed)
    assert seen == [False, True, True, False, False, True]


def test_a_lower_limit_works_the_other_way_round() -> None:
    battery = Limit(0.2, deadband=0.02, is_lower=True)
    assert battery.is_passed(0.2, was_passed=False)
    assert battery.is_passed(0.21, was_passed=True)
    assert not battery.is_passed(0.22, was_passed=True)


@given(st.floats(-100, 100), st.floats(0, 10), st.booleans(), values)
def test_a_value_that_is_not_known_changes_nothing(at: float, band: float, is_lower: bool, value: float) -> None:
    limit = Limit(at, band, is_lower)
    for was_passed in (False, True):
        assert limit.is_passed(None, was_passed=was_passed) is was_passed
        assert limit.is_passed(math.nan, was_passed=was_passed) is was_passed
    # what raises an alarm does not end it
    if limit.is_passed(value, was_passed=False):
        assert limit.is_passed(value, was_passed=True)


def test_a_limit_that_is_no_number_is_refused() -> None:
    with pytest.raises(ValueError, match="finite"):
        Limit(math.nan)


@given(st.lists(st.tuples(st.booleans(), st.floats(0.01, 5))), st.floats(0, 10), st.floats(0, 10))
def test_a_condition_counts_exactly_when_it_lasted(story: list[tuple[bool, float]], on_s: float, off_s: float) -> None:
    steady, now_s, lasted = Steady(on_s, off_s), 0.0, (False, 0.0)
    is_on = False
    for is_so, step_s in story:
        now_s += step_s
        if is_so != lasted[0]:
            lasted = (is_so, now_s)
        if is_so != is_on and now_s - lasted[1] >= (on_s if is_so else off_s):
            is_on = is_so
        assert steady.see(is_so=is_so, now_s=now_s) is is_on


def test_when_a_condition_will_count_is_known_before() -> None:
    steady = Steady(on_s=2.0)
    steady.see(is_so=True, now_s=10.0)
    assert steady.due_s() == 12.0
    assert steady.see(is_so=True, now_s=12.0)
    assert steady.due_s() is None


def test_three_times_a_minute_is_chattering_until_a_minute_was_quiet() -> None:
    chatter = Chatter()
    for second in (0, 20, 40):
        chatter.changed(is_on=True, now_s=second)
        chatter.changed(is_on=False, now_s=second + 5)
    assert chatter.pass_time(60)
    assert chatter.pass_time(104.9)
    assert not chatter.pass_time(105)


def test_three_times_in_two_minutes_is_not() -> None:
    chatter = Chatter()
    for second in (0, 45, 90):
        chatter.changed(is_on=True, now_s=second)
    assert not chatter.pass_time(91)


@given(st.lists(st.floats(0, 300), max_size=60))
def test_a_flood_is_ten_alarms_in_ten_minutes(gaps: list[float]) -> None:
    flood, now_s, times = Flood(), 0.0, []
    is_flood = False
    for gap_s in gaps:
        now_s += gap_s
        for moment_s in (now_s - gap_s / 2, now_s):  # looked at in between too
            recent = [one for one in times if moment_s - one < 600]
            is_flood = len(recent) >= 10 if not is_flood else len(recent) >= 5
            assert flood.pass_time(moment_s) is is_flood
        times.append(now_s)
        recent = [one for one in times if now_s - one < 600]
        is_flood = is_flood or len(recent) >= 10
        is_flood = is_flood and len(recent) >= 5
        assert flood.raised(now_s) is is_flood
        assert flood.count(now_s) == len(recent)
    assert all(a <= b for a, b in pairwise(times))

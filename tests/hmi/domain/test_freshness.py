"""Ages stay true whatever clocks and radios do."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.clock import FakeClock
from hmi.domain.freshness import BUCKET_S, WINDOW_BUCKETS, ClockMap, Freshness, TickRing, freshness

WINDOW_S = WINDOW_BUCKETS * BUCKET_S


@pytest.mark.parametrize(
    ("age_s", "period_s", "judged"),
    [
        (None, 0.1, Freshness.MISSING),
        (0.0, 0.1, Freshness.FRESH),
        (0.99, 0.5, Freshness.FRESH),
        (1.0, 0.1, Freshness.LATE),
        (2.0, 0.1, Freshness.STALE),
        (3.5, 0.1, Freshness.LOST),
        (1.4, 1.0, Freshness.FRESH),
        (1.5, 1.0, Freshness.LATE),
        (3.0, 1.0, Freshness.STALE),
        (60.0, 1.0, Freshness.STALE),
        (14.0, 5.0, Freshness.LATE),
    ],
)
def test_limits_are_those_of_the_safety_rules(age_s: float | None, period_s: float, judged: Freshness) -> None:
    assert freshness(age_s, period_s) is judged


def heard(clock_map: ClockMap, *, seconds: float, start_s: float, delay_s: float = 0.01, offset_s: float) -> None:
    """Let a robot be heard ten times a second from ``start_s`` on."""
    for index in range(int(seconds * 10)):
        made_s = start_s + index / 10
        clock_map.observe("boot-aaaa", round((made_s - offset_s) * 1000), made_s + delay_s)


@given(
    offset_s=st.floats(-1e6, 1e6),
    delays_s=st.lists(st.floats(0, 30), min_size=1, max_size=60),
)
def test_a_frame_never_seems_younger_than_it_was_once_a_fast_one_was_seen(
    offset_s: float, delays_s: list[float]
) -> None:
    clock_map = ClockMap()
    robot_ms = round((5_000_000 - offset_s) * 1000)
    clock_map.observe("boot-aaaa", robot_ms, robot_ms / 1000 + offset_s)  # arrived at once
    for index, delay_s in enumerate(delays_s):
        made_ms = robot_ms + (index + 1) * 100
        received_s = made_ms / 1000 + offset_s + delay_s
        source_s = clock_map.observe("boot-aaaa", made_ms, received_s)
        assert received_s - source_s == pytest.approx(delay_s, abs=0.002)


@given(silence_s=st.floats(1, 3600), held=st.integers(2, 100))
def test_a_burst_after_a_silence_of_any_length_shows_its_true_age(silence_s: float, held: int) -> None:
    clock_map = ClockMap()
    heard(clock_map, seconds=20, start_s=1000, offset_s=400)
    burst_s = 1020 + silence_s
    first_made_s = burst_s - silence_s
    for index in range(held):
        made_s = first_made_s + index * silence_s / held
        source_s = clock_map.observe("boot-aaaa", round((made_s - 400) * 1000), burst_s)
        assert source_s == pytest.approx(made_s + 0.01, abs=0.002)


@given(ppm=st.floats(-300, 300))
def test_slow_drift_is_followed(ppm: float) -> None:
    clock_map = ClockMap()
    for index in range(1800):  # half an hour at 1 Hz
        true_s = 1000.0 + index
        robot_ms = round((true_s - 1000) * (1 + ppm / 1e6) * 1000)
        source_s = clock_map.observe("boot-aaaa", robot_ms, true_s + 0.02)
        assert abs(true_s + 0.02 - source_s) < 0.02 + 2 * WINDOW_S * abs(ppm) / 1e6


def test_a_reboot_starts_a_new_map() -> None:
    clock_map = ClockMap()
    heard(clock_map, seconds=20, start_s=1000, offset_s=400)
    source_s = clock_map.observe("boot-bbbb", 500, 1060.0)
    assert source_s == pytest.approx(1060.0)
    assert clock_map.boot == "boot-bbbb"
    assert clock_map.source_s("boot-aaaa", 700_000) is None


@given(jumps_s=st.lists(st.floats(-7200, 7200), max_size=10))
def test_wall_clocks_take_no_part(jumps_s: list[float]) -> None:
    clock, clock_map = FakeClock(), ClockMap()
    ticks = TickRing("boot1", clock.mono_s, clock.utc)
    for index, jump_s in enumerate([0.0, *jumps_s]):
        clock.jump_wall(jump_s)
        clock.advance(0.5)
        tick = ticks.issue()
        received_s = clock.mono_s()
        source_s = clock_map.observe("boot-aaaa", 500 * (index + 1), received_s)
        assert received_s - source_s == pytest.approx(0, abs=1e-6)
        assert ticks.is_fresh(tick.id)


def test_a_robot_that_was_suspended_is_fresh_again_after_one_answered_ping() -> None:
    clock_map = ClockMap()
    heard(clock_map, seconds=20, start_s=1000, offset_s=400)
    # its monotonic clock stood still for an hour; one way alone cannot tell that from an hour of delay
    assert 4700.0 - clock_map.observe("boot-aaaa", 620_100, 4700.0) > 3000
    assert clock_map.confirm("boot-aaaa", 620_200, 4700.1, rtt_s=0.05) == pytest.approx(4700.1)
    assert clock_map.observe("boot-aaaa", 620_300, 4700.2) == pytest.approx(4700.2)


def test_a_held_answer_to_a_ping_keeps_its_age() -> None:
    clock_map = ClockMap()
    heard(clock_map, seconds=20, start_s=1000, offset_s=400)
    assert clock_map.confirm("boot-aaaa", 620_000, 1028.0, rtt_s=8.2) == pytest.approx(1020.01, abs=0.002)


def test_a_tick_is_refused_after_two_seconds() -> None:
    clock = FakeClock()
    ticks = TickRing("boot1", clock.mono_s, clock.utc)
    tick = ticks.issue()
    clock.advance(2.0)
    assert ticks.is_fresh(tick.id)
    clock.advance(0.001)
    assert not ticks.is_fresh(tick.id)


def test_a_tick_of_a_stalled_console_grows_old_though_none_followed() -> None:
    clock = FakeClock()
    ticks = TickRing("boot1", clock.mono_s, clock.utc)
    tick = ticks.issue()
    clock.advance(3600)
    assert not ticks.is_fresh(tick.id)
    assert ticks.age_s(tick.id) == pytest.approx(3600)


def test_a_tick_of_before_a_paused_machine_is_refused_though_its_monotonic_clock_stood() -> None:
    clock = FakeClock()
    ticks = TickRing("boot1", clock.mono_s, clock.utc)
    before = ticks.issue()
    clock.jump_wall(120)
    clock.advance(0.05)
    assert not ticks.is_fresh(before.id)  # already before the next beat
    after = ticks.issue()
    assert not ticks.is_fresh(before.id)
    assert ticks.is_fresh(after.id)


@pytest.mark.parametrize("jump_s", [-3600.0, -2.5, 1.9])
def test_a_wall_clock_set_back_or_a_little_forward_makes_no_tick_old(jump_s: float) -> None:
    clock = FakeClock()
    ticks = TickRing("boot1", clock.mono_s, clock.utc)
    tick = ticks.issue()
    clock.jump_wall(jump_s)
    assert ticks.age_s(tick.id) == 0.0


def test_a_tick_of_an_earlier_run_of_the_console_is_refused() -> None:
    clock = FakeClock()
    old = TickRing("boot1", clock.mono_s, clock.utc).issue()
    fresh = TickRing("boot2", clock.mono_s, clock.utc)
    fresh.issue()
    assert not fresh.is_fresh(old.id)


@given(text=st.text(max_size=90))
def test_what_was_never_issued_is_refused(text: str) -> None:
    clock = FakeClock()
    ticks = TickRing("boot1", clock.mono_s, clock.utc)
    issued = {ticks.issue().id for _ in range(5)}
    assert ticks.is_fresh(text) == (text in issued)


@pytest.mark.parametrize("forged", ["boot1-6", "boot1-0", "boot1--1", "boot1-05", "boot1-٣", "boot1-", "boot1", "-5"])
def test_a_forged_tick_is_refused(forged: str) -> None:
    clock = FakeClock()
    ticks = TickRing("boot1", clock.mono_s, clock.utc)
    for _ in range(5):
        ticks.issue()
    assert not ticks.is_fresh(forged)


@given(steps_s=st.lists(st.floats(0, 1.5), min_size=1, max_size=80))
def test_a_tick_is_fresh_exactly_while_it_is_at_most_two_seconds_old(steps_s: list[float]) -> None:
    clock = FakeClock()
    ticks = TickRing("boot1", clock.mono_s, clock.utc)
    issued = []
    for step_s in steps_s:
        clock.advance(step_s)
        issued.append(ticks.issue())
    for tick in issued:
        assert ticks.is_fresh(tick.id) == (clock.mono_s() - tick.at_s <= 2.0)

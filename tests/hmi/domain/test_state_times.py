"""Stays in states follow from what a robot told, whatever of it was lost."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterable
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.event import RobotEvent
from hmi.domain.state_chart import Chart, ChartState
from hmi.domain.state_share import add_up, resting
from hmi.domain.state_times import Interval, Mark, Silence, intervals, mark_of

T0 = datetime(2026, 5, 20, 12, 0, tzinfo=UTC)


def state(
    name: str, parent: str | None = None, kind: str = "simple", *, first: bool = False, normal: float | None = None
) -> ChartState:
    """Return a state of the chart under test."""
    return ChartState(
        name, name.title(), parent, kind, first, {"a": "Crane", "b": "Drive"}.get(name[0], "Waiting"), normal, (), ()
    )


CHART = Chart(
    (
        state("idle", first=True),
        state("mission", kind="composite"),
        state("walk", "mission", first=True, normal=8),
        state("site", "mission", "parallel"),
        state("region-a", "site", "region"),
        state("a1", "region-a", first=True),
        state("a2", "region-a", normal=5),
        state("a3", "region-a", normal=6),
        state("region-b", "site", "region"),
        state("b1", "region-b", first=True, normal=4),
        state("b2", "region-b", normal=7),
    ),
    (),
)
BY_ID = {one.id: one for one in CHART.states}
LEAVES = {one.id for one in CHART.states} - {one.parent for one in CHART.states}


def at(seconds: float) -> datetime:
    """Return a time."""
    return T0 + timedelta(seconds=seconds)


def path(name: str) -> tuple[str, ...]:
    """Return labels, outermost first."""
    one = BY_ID[name]
    return (*(path(one.parent) if one.parent else ()), one.label)


def mark(name: str, seconds: float, lasted_s: float | None = None, result: str = "") -> Mark:
    """Return an entry, or with ``lasted_s`` the end of a stay."""
    one = BY_ID[name]
    return Mark(
        at(seconds), lasted_s is None, name, one.label, one.subsystem, path(name), name in LEAVES, lasted_s, result
    )


def log_of(stays: Iterable[tuple[str, float, float]]) -> list[Mark]:
    """Return everything a robot tells of these stays."""
    return [m for name, start, end in stays for m in (mark(name, start), mark(name, end, end - start))]


def said(found: Iterable[Interval]) -> dict[str, list[tuple[float, float | None]]]:
    """Return stays by state, in seconds."""
    told: dict[str, list[tuple[float, float | None]]] = {}
    for one in found:
        end = None if one.end is None else round((one.end - T0).total_seconds(), 3)
        told.setdefault(one.state, []).append((round((one.start - T0).total_seconds(), 3), end))
    return told


def story(seed: int, laps: int) -> list[tuple[str, float, float]]:
    """Return what a robot did: idle, then a mission in which two regions go through their states."""
    choose = random.Random(seed)
    stays, t = [("idle", 0.0, 10.0)], 10.0
    begin = t
    for _ in range(laps):
        walk = choose.uniform(2, 20)
        stays.append(("walk", t, t + walk))
        t += walk
        site_from, end = t, t + choose.uniform(30, 90)
        for names in (("a1", "a2", "a3"), ("b1", "b2")):
            u, i = site_from, 0
            while u < end:
                until = min(end, u + choose.uniform(2, 15))
                stays.append((names[i % len(names)], round(u, 3), round(until, 3)))
                u, i = until, i + 1
        stays += [("site", site_from, end), ("region-a", site_from, end), ("region-b", site_from, end)]
        t = end
    return [*stays, ("mission", begin, t), ("idle", t, t + 5)]


@given(st.integers(0, 10_000), st.integers(1, 4))
def test_a_whole_log_gives_exactly_what_the_robot_did(seed: int, laps: int) -> None:
    did = story(seed, laps)
    found = intervals(log_of(did), CHART)
    assert not any(one.is_guessed or one.end is None for one in found)
    told = sorted((one.state, one.start, one.end) for one in found if one.end is not None)
    meant = sorted((name, at(start), at(end)) for name, start, end in did)
    for (state_a, start_a, end_a), (state_b, start_b, end_b) in zip(told, meant, strict=True):
        assert state_a == state_b
        assert abs((start_a - start_b).total_seconds()) < 0.01
        assert abs((end_a - end_b).total_seconds()) < 0.01


@given(st.integers(0, 10_000), st.floats(0.02, 0.4), st.integers(0, 100))
def test_with_lost_events_no_two_states_of_a_region_overlap_and_no_time_is_invented(
    seed: int, lost: float, lottery: int
) -> None:
    did = story(seed, 3)
    choose = random.Random(lottery)
    kept = [one for one in log_of(did) if choose.random() > lost]
    end = max((one.at for one in kept), default=T0)
    found = intervals(kept, CHART, {}, end)
    for parent in {one.parent for one in CHART.states if one.parent is None or BY_ID[one.parent].kind != "parallel"}:
        same = [one for one in found if BY_ID[one.state].parent == parent]
        for before, after in itertools.pairwise(same):
            assert before.end is not None
            assert before.end <= after.start + timedelta(seconds=0.01)
    assert all(one.end is not None and one.start <= one.end <= end + timedelta(seconds=0.01) for one in found)
    wall_s = (end - T0).total_seconds()
    for state_time in add_up(found, CHART, T0, end).states:
        assert state_time.total_s <= wall_s + 0.01


@given(st.integers(0, 10_000), st.floats(1, 150))
def test_what_lasts_is_open_and_was_entered_when_the_robot_says(seed: int, now_s: float) -> None:
    did = story(seed, 3)
    lasting = {name: start for name, start, end in did if start <= now_s < end}
    heard = [one for one in log_of(did) if one.at <= at(now_s)]
    found = intervals(heard, CHART, {name: at(start) for name, start in lasting.items()}, at(now_s))
    assert {one.state for one in found if one.end is None} == set(lasting)
    starts = {one.state: (one.start - T0).total_seconds() for one in found if one.end is None}
    assert starts == pytest.approx(lasting, abs=0.01)


def test_an_end_that_was_lost_is_the_beginning_of_the_next_state_in_the_same_region() -> None:
    found = intervals([mark("a2", 0), mark("b1", 1), mark("a3", 6), mark("a3", 9, 3)], CHART, {}, at(30))
    assert said(found)["a2"] == [(0, 6)]
    assert [one.is_guessed for one in found if one.state == "a2"] == [True]


def test_an_entry_that_was_lost_is_known_from_the_time_told_at_the_end() -> None:
    found = intervals([mark("a2", 9, 4, "FAIL_CRANE")], CHART)
    assert said(found)["a2"] == [(5, 9)]
    assert (found[0].result, found[0].is_guessed) == ("FAIL_CRANE", False)


def test_a_robot_that_starts_anew_without_a_word_ends_everything_it_was_in() -> None:
    told = [mark("mission", 0), mark("site", 0), mark("region-a", 0), mark("a2", 3), mark("idle", 60)]
    found = intervals(told, CHART, {"idle": at(60)}, at(70))
    assert said(found) == {
        "mission": [(0, 60)], "site": [(0, 60)], "region-a": [(0, 60)], "a2": [(3, 60)], "idle": [(60, None)],
    }  # fmt: skip


def test_a_stay_that_is_over_and_whose_end_nobody_told_ended_when_the_robot_was_heard_last() -> None:
    found = intervals([mark("walk", 0)], CHART, {}, at(12))
    assert said(found)["walk"] == [(0, 12)]


def test_a_state_entered_twice_within_a_second_keeps_both_stays() -> None:
    did = [("a2", 0.0, 0.3), ("a3", 0.3, 0.5), ("a2", 0.5, 0.9), ("a1", 0.9, 4.0)]
    assert said(intervals(log_of(did), CHART))["a2"] == [(0, 0.3), (0.5, 0.9)]


def test_a_robot_without_a_chart_is_read_by_its_path() -> None:
    def told(kind: str, name: str, seconds: float, **data: object) -> RobotEvent:
        return RobotEvent(
            "weeder-01", f"{kind}{seconds}", kind, name, "", {"path": name.split(" > "), **data}, at_utc=at(seconds)
        )

    events = [
        told("state_entered", "Idle", 0),
        told("state_left", "Idle", 10, duration_ms=10_000),
        told("state_entered", "Mission > Treat row > Laser", 10),
        told("mode", "auto", 11),
        told("state_entered", "Mission > Turn", 40),
    ]
    found = intervals([m for e in events if (m := mark_of(e))], None, None, at(50))
    assert [(one.label, one.subsystem) for one in found] == [
        ("Idle", "Idle"),
        ("Laser", "Mission"),
        ("Turn", "Mission"),
    ]
    assert said(found) == {"Idle": [(0, 10)], "Mission > Treat row > Laser": [(10, 40)], "Mission > Turn": [(40, 50)]}


@given(
    st.dictionaries(
        st.sampled_from(["state", "path", "subsystem", "is_leaf", "duration_ms", "result"]),
        st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.lists(st.integers()),
    )
)
def test_whatever_a_robot_writes_into_an_event_is_read_or_ignored(data: dict[str, object]) -> None:
    event = RobotEvent("x", "1", "state_left", "A > B", "", data, at_utc=T0)
    one = mark_of(event)
    assert one is not None
    assert one.duration_s is None or one.duration_s >= 0
    intervals([one, replace(one, is_entry=True)], CHART, {}, T0)


def test_a_region_that_rests_counts_for_no_subsystem_and_shares_add_up_to_one() -> None:
    assert resting(CHART) == {"a1"}
    sums = add_up(
        intervals(log_of([("a1", 0, 60), ("a2", 60, 70), ("b1", 0, 30), ("b2", 30, 70)]), CHART), CHART, T0, at(70)
    )
    assert {one.subsystem: round(one.seconds) for one in sums.shares} == {"Drive": 70, "Crane": 10}
    assert sum(one.share for one in sums.shares) == pytest.approx(1)
    assert (sums.total_s, sums.wall_s) == (80, 70)


def test_only_what_lies_in_the_span_is_added_up_but_means_are_of_whole_stays() -> None:
    sums = add_up(intervals(log_of([("a2", 0, 20)]), CHART), CHART, at(10), at(15))
    (one,) = sums.states
    assert (one.total_s, one.mean_s, one.count) == (5, 20, 1)


def test_a_state_that_takes_clearly_longer_than_usual_is_flagged_after_three_stays() -> None:
    long = [("a2", n * 20.0, n * 20.0 + 8) for n in range(3)]
    few = add_up(intervals(log_of(long[:2]), CHART), CHART, T0, at(100)).states[0]
    many = add_up(intervals(log_of(long), CHART), CHART, T0, at(100)).states[0]
    assert (few.is_drifting, many.is_drifting) == (False, True)
    assert many.drift == pytest.approx(0.6)


def test_a_stay_that_a_power_cut_ended_ends_when_the_robot_was_heard_last() -> None:
    marks = [mark("a2", 100), mark("idle", 40_000), mark("walk", 40_010)]
    night = Silence(at(130), at(39_990))
    assert said(intervals(marks, CHART, {}, at(40_100)))["a2"] == [(100, 40_100)]
    (stay,) = [one for one in intervals(marks, CHART, {}, at(40_100), [night]) if one.state == "a2"]
    assert (stay.end, stay.is_guessed) == (at(130), True)


def test_a_silence_ends_no_stay_that_lasts_or_was_told() -> None:
    quiet = Silence(at(130), at(700))
    told = intervals([mark("a2", 100), mark("a2", 600, 500.0)], CHART, {}, at(900), [quiet])
    assert said(told)["a2"] == [(100, 600)]
    lasting = intervals([mark("a2", 100)], CHART, {"a2": at(100)}, at(900), [quiet])
    assert said(lasting)["a2"] == [(100, None)]
    within = intervals([mark("a2", 300), mark("a3", 400)], CHART, {}, at(900), [quiet])
    assert said(within)["a2"] == [(300, 400)], "it was on: what it told came later"

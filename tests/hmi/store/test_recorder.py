"""The recorder: one sample a second, every change of state, every event once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from datetime import timedelta

import pytest

from hmi.clock import FakeClock
from hmi.domain.event import RobotEvent
from hmi.domain.machine import Body
from hmi.domain.robot import Mode, Stamp
from hmi.store.database import Database
from hmi.store.history import History
from hmi.store.recorder import Recorder
from tests.hmi.store.conftest import FARM
from tests.hmi.store.robots import robot

WAIT_S = 10.0


@pytest.fixture
def recorder(database: Database, clock: FakeClock) -> Iterator[Recorder]:
    """Return a running recorder that knows two weeders."""
    recorder = Recorder(database, FARM, clock, {"weeder-01", "weeder-02"}.__contains__, linger_s=0.0)
    recorder.start()
    yield recorder
    recorder.close(WAIT_S)


@pytest.fixture
def history(database: Database) -> History:
    """Return what reads the records."""
    return History(database, FARM)


def drive(recorder: Recorder, clock: FakeClock, seconds: float, rate_hz: float = 10.0) -> None:
    """Let weeder-01 send telemetry."""
    for _ in range(round(seconds * rate_hz)):
        clock.advance(1 / rate_hz)
        recorder.see(robot(clock.mono_s()))
    assert recorder.flush(WAIT_S)


def test_ten_values_a_second_become_one_sample(recorder: Recorder, history: History, clock: FakeClock) -> None:
    start = clock.utc()
    drive(recorder, clock, 20.0)
    points = history.history("weeder-01", ["speed_mps", "soc", "row"], start, clock.utc() + timedelta(seconds=1))
    assert 20 <= len(points) <= 21
    assert points[0].mean == (0.4, 0.8, 3.0)


def test_a_robot_that_sends_once_a_second_with_jitter_loses_no_sample(
    recorder: Recorder, history: History, clock: FakeClock
) -> None:
    start = clock.utc()
    for step in (1.0, 0.96, 1.05, 0.97, 1.02):
        clock.advance(step)
        recorder.see(robot(clock.mono_s()))
    assert recorder.flush(WAIT_S)
    track = history.track("weeder-01", start, clock.utc() + timedelta(seconds=1))
    assert len(track) == 5


def test_a_silent_robot_makes_no_samples(recorder: Recorder, history: History, clock: FakeClock) -> None:
    start, last = clock.utc(), robot(clock.mono_s())
    for _ in range(50):
        clock.advance(1)
        recorder.see(last)
    assert recorder.flush(WAIT_S)
    assert len(history.track("weeder-01", start, clock.utc())) == 1


def test_a_sample_carries_the_time_it_was_true_not_the_time_it_came(
    recorder: Recorder, history: History, clock: FakeClock
) -> None:
    was_true = clock.utc()
    late = robot(clock.mono_s())
    clock.advance(30)
    recorder.see(late)
    assert recorder.flush(WAIT_S)
    assert history.track("weeder-01", was_true, was_true + timedelta(seconds=1))[0].at == was_true


def test_robots_nobody_registered_leave_no_trace(recorder: Recorder, history: History, clock: FakeClock) -> None:
    recorder.see(robot(clock.mono_s(), robot_id="stranger"))
    recorder.see(robot(clock.mono_s(), farm_id="elsewhere"))
    recorder.see_event(RobotEvent("stranger", "event-0001", "safety", "stop", "", at_utc=clock.utc()))
    assert recorder.flush(WAIT_S)
    assert history.events() == []
    assert history.track("weeder-01", clock.utc() - timedelta(1), clock.utc() + timedelta(1)) == []


def test_values_that_are_no_numbers_are_kept_as_missing(recorder: Recorder, history: History, clock: FakeClock) -> None:
    start = clock.utc()
    recorder.see(robot(clock.mono_s(), speed_mps=math.nan, cross_track_m=None))
    assert recorder.flush(WAIT_S)
    points = history.history("weeder-01", ["speed_mps", "cross_track_m"], start, start + timedelta(1))
    assert points[0].mean == (None, None)


def test_changes_of_mode_and_state_are_events(recorder: Recorder, history: History, clock: FakeClock) -> None:
    recorder.see(robot(clock.mono_s()))
    recorder.see(robot(clock.mono_s()))
    recorder.see(robot(clock.mono_s(), path=("Mission", "Turn")))
    clock.advance(0.1)
    recorder.see(robot(clock.mono_s(), mode=Mode.PAUSED, path=("Paused",)))
    assert recorder.flush(WAIT_S)
    newest, *older = history.events("weeder-01", kinds=["mode"])
    assert (newest.name, newest.text, newest.data["before"]) == ("paused", "Paused", "auto")
    assert sorted(event.text for event in older) == ["Mission / Treat row", "Mission / Turn"]


def test_an_event_is_kept_once_and_with_the_mission_under_way(
    recorder: Recorder, history: History, clock: FakeClock
) -> None:
    recorder.see(robot(clock.mono_s()))
    event = RobotEvent("weeder-01", "event-0001", "treatment", "laser", "62 weeds", {"weeds": 62}, at_utc=clock.utc())
    for _ in range(3):
        recorder.see_event(event)
        assert recorder.flush(WAIT_S)
    (kept,) = history.events("weeder-01", kinds=["treatment"])
    assert kept == replace(event, mission_id="mission-1")


def test_who_listens_hears_events_with_their_mission_and_changes_of_mode(recorder: Recorder, clock: FakeClock) -> None:
    heard: list[RobotEvent] = []
    recorder.on_event.append(heard.append)
    recorder.see(robot(clock.mono_s()))
    recorder.see_event(RobotEvent("weeder-01", "event-0001", "treatment", "laser", "62 weeds", at_utc=clock.utc()))
    recorder.see_event(RobotEvent("nobody", "event-0001", "treatment", "laser", "62 weeds", at_utc=clock.utc()))
    recorder.see(robot(clock.mono_s(), mode=Mode.PAUSED, path=("Paused",)))
    assert [(one.kind, one.mission_id) for one in heard if one.kind == "treatment"] == [("treatment", "mission-1")]
    assert [one.name for one in heard if one.kind == "mode"] == ["auto", "paused"]


def test_a_robot_cannot_hide_anothers_event_behind_the_same_id(
    recorder: Recorder, history: History, clock: FakeClock
) -> None:
    for name in ("weeder-01", "weeder-02"):
        recorder.see_event(RobotEvent(name, "event-0001", "safety", "stop", name, at_utc=clock.utc()))
    assert recorder.flush(WAIT_S)
    assert {event.text for event in history.events()} == {"weeder-01", "weeder-02"}


def test_events_are_paged_without_gaps_or_repeats(recorder: Recorder, history: History, clock: FakeClock) -> None:
    for number in range(25):
        clock.advance(0.001 if number % 3 else 0)  # several at the same moment
        recorder.see_event(RobotEvent("weeder-01", f"event-{number:04}", "safety", "x", "", at_utc=clock.utc()))
    assert recorder.flush(WAIT_S)
    seen = page = history.events(limit=7)
    while page:
        page = history.events(limit=7, before=page[-1])
        seen = seen + page
    assert len(seen) == 25
    assert len({event.event_id for event in seen}) == 25
    assert seen == sorted(seen, key=lambda event: (event.at_utc, event.event_id), reverse=True)


def test_what_the_disk_cannot_take_is_counted(database: Database, clock: FakeClock) -> None:
    recorder = Recorder(database, FARM, clock, lambda _: True, capacity=5)
    for number in range(12):
        recorder.see(robot(clock.mono_s(), robot_id=f"robot-{number}"))
    assert recorder.health().dropped == 12 * 2 - 5
    assert not recorder.health().is_ok


def test_joints_are_recorded_once_a_second_unless_they_are_old(
    recorder: Recorder, history: History, clock: FakeClock
) -> None:
    start = clock.utc()
    for second in range(4):
        clock.advance(1.0)
        heard_s = clock.mono_s() - (10.0 if second == 3 else 0.0)
        body = Body({"slew": 0.1 * second, "broken": math.nan}, {}, {}, None, None, None, (), Stamp(heard_s, heard_s))
        recorder.see(replace(robot(clock.mono_s()), body=body))
    assert recorder.flush(WAIT_S)
    points = history.postures("weeder-01", start, clock.utc() + timedelta(seconds=1))
    assert [point.joints for point in points] == [{"slew": 0.0}, {"slew": 0.1}, {"slew": 0.2}, None]
    assert points[0].lat_deg == 52.5
    assert history.last_posture("weeder-01") == points[-1]
    assert history.last_posture("weeder-02") is None, "nothing of it is on record"


def test_the_height_of_a_robot_that_flies_is_recorded_beside_its_joints(
    recorder: Recorder, history: History, clock: FakeClock
) -> None:
    start = clock.utc()
    for second in range(3):
        clock.advance(1.0)
        stamp = Stamp(clock.mono_s(), clock.mono_s())
        body = Body({"tilt": 0.5} if second else {}, {}, {"height": 10.0 * second}, None, None, None, (), stamp)
        recorder.see(replace(robot(clock.mono_s()), body=body))
    assert recorder.flush(WAIT_S)
    points = history.postures("weeder-01", start, clock.utc() + timedelta(seconds=1))
    assert [(point.height_m, point.joints) for point in points] == [
        (0.0, None),
        (10.0, {"tilt": 0.5}),
        (20.0, {"tilt": 0.5}),
    ]

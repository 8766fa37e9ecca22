"""Missions run at the speed of the processor, as records for reports."""

from __future__ import annotations

import itertools
import time
from datetime import UTC, datetime

import pytest

from backend_clients.errors import Refused
from backend_clients.simulator.history import simulate_mission
from hmi.clock import FakeClock
from tests.backend_clients.simulator.rig import small_mission


def test_a_mission_runs_to_its_end_with_samples_and_every_event() -> None:
    samples = list(simulate_mission(small_mission(), seed=4))
    last = samples[-1].state.order
    assert last is not None
    assert (last.status, last.row, last.remaining_s) == ("done", 3, 0)
    assert last.area_done_m2 == pytest.approx(last.area_m2, rel=0.05)
    gaps = [b.t_s - a.t_s for a, b in itertools.pairwise(samples[:-1])]
    assert all(0.9 < gap < 1.15 for gap in gaps)
    events = [event for sample in samples for event in sample.events]
    assert [e.name for e in events if e.kind == "mission"] == ["Mission loaded", "Mission started", "Mission done"]
    assert len({e.event_id for e in events}) == len(events)


def test_a_sample_is_a_tuple_of_time_telemetry_state_and_events() -> None:
    t_s, telemetry, state, events = next(iter(simulate_mission(small_mission())))
    assert (t_s, state.mode) == (0.0, "auto")  # type: ignore[attr-defined]
    assert telemetry.robot == "weeder-01"  # type: ignore[attr-defined]
    assert events


def test_the_same_seed_gives_the_same_drive_and_another_seed_another() -> None:
    def drive(seed: int) -> list[tuple[float, float]]:
        return [(s.telemetry.x_m, s.telemetry.y_m) for s in simulate_mission(small_mission(rows=1), seed=seed)]

    assert drive(1) == drive(1)
    assert drive(1) != drive(2)


def test_wall_times_follow_the_clock_given() -> None:
    clock = FakeClock(datetime(2026, 4, 1, 6, tzinfo=UTC))
    samples = list(simulate_mission(small_mission(rows=1), clock=clock))
    began_ms = datetime(2026, 4, 1, 6, tzinfo=UTC).timestamp() * 1000
    assert samples[0].telemetry.wall_ms == pytest.approx(began_ms, abs=5)
    assert samples[-1].telemetry.wall_ms - began_ms == pytest.approx(samples[-1].t_s * 1000, abs=10)


def test_an_expected_time_is_near_the_true_one() -> None:
    samples = list(simulate_mission(small_mission(rows=4, length_m=40)))
    first = samples[5].state.order
    assert first is not None
    assert first.remaining_s == pytest.approx(samples[-1].t_s, rel=0.2)


def test_a_mission_that_cannot_be_driven_is_refused() -> None:
    segments = list(small_mission().segments)
    del segments[1]
    with pytest.raises(Refused, match="bad_mission"):
        list(simulate_mission(small_mission(segments=segments)))


def test_a_mission_runs_at_least_a_hundred_times_faster_than_real_time() -> None:
    mission = small_mission(rows=6, length_m=60)
    began = time.process_time()
    samples = list(simulate_mission(mission))
    assert samples[-1].t_s / (time.process_time() - began) > 100

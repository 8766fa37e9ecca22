"""Finished missions of the demo farm: simulated at speed, recorded as if they had been watched.

``record_run`` belongs in a process of its own: it is seconds of computing. Nothing is written to the audit,
for nobody commanded these runs.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from datetime import datetime
from typing import Any

import msgspec
from sqlalchemy import delete

from backend_clients.edge.messages_down import Mission
from backend_clients.edge.messages_up import Event
from backend_clients.simulator.history import Sample, simulate_mission
from hmi.clock import FakeClock
from hmi.demo.past import RunOutcome
from hmi.domain.robot import LinkHealth, Robot, Stamp
from hmi.ingest import translate
from hmi.store.database import Database
from hmi.store.recorder import Recorder
from hmi.store.tables import EventRow, SampleRow

LINK_RTT_S = 0.06
QUEUE = 60_000  # an hour of samples and events; nothing may be dropped here, for we can wait
FLUSH_EVERY = 2_000


def record_run(database_url: str, farm_id: str, document: dict[str, Any], started: datetime, seed: int) -> RunOutcome:
    """Simulate a mission as fast as possible and write its samples and events; blocks.

    Args:
        document: the mission's wire document.
        started: wall time at which it shall have begun, UTC.
        seed: of the simulation; other seeds than the live robots', so that event ids differ.

    Raises:
        StoreError: the database cannot be used.
        Refused: the simulated robot did not take the mission.
    """
    os.nice(10)  # the console and the operator come first
    mission = msgspec.convert(document, Mission)
    database = Database(database_url)
    try:
        _forget(database, farm_id, mission.mission_id)
        clock = FakeClock(started)
        recorder = Recorder(database, farm_id, clock, lambda _robot_id: True, capacity=QUEUE, linger_s=0.05)
        recorder.start()
        try:
            last = _record(recorder, farm_id, clock, simulate_mission(mission, seed, clock=clock))
        finally:
            recorder.close(30.0)
    finally:
        database.close()
    order = last.state.order
    assert order is not None  # the simulated robot took the mission, or Refused was raised
    return RunOutcome(order.status, started, clock.utc(), order.row, order.rows, order.area_done_m2, order.distance_m)


def _record(recorder: Recorder, farm_id: str, clock: FakeClock, samples: Iterator[Sample]) -> Sample:
    last: Sample | None = None
    for count, sample in enumerate(samples):
        recorder.see(_robot(sample, farm_id, clock.mono_s()))
        for event in sample.events:
            _see_event(recorder, event, clock)
        if count % FLUSH_EVERY == FLUSH_EVERY - 1:
            recorder.flush(30.0)
        last = sample
    assert last is not None  # a simulation yields at least where it ended
    return last


def _robot(sample: Sample, farm_id: str, now_s: float) -> Robot:
    stamp = Stamp(now_s, now_s)
    since_s = now_s - (sample.state.mono_ms - sample.state.path_since_ms) / 1000
    link = LinkHealth(True, now_s, None, None, sample.state.boot, LINK_RTT_S, LINK_RTT_S, True)
    return Robot(
        id=sample.state.robot,
        is_registered=True,
        name=sample.state.robot,
        farm_id=farm_id,
        link=link,
        telemetry=translate.telemetry(sample.telemetry, stamp),
        state=translate.state(sample.state, stamp, lambda _ms: since_s),
    )


def _see_event(recorder: Recorder, event: Event, clock: FakeClock) -> None:
    now_s = clock.mono_s()
    recorder.see_event(translate.event(event, Stamp(now_s, now_s), clock.utc()))


def _forget(database: Database, farm_id: str, mission_id: str) -> None:
    """Drop what an interrupted attempt left behind."""
    with database.write() as session:
        for table in (SampleRow, EventRow):
            session.execute(delete(table).filter_by(farm_id=farm_id, mission_id=mission_id))

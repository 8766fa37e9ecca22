"""History: rows a second that the recorder brings to disk, beside one commit for each row.

Prints ``history_rows_per_s``. Both ways write the same rows into the same kind of database (SQLite, WAL, every commit
flushed to disk). The recorder is fed as the console feeds it: whole robots, at the pace of 1,000 robots a second of
clock time; the figure counts from the first robot seen to the last row on disk.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hmi.clock import FakeClock
from hmi.store.database import Database
from hmi.store.farms import Farms
from hmi.store.recorder import Recorder
from hmi.store.sampling import Sampler, sample_columns
from hmi.store.tables import SampleRow
from tests.hmi.store.conftest import FARM
from tests.hmi.store.robots import robot

ROBOTS = 1000
SECONDS = 40
NAIVE_ROWS = 400
MEDIAN_OF = 3


def run() -> Iterator[dict[str, Any]]:
    """Measure both ways in turn and yield the figure."""
    ours, naive, see_us = [], [], []
    for _ in range(MEDIAN_OF):
        with tempfile.TemporaryDirectory() as folder:
            rate, cost = _recorded(Path(folder) / "ours.db")
            ours.append(rate)
            see_us.append(cost)
            naive.append(_committed_one_by_one(Path(folder) / "naive.db"))
    value, beside = sorted(ours)[MEDIAN_OF // 2], sorted(naive)[MEDIAN_OF // 2]
    yield {
        "name": "history_rows_per_s",
        "value": round(value),
        "unit": "rows/s",
        "naive": round(beside),
        "ratio": round(value / beside, 1),
        "conditions": (
            f"{ROBOTS} robots, {ROBOTS * SECONDS} samples, SQLite WAL with synchronous=FULL, median of {MEDIAN_OF}; "
            f"taking note of one robot costs the event loop {sorted(see_us)[MEDIAN_OF // 2]:.0f} us; "
            f"naive: one commit a row, {NAIVE_ROWS} rows"
        ),
    }


def _recorded(path: Path) -> tuple[float, float]:
    """Return rows a second, and microseconds a call of ``see``."""
    database, clock = _fresh(path), FakeClock()
    recorder = Recorder(database, FARM, clock, lambda _: True, capacity=ROBOTS * (SECONDS + 2))
    robots = [[robot(clock.mono_s() + second, robot_id=f"r-{n}") for n in range(ROBOTS)] for second in range(SECONDS)]
    recorder.start()
    started_s = time.perf_counter()
    for at_once in robots:
        clock.advance(1)
        for one in at_once:
            recorder.see(one)
    seen_s = time.perf_counter() - started_s
    if not recorder.flush(120) or recorder.health().dropped:
        raise RuntimeError("the recorder did not keep up")
    took_s = time.perf_counter() - started_s
    recorder.close()
    database.close()
    return ROBOTS * SECONDS / took_s, seen_s / (ROBOTS * SECONDS) * 1e6


def _committed_one_by_one(path: Path) -> float:
    database, clock = _fresh(path), FakeClock()
    sampler = Sampler(clock)
    rows = [sampler.sample(robot(clock.mono_s(), robot_id=f"r-{n}")) for n in range(NAIVE_ROWS)]
    started_s = time.perf_counter()
    for row in rows:
        assert row is not None
        with database.write() as session:
            session.add(SampleRow(**sample_columns(row)))
    took_s = time.perf_counter() - started_s
    database.close()
    return NAIVE_ROWS / took_s


def _fresh(path: Path) -> Database:
    database = Database(f"sqlite:///{path}")
    database.migrate()
    Farms(database, FakeClock()).ensure(FARM, "My farm")
    return database


if __name__ == "__main__":
    for figure in run():
        sys.stdout.write(json.dumps(figure) + "\n")

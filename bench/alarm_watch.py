"""Alarms: CPU of watching 1,000 robots with every rule, and the time until an alarm is listed in a burst.

Prints ``alarm_watch_cpu_pct`` and ``alarm_burst_ms``. Ours is the witness with the watch, which looks at a robot twice
a second; the naive way asks every rule at every telemetry message (ten a second and robot). Both get the same values
in one process, one after the other; making values and robots is not counted.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from hmi.app.witness import FleetWitness
from hmi.clock import FakeClock
from hmi.domain import robot as domain
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.conditions import Conditions
from hmi.ingest.supervision.fence import Ground
from hmi.ingest.supervision.rules import rules_of
from hmi.ingest.supervision.watch import Watch
from hmi.presenters.start_checks import MissionFacts
from hmi.store.alarms import AlarmStore
from hmi.store.fleet import FleetStore
from tests.hmi.ingest.wire import Entry

ROBOTS, RATE_HZ, SECONDS, BURST, TRIES = 1000, 10, 5, 10_000, 3
CONDITIONS = f"{ROBOTS} robots with missions, telemetry {RATE_HZ} Hz, state and safety 2 Hz, a farm edge of 200 corners"


class _Farm:
    """A fleet at work on a fake clock."""

    def __init__(self) -> None:
        self.clock = FakeClock()
        self.store = FleetStore(self.clock.mono_s)
        self.store.set_registry([Entry(f"r-{number:04d}") for number in range(ROBOTS)])
        self.store.set_broker(is_up=True)
        self.alarms = AlarmStore(self.clock, catalogue())
        ring = [(5 + 0.01 * math.cos(a / 100 * math.pi), 52 + 0.01 * math.sin(a / 100 * math.pi)) for a in range(201)]
        ground = Ground.of([[[*ring[:-1], ring[0]]]])
        facts = MissionFacts("a" * 64, "Field", 1, 0.3, 7200.0)
        types = catalogue()
        self.watch = Watch(
            self.store,
            self.clock,
            Conditions(types.__getitem__),
            lambda: rules_of(types, lambda: ground),
            lambda _mission_id: facts,
            self.alarms.apply,
        )

    def step(self, number: int) -> None:
        """Let a tenth of a second of values arrive."""
        self.clock.advance(1 / RATE_HZ)
        now_s = self.clock.mono_s()
        stamp = domain.Stamp(now_s, now_s)
        for index, robot_id in enumerate(self.store.registered_ids()):
            angle, far = index / 100, 0.004 + number * 1e-7
            pose = domain.Pose(
                52 + far * math.sin(angle), 5 + far * math.cos(angle), number * 0.04, 0, 0, 0.42, 0, stamp
            )
            battery, tool = domain.Battery(0.7, 9000.0, False), domain.ToolState("on", True, 200.0, 40.0)
            gnss = domain.Gnss("fixed", 0.014, 27, 0.8)
            self.store.put_telemetry(robot_id, domain.Telemetry(pose, gnss, battery, tool, 0.01, None))
            if (number + index) % (RATE_HZ // 2) == 0:
                self._slow(robot_id, number, stamp)

    def _slow(self, robot_id: str, number: int, stamp: domain.Stamp) -> None:
        order = domain.Order("m", 1, "a" * 64, domain.OrderStatus.RUNNING, 3, 60, 5, number * 0.04, 10_000.0,
                             3000.0 + number, 900.0, 3600.0, True)  # fmt: skip
        state = domain.RobotState(domain.Mode.AUTO, ("Mission",), stamp.source_s, 1, 0.42, order, (), None, stamp)
        self.store.put_state(robot_id, state)
        self.store.put_safety(robot_id, domain.SafetyState(False, False, False, 0.42, False, (), None, stamp))
        self.store.put_heartbeat(robot_id, boot="b", challenge="c", heard_s=stamp.source_s, wall_offset_s=0.1)


def run() -> Iterator[dict[str, Any]]:
    """Measure and yield the figures."""
    ours_pct, naive_pct = (min(_cpu_pct(way) for _ in range(TRIES)) for way in (_ours, _naive))
    yield {
        "name": "alarm_watch_cpu_pct",
        "value": round(ours_pct, 1),
        "unit": "% of a core",
        "naive": round(naive_pct, 1),
        "ratio": round(naive_pct / ours_pct, 1),
        "conditions": CONDITIONS,
    }
    yield {
        "name": "alarm_burst_ms",
        "value": round(min(_burst_ms() for _ in range(TRIES)), 1),
        "unit": "ms",
        "naive": None,
        "ratio": None,
        "conditions": f"{BURST} changed faults of {ROBOTS} robots at once until the newest is listed",
    }


def _cpu_pct(attach: Callable[[_Farm, _Meter], Callable[[], None]]) -> float:
    farm, meter = _Farm(), _Meter()
    after = attach(farm, meter)
    for number in range(RATE_HZ * (SECONDS + 1)):
        if number == RATE_HZ:  # after a second to warm up
            gc.collect()
            meter.spent_ns = 0
        farm.step(number)
        after()
        if number % RATE_HZ == 0:
            meter.measure(farm.watch.sweep)
            meter.measure(farm.alarms.pass_time)
    assert farm.alarms.all() == [], "nothing was wrong"
    return meter.spent_ns / 1e9 / SECONDS * 100


class _Meter:
    """CPU time of what is measured, without what makes the values."""

    def __init__(self) -> None:
        self.spent_ns = 0

    def measure(self, work: Callable[[], object]) -> None:
        """Run and count."""
        begun_ns = time.thread_time_ns()
        work()
        self.spent_ns += time.thread_time_ns() - begun_ns


def _see_all(farm: _Farm, robots: Iterable[domain.Robot]) -> None:
    for robot in robots:
        farm.watch.see(robot)


def _ours(farm: _Farm, meter: _Meter) -> Callable[[], None]:
    waiting: list[domain.Robot] = []
    FleetWitness(farm.store, farm.clock, lambda _robot_id: None, [waiting.append]).start()

    def look() -> None:
        farm.store.announce()
        meter.measure(lambda: _see_all(farm, waiting))
        waiting.clear()

    return look


def _naive(farm: _Farm, meter: _Meter) -> Callable[[], None]:
    def look() -> None:
        robots = farm.store.robots()
        meter.measure(lambda: _see_all(farm, robots))

    return look


def _burst_ms() -> float:
    farm = _Farm()
    FleetWitness(farm.store, farm.clock, lambda _robot_id: None, [farm.watch.see]).start()
    for number in range(RATE_HZ):
        farm.step(number)
        farm.store.announce()
    ids = farm.store.registered_ids()
    stamp = domain.Stamp(farm.clock.mono_s(), farm.clock.mono_s())
    begun_s = time.perf_counter()
    for number in range(BURST):
        fault = domain.Fault(f"f-{number % 7}", "high", f"Fault {number}.", "")
        state = domain.RobotState(domain.Mode.AUTO, (), 0.0, 1, None, None, (fault,), None, stamp)
        farm.store.put_state(ids[number % ROBOTS], state)
    farm.store.announce()
    spent_s = time.perf_counter() - begun_s
    newest = f"Fault {BURST - 1}."
    assert any(one.alarm.text == newest for one in farm.alarms.all())
    return spent_s * 1000

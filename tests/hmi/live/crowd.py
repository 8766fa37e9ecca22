"""Many robots that report: some work, some dock, some need somebody; for benches and for the stage."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from hmi.domain import robot as domain
from hmi.store.fleet import FleetStore

SIDE = 40


@dataclass(frozen=True, slots=True)
class CrowdEntry:
    """A registry row."""

    id: str
    name: str
    farm_id: str = "farm"
    http_url: str | None = None
    http_token: str | None = None
    contact_name: str | None = None
    contact_phone: str | None = None
    keep_out_m: float = 15.0


class Crowd:
    """Feeds a store; each ``step`` is one report of every robot: heartbeat, round trip, telemetry, state."""

    def __init__(self, store: FleetStore, count: int, mono_s: Callable[[], float] = time.monotonic) -> None:
        self._store, self._at, self._now_s = store, 0, mono_s
        self.ids = [f"robot-{i:04}" for i in range(count)]
        store.set_broker(is_up=True)
        store.set_registry([CrowdEntry(one, f"Robot {i:04}") for i, one in enumerate(self.ids)])

    def step(self) -> None:
        """Let every robot report."""
        self._at += 1
        now_s = self._now_s()
        stamp = domain.Stamp(now_s - 0.01, now_s)
        for i, robot_id in enumerate(self.ids):
            store = self._store
            store.put_heartbeat(robot_id, boot="boot", challenge="c", heard_s=now_s - 0.01)
            store.put_round_trip(robot_id, 0.05 + (i % 60) / 1000)
            store.put_telemetry(robot_id, self._telemetry(i, stamp))
            if (i + self._at) % 20 == 0 or self._at == 1:
                store.put_state(robot_id, self._state(i, stamp))
        self._store.announce()

    def _telemetry(self, i: int, stamp: domain.Stamp) -> domain.Telemetry:
        turn = self._at / 10 + i
        lat = 51.7845 + 0.007 * (i // SIDE) / SIDE + 1e-5 * math.sin(turn)
        lon = 4.252 + 0.014 * (i % SIDE) / SIDE + 2e-5 * math.cos(turn)
        pose = domain.Pose(lat, lon, 0.0, 0.0, turn, 0.42, 0.0, stamp)
        battery = domain.Battery(0.3 + (i % 60) / 100 - self._at * 1e-5, 9000.0, False)
        return domain.Telemetry(pose, domain.Gnss("fixed", 0.014, 20, 0.5), battery, None, 0.01, None)

    def _state(self, i: int, stamp: domain.Stamp) -> domain.RobotState:
        needs = i % 50 == 7
        row = 1 + (i + self._at // 20) % 80
        order = domain.Order(
            f"m-{i % 40}", 1, "ab" * 32, domain.OrderStatus.RUNNING, row, 84, row, 0.0, 1e5, row * 1e3, 0.0, 7e3, True
        )
        fault = (domain.Fault("rain", "medium", "Rain in 35 min", "It may pause."),) if needs else ()
        return domain.RobotState(
            domain.Mode.AUTO, ("Mission", "Treat row"), stamp.source_s, 1, 0.4, order, fault, None, stamp
        )

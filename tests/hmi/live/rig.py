"""A hub on a fake clock with robots put in by hand, and lanes without sockets."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from typing import Any

from hmi.clock import FakeClock
from hmi.domain import robot as domain
from hmi.domain.freshness import TickRing
from hmi.domain.role import Role
from hmi.live.hub import LiveHub
from hmi.live.outbox import Outbox
from hmi.security.session_info import SessionInfo
from hmi.store.fleet import FleetStore
from tests.hmi.ingest.wire import Entry


def session(name: str = "martha", role: Role = Role.OPERATOR) -> SessionInfo:
    """Return somebody signed in."""
    return SessionInfo(
        session_id=f"session-{name}",
        user_id=name,
        user_name=name.title(),
        role=role,
        device_id="tablet-3",
        device_name="Tablet 3",
        farm_id="farm",
        csrf="csrf",
        expires_utc=datetime(2030, 1, 1, tzinfo=UTC),
    )


class HubRig:
    """Store, ticks and hub on one fake clock."""

    def __init__(self, *registered: str) -> None:
        self.clock = FakeClock()
        self.store = FleetStore(self.clock.mono_s)
        self.store.set_registry([Entry(i) for i in registered])
        self.hub = LiveHub(self.store, TickRing("boot1", self.clock.mono_s, self.clock.utc), self.clock)

    def lane(self, *topics: str, name: str = "martha") -> Outbox:
        """Return an attached lane."""
        box = Outbox(f"session-{name}", self.clock.mono_s)
        self.hub.attach(box)
        if topics:
            self.hub.subscribe(box, list(topics))
        return box

    def take(self, box: Outbox) -> list[dict[str, Any]]:
        """Return what a lane would send now, without binary frames."""
        return [json.loads(f) for f in box.take(self.hub.snapshot) if isinstance(f, str)]

    def move(self, robot_id: str, speed_mps: float = 0.42, lat_deg: float = 52.0) -> None:
        """Let telemetry of a robot arrive."""
        self.store.admit(robot_id)
        now_s = self.clock.mono_s()
        pose = domain.Pose(lat_deg, 5.0, 0.0, 0.0, 0.0, speed_mps, 0.0, domain.Stamp(now_s, now_s))
        self.store.put_telemetry(robot_id, domain.Telemetry(pose, None, None, None, None, None))
        self.store.announce()

    def pause(self, robot_id: str) -> None:
        """Let a robot report that it is paused."""
        now_s = self.clock.mono_s()
        stamp = domain.Stamp(now_s, now_s)
        state = domain.RobotState(domain.Mode.PAUSED, ("Paused",), now_s, 0, None, None, (), None, stamp)
        self.store.put_state(robot_id, state)
        self.store.announce()

    def heartbeat(self, robot_id: str, rtt_s: float = 0.08) -> None:
        """Let a robot be heard."""
        self.store.admit(robot_id)
        self.store.put_heartbeat(robot_id, boot="boot1", challenge="c", heard_s=self.clock.mono_s())
        self.store.put_round_trip(robot_id, rtt_s)
        self.store.announce()

    def take_all(self, box: Outbox) -> None:
        """Empty a lane."""
        box.take(self.hub.snapshot)

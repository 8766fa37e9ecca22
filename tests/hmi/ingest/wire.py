"""Messages as an honest robot sends them, and a broker connection that tests hold in their hands."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from backend_clients.edge import machine
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import decode_body, encode
from backend_clients.edge.mqtt import LinkState, OnLink, OnMessage
from backend_clients.edge.topics import Up, parse, topic
from hmi.clock import FakeClock
from hmi.ingest.coordinator import EdgeCoordinator
from hmi.store.fleet import FleetStore
from tests.backend_clients.edge import machine_messages

BOOT = "boot-aaaa"


@dataclass
class Entry:
    """A registry entry."""

    id: str
    farm_id: str = "farm"
    name: str = "Weeder 01"
    http_url: str | None = None
    http_token: str | None = None
    contact_name: str | None = "Jonas Weber"
    contact_phone: str | None = "+49 170 000"
    keep_out_m: float = 15.0


@dataclass
class FakeLink:
    """A broker connection: what is published is kept, what robots say is posted by the test."""

    on_message: OnMessage
    on_link: OnLink
    on_fault: Callable[[Exception], None]
    is_up: bool = True
    is_alive: bool = True
    starts: int = 0
    sent: list[tuple[str, bytes]] = field(default_factory=list)

    def start(self) -> None:
        """Come up at once."""
        self.starts += 1
        self.is_alive = True
        self.on_link(LinkState.UP, "mqtt://test")

    def stop(self) -> None:
        """Go down."""
        self.is_alive = False

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """Keep it, or refuse it while down."""
        if self.is_up:
            self.sent.append((topic, payload))
        return self.is_up


@dataclass
class FakeWireRobot:
    """Makes an honest robot's messages on its own monotonic clock."""

    id: str
    clock: FakeClock
    boot: str = BOOT
    booted_s: float = 0.0
    seq: int = 0

    def head(self, **values: Any) -> dict[str, Any]:
        """Return the header of the next message."""
        self.seq += 1
        mono_ms = round((self.clock.mono_s() - self.booted_s) * 1000)
        return {"robot": self.id, "boot": self.boot, "seq": self.seq, "mono_ms": mono_ms, "wall_ms": 0, **values}

    def heartbeat(self, **values: Any) -> up.Heartbeat:
        """Return a heartbeat."""
        return up.Heartbeat(**self.head(**{"challenge": f"challenge-{self.seq}", **values}))

    def telemetry(self, **values: Any) -> up.Telemetry:
        """Return telemetry with everything in it."""
        body: dict[str, Any] = {
            "lat_deg": 52.0,
            "lon_deg": 5.0,
            "x_m": 1.0,
            "y_m": 2.0,
            "theta_rad": 0.0,
            "speed_mps": 0.42,
            "gnss": up.Gnss(fix="fixed", accuracy_m=0.014, satellites=27, correction_age_s=0.8),
            "battery": up.Battery(soc=0.68, remaining_s=18600.0),
            "tool": up.ToolState(state="on", rate_per_min=212.0, temperature_c=41.0),
            "cross_track_m": 0.009,
        }
        return up.Telemetry(**self.head(**{**body, **values}))

    def state(self, **values: Any) -> up.State:
        """Return an operating state without a mission."""
        body: dict[str, Any] = {"mode": "idle", "path": ["Idle"], "path_since_ms": 0}
        return up.State(**self.head(**{**body, **values}))

    def safety(self, **values: Any) -> up.Safety:
        """Return a safety state at standstill."""
        body: dict[str, Any] = {
            "hardware_stop": False,
            "latched": False,
            "standstill": True,
            "speed_mps": 0.0,
            "tool_off": True,
        }
        return up.Safety(**self.head(**{**body, **values}))

    def presence(self, **values: Any) -> up.Presence:
        """Return presence."""
        return up.Presence(**self.head(**{"online": True, **values}))

    def factsheet(self, **values: Any) -> up.Factsheet:
        """Return a weeder's factsheet."""
        body: dict[str, Any] = {
            "family": "weeder",
            "name": "Weeder",
            "model": "LW-2",
            "software": "1.0",
            "datum": up.Datum(lat_deg=52.0, lon_deg=5.0),
            "dimensions": up.Dimensions(length_m=2.6, width_m=1.8, height_m=1.5, base_to_front_m=1.4),
            "limits": up.Limits(
                max_speed_mps=1.67, max_accel_mps2=0.6, decel_mps2=1.2, max_yaw_rate_radps=0.8, can_pivot=True
            ),
            "tool": up.Tool(kind="laser", label="Laser", width_m=1.5),
            "battery": up.BatteryPack(capacity_wh=8000.0, charge_w=2000.0),
            "behaviour": up.Behaviour(stop_effect="laser off, tracks brake"),
        }
        return up.Factsheet(**self.head(**{**body, **values}))

    def node(self, **values: Any) -> up.Node:
        """Return the life of one software node."""
        return up.Node(**self.head(**{"name": "planner", "state": "started", **values}))

    def event(self, **values: Any) -> up.Event:
        """Return an event."""
        body = {"event_id": f"event-{self.seq:06d}", "kind": "state_entered", "name": "Treat row"}
        return up.Event(**self.head(**{**body, **values}))

    def body(self, **values: Any) -> machine.Body:
        """Return joints and gauges."""
        return machine_messages.body(**self.head(**values))

    def worksite(self, **values: Any) -> machine.Worksite:
        """Return where it works."""
        return machine_messages.worksite(**self.head(**values))

    def detections(self, **values: Any) -> machine.Detections:
        """Return what was found in a picture."""
        return machine_messages.detections(**self.head(**values))

    def ack(self, **values: Any) -> up.Ack:
        """Return an acknowledgement of a command."""
        return up.Ack(**self.head(**{"kind": "command", "ref": "command-1", "outcome": "accepted", **values}))


KINDS: dict[type[up.Header], Up] = {
    up.Heartbeat: Up.HEARTBEAT,
    up.Telemetry: Up.TELEMETRY,
    up.State: Up.STATE,
    up.Safety: Up.SAFETY,
    up.Presence: Up.PRESENCE,
    up.Factsheet: Up.FACTSHEET,
    up.Node: Up.NODE,
    up.Event: Up.EVENT,
    up.Ack: Up.ACK,
    machine.Body: Up.BODY,
    machine.Worksite: Up.WORKSITE,
    machine.Scan: Up.SCAN,
    machine.Detections: Up.DETECTIONS,
}


class Rig:
    """A coordinator with everything around it faked."""

    def __init__(self, *registered: str, fifo_limit: int = 1000) -> None:
        self.clock = FakeClock()
        self.store = FleetStore(self.clock.mono_s, "farm")
        self.store.set_registry([Entry(i) for i in registered])
        self.edge = EdgeCoordinator(self._make, self.store, self.clock, fifo_limit=fifo_limit)
        self.link: FakeLink

    def _make(self, on_message: OnMessage, on_link: OnLink, on_fault: Callable[[Exception], None]) -> FakeLink:
        self.link = FakeLink(on_message, on_link, on_fault)
        return self.link

    async def __aenter__(self) -> Rig:
        await self.edge.start()
        await asyncio.sleep(0)  # the link's "up" reaches the loop
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.edge.stop()

    def say(self, message: up.Header, *, is_retained: bool = False) -> None:
        """Let a robot's message arrive and be applied."""
        self.post(message, is_retained=is_retained)
        self.edge.drain()

    def post(self, message: up.Header, *, is_retained: bool = False) -> None:
        """Let a robot's message arrive."""
        self.link.on_message(topic(message.robot, KINDS[type(message)]), encode(message), is_retained)

    def robot(self, robot_id: str = "weeder-01") -> FakeWireRobot:
        """Return a robot that booted 100 s ago."""
        return FakeWireRobot(robot_id, self.clock, booted_s=self.clock.mono_s() - 100)

    def published(self) -> list[Any]:
        """Return what was sent down, decoded."""
        return [decode_body(parse(t), p) for t, p in self.link.sent]

"""One simulated station on a clock of its own, with what it sent."""

from __future__ import annotations

import json
from datetime import timedelta
from functools import cache
from typing import Any

import msgspec

from backend_clients.field import messages as m
from backend_clients.field.codec import Message, decode
from backend_clients.field.topics import Down, Up, topic
from backend_clients.simulator.field.session import StationSession
from backend_clients.simulator.field.soil import Ground
from backend_clients.simulator.field.station import StationConfig
from backend_clients.simulator.field.weather import Weather
from hmi.clock import FakeClock

LAT_DEG, LON_DEG = 51.786, 4.261


class Rig:
    """A station; ``sent`` is what went out, in its order."""

    def __init__(self, kind: m.Kind = "weather", *, seed: int = 1, speed: float = 1.0) -> None:
        self.clock = FakeClock()
        self.config = StationConfig(f"{kind}-01", f"{kind.capitalize()} 1", kind, LAT_DEG, LON_DEG, "polder-17")
        self.sent: list[tuple[Up, Message | bytes, bool]] = []
        self.is_up = True
        self.shots = 0
        weather = Weather(seed, LAT_DEG, LON_DEG)
        ground = _ground(weather, self.clock.utc().timestamp())
        self.station = StationSession(
            self.config, weather, ground, self.clock, self._send, self._shoot, speed=speed
        )  # fmt: skip

    def run(self, seconds: float) -> None:
        """Let time go on as the yard does: to whatever is due next."""
        until_s = self.clock.mono_s() + seconds
        while (due_s := self.station.due_s) <= until_s:
            self.clock.advance(max(due_s - self.clock.mono_s(), 0.01))
            self.station.tick()
        self.clock.advance(max(until_s - self.clock.mono_s(), 0.0))
        self.station.tick()

    def data(self) -> list[m.Data]:
        """Return the messages with data, as they went out."""
        return [message for _, message, _ in self.sent if isinstance(message, m.Data)]

    def acks(self) -> list[m.Ack]:
        """Return the answers."""
        return [message for _, message, _ in self.sent if isinstance(message, m.Ack)]

    def value(self, quantity: str, depth_m: float | None = None) -> float:
        """Return a value of the newest data."""
        depth = msgspec.UNSET if depth_m is None else depth_m
        return next(v.value for v in self.data()[-1].values if (v.quantity, v.depth_m) == (quantity, depth))

    def notice(self, ref: str = "notice-01", *, for_s: float = 300.0, is_treating: bool = True, **more: Any) -> m.Ack:
        """Send a notice made now and return the answer."""
        now = self.clock.utc()
        fields = {
            "station": self.config.id,
            "id": ref,
            "utc": now,
            "is_treating": is_treating,
            "robots": ["weeder-01"],
            "parcel": "polder-17",
            "until_utc": now + timedelta(seconds=for_s),
        }
        return self.hear(Down.NOTICE, fields | more)

    def trigger(self, ref: str = "trigger-1", *, age_s: float = 0.0, ttl_s: float = 5.0, **more: Any) -> m.Ack:
        """Send a trigger that was made ``age_s`` ago and return the answer."""
        made = self.clock.utc() - timedelta(seconds=age_s)
        return self.hear(Down.TRIGGER, {"station": self.config.id, "id": ref, "utc": made, "ttl_s": ttl_s}, **more)

    def hear(self, kind: Down, fields: dict[str, Any], *, is_retained: bool = False) -> m.Ack:
        """Let any JSON arrive and return the newest answer."""
        many = len(self.acks())
        self.station.hear(kind, msgspec.json.encode(fields), is_retained=is_retained)
        assert len(self.acks()) == many + 1, "no answer"
        return self.acks()[-1]

    def _send(self, kind: Up, payload: bytes, qos: int, is_retained: bool) -> bool:
        if not self.is_up:
            return False
        assert kind is Up.FRAME or "NaN" not in json.dumps(json.loads(payload))
        assert qos == (0 if kind is Up.FRAME else 1)
        self.sent.append((kind, decode(topic(self.config.id, kind), payload)[1], is_retained))
        return True

    def _shoot(self) -> None:
        self.shots += 1
        self.station.show(b"\xff\xd8\xff picture")


@cache
def _ground(weather: Weather, at_s: float) -> Ground:
    return Ground(weather, at_s)  # the months before are reckoned once for all rigs

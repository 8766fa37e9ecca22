"""One simulated station: when it measures and takes pictures, what it says, what it does with what it hears."""

from __future__ import annotations

import secrets
from collections import deque
from collections.abc import Callable
from datetime import datetime, timedelta

import msgspec

from backend_clients.errors import WireError
from backend_clients.field import messages as m
from backend_clients.field.codec import Message, decode_body, encode
from backend_clients.field.topics import Address, Down, Up
from backend_clients.simulator.field.faults import (
    ClockSkew,
    Duplicates,
    Fault,
    Faults,
    LowBattery,
    OutOfOrder,
    Silence,
)
from backend_clients.simulator.field.sequence import Sequence
from backend_clients.simulator.field.soil import Ground
from backend_clients.simulator.field.station import Probe, StationConfig, battery, reading
from backend_clients.simulator.field.treatment import Answer, Shutter, Treatment
from backend_clients.simulator.field.weather import Weather
from hmi.clock import Clock

BUSY_SHARE = 1 / 6  # of the period, while treatment is under way
SHORTEST_PERIOD_S = 1.0
KEPT_OFFLINE = 288  # two days of a soil probe
FIRST_S = 10.0  # without a connection by then, the first values are kept
FIRST_PICTURE_S = 45.0  # whoever starts a demo looks at other things first

Send = Callable[[Up, bytes, int, bool], bool]
"""Publishes kind, payload, QoS, retained; says whether it was handed to a live connection."""


class StationSession:
    """Lives on one loop; ``tick`` when ``due_s`` has come, ``hear`` for what arrives.

    Args:
        shoot: has a picture taken; ``show`` is called with it later.
        speed: the weather goes this many times faster than the clock.
    """

    def __init__(
        self, config: StationConfig, weather: Weather, ground: Ground, clock: Clock, send: Send,
        shoot: Callable[[], None], *, speed: float = 1.0,
    ) -> None:  # fmt: skip
        self.config, self.faults = config, Faults()
        self._weather, self._clock, self._send, self._shoot = weather, clock, send, shoot
        self._speed = speed
        self._begin_s, self._begin_wall_s = clock.mono_s(), clock.utc().timestamp()
        self._probe = Probe(config, weather, ground)
        self._boot, self._seq = secrets.token_hex(8), 0
        self._due_s = self._begin_s + (FIRST_PICTURE_S if config.kind == "camera" else FIRST_S)
        self._treatment, self._shutter, self._sequence = Treatment(), Shutter(), Sequence()
        self._notice: m.Notice | None = None
        self._kept: deque[bytes] = deque(maxlen=KEPT_OFFLINE)
        self.unreadable = 0

    @property
    def due_s(self) -> float:
        """When it has something to do next, on the monotonic clock."""
        ends_s = self._treatment.ends_s
        return self._due_s if ends_s is None else min(self._due_s, ends_s)

    @property
    def period_s(self) -> float:
        """How long from one message with data to the next, when nothing is going on."""
        return max(self.config.period_s / self._speed, SHORTEST_PERIOD_S)

    def greet(self) -> None:
        """Say who it is, what it kept while there was no connection, and what it measures now."""
        if self._is_silent:
            return
        self._say(Up.ABOUT, self.config.about(self.period_s), is_retained=True)
        while self._kept and self._send(Up.DATA, self._kept[0], 1, False):
            self._kept.popleft()
        self._measure()
        if self.config.kind != "camera":  # the hour of its pictures stays
            self._plan()

    def tick(self) -> None:
        """Do what is due."""
        self._follow_treatment()
        if self._clock.mono_s() >= self._due_s:
            if self.config.kind == "camera":
                self._picture()
            self._measure()
            self._plan()

    def hear(self, kind: Down, payload: bytes, *, is_retained: bool) -> None:
        """Take what came down; what cannot be trusted is counted."""
        if self._is_silent or not payload:
            return  # an empty one: the notice was taken away
        try:
            order = decode_body(Address(self.config.id, kind), payload)
        except WireError:
            self.unreadable += 1
            return
        if isinstance(order, m.Notice):
            self._answer(order.id, self._treatment.hear(order, self._utc(), self._clock.mono_s()))
            self._follow_treatment()
        elif isinstance(order, m.Trigger):
            self._triggered(order, is_retained=is_retained)

    def show(self, jpeg: bytes) -> None:
        """Send the picture that was taken."""
        if not self._is_silent:
            self._send(Up.FRAME, jpeg, 0, False)

    def set_fault(self, fault: Fault) -> None:
        """Switch a fault on."""
        self.faults.set(fault, self._clock.mono_s())

    def clear_fault(self, name: str | None = None) -> None:
        """Switch one fault, or all, off; one that was silent is heard again at once."""
        was_silent = self._is_silent
        self.faults.clear(name)
        if was_silent and not self._is_silent:
            self.greet()

    # ---- up -----------------------------------------------------------------------------------------

    def _measure(self) -> None:
        now_s = self._clock.mono_s()
        obeyed = self._treatment.now(self._utc(), now_s)
        at_s = self._begin_wall_s + (now_s - self._begin_s) * self._speed
        low = self.faults.of(LowBattery)
        data = m.Data(
            station=self.config.id,
            boot=self._boot,
            seq=self._seq,
            utc=self._utc(),
            mono_ms=round((now_s - self._begin_s) * 1000),
            values=[reading(one) for one in self.faults.applied(self._probe.read(at_s), now_s)],
            battery=low.level if low is not None else battery(self.config, self._weather, at_s),
            notice=obeyed.id if obeyed is not None else msgspec.UNSET,
        )
        self._seq += 1
        if not self._is_silent:
            self._say_data(encode(data))

    def _plan(self) -> None:
        """Set when the next values, or the next picture, are due."""
        now_s = self._clock.mono_s()
        is_busy = self.config.kind != "camera" and self._treatment.now(self._utc(), now_s) is not None
        self._due_s = now_s + max(self.period_s * (BUSY_SHARE if is_busy else 1.0), SHORTEST_PERIOD_S)

    def _say_data(self, payload: bytes) -> None:
        twice = self.faults.of(Duplicates)
        copies = 1 + (twice.copies if twice is not None else 0)
        for one in self._sequence.through(payload, is_mixed=self.faults.of(OutOfOrder) is not None):
            for _ in range(copies):
                if not self._send(Up.DATA, one, 1, False):
                    self._kept.append(one)
                    break

    def _say(self, kind: Up, message: Message, *, is_retained: bool = False) -> None:
        if not self._is_silent:
            self._send(kind, encode(message), 1, is_retained)

    def _answer(self, order_id: str, answer: Answer) -> None:
        outcome, text = answer
        self._say(Up.ACK, m.Ack(station=self.config.id, id=order_id, outcome=outcome, text=text))

    # ---- treatment and pictures ----------------------------------------------------------------------

    def _follow_treatment(self) -> None:
        """Notice that treatment began or is over."""
        before, now = self._notice, self._treatment.now(self._utc(), self._clock.mono_s())
        self._notice = now
        if (before is None) == (now is None):
            return
        if self.config.kind == "camera":
            self._picture()
        else:
            self._due_s = self._clock.mono_s()  # now, and from now on at the other pace

    def _picture(self) -> None:
        if not self._is_silent and not self._shutter.refusal(self._utc(), self._clock.mono_s()):
            self._shutter.take(self._utc(), self._clock.mono_s())
            self._shoot()

    def _triggered(self, order: m.Trigger, *, is_retained: bool) -> None:
        if self.config.kind != "camera":
            self._answer(order.id, ("rejected", f"{self.config.name} has no camera."))
            return
        now_s = self._clock.mono_s()
        answer, is_new = self._shutter.trigger(order, self._utc(), now_s, is_retained=is_retained)
        self._answer(order.id, answer)
        if is_new:
            self._shoot()

    @property
    def _is_silent(self) -> bool:
        return self.faults.of(Silence) is not None

    def _utc(self) -> datetime:
        """Return what its own clock shows."""
        skew = self.faults.of(ClockSkew)
        return self._clock.utc() + timedelta(seconds=skew.offset_s if skew is not None else 0.0)

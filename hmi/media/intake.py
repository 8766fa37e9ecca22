"""What robots said last, as it came: decoded only when somebody looks.

A message that cannot be read does not take away what was said before: that stays, and gets old.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TypeVar

from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import decode_body
from backend_clients.edge.topics import Address, Up, every_robot, parse
from backend_clients.errors import WireError
from hmi.clock import Clock
from hmi.domain.freshness import ClockMap

KINDS = (Up.FACTSHEET, Up.TELEMETRY, Up.STATE, Up.BODY, Up.WORKSITE, Up.SCAN)
SUBSCRIPTIONS = [(every_robot(kind), 1 if kind in (Up.FACTSHEET, Up.WORKSITE) else 0) for kind in KINDS]
MOST_STRANGERS = 500  # on the broker; they must not fill the memory
T = TypeVar("T", bound=up.Header)


@dataclass(slots=True)
class Heard:
    """One message: decoded the first time it is asked for. ``source_s`` is on this process's monotonic clock.

    ``before`` is the one that was read last, until this one is.
    """

    payload: bytes
    arrived_s: float
    is_retained: bool
    before: Heard | None = None
    message: up.Header | None = None
    source_s: float = 0.0
    is_broken: bool = False


@dataclass(slots=True)
class _Robot:
    heard: dict[Up, Heard] = field(default_factory=dict)
    clock: ClockMap = field(default_factory=ClockMap)


class Intake:
    """The newest message of each kind of each robot; ``take`` is for the network thread, the rest for one other."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._robots: dict[str, _Robot] = {}
        self._own: frozenset[str] = frozenset()
        self._strangers = 0
        self._lock = threading.Lock()
        self.messages = 0

    def take(self, topic: str, payload: bytes, is_retained: bool) -> None:
        """Keep a message; whatever it is, it costs next to nothing here."""
        address = parse(topic)
        if not isinstance(address.kind, Up) or address.kind not in KINDS:
            return
        now_s = self._clock.mono_s()
        self.messages += 1
        with self._lock:
            robot = self._robots.get(address.robot)
            if robot is None:
                is_stranger = address.robot not in self._own
                if is_stranger and self._strangers >= MOST_STRANGERS:
                    return
                self._strangers += is_stranger
                robot = self._robots[address.robot] = _Robot()
            robot.heard[address.kind] = Heard(payload, now_s, is_retained, _read(robot.heard.get(address.kind)))

    def own(self, robots: Iterable[str]) -> None:
        """Take note of the farm's own: they always come in."""
        with self._lock:
            self._own = frozenset(robots)
            self._strangers = len(self._robots.keys() - self._own)

    def robots(self) -> list[str]:
        """Return who was heard."""
        with self._lock:
            return list(self._robots)

    def forget(self, but: Iterable[str]) -> None:
        """Drop everybody but these."""
        kept = set(but)
        with self._lock:
            self._robots = {robot: known for robot, known in self._robots.items() if robot in kept}
            self._strangers = len(self._robots.keys() - self._own)

    def newest(self, robot_id: str, kind: Up, form: type[T]) -> tuple[T, float] | None:
        """Return the newest message of a kind that can be read and when it was true, on the own clock."""
        robot = self._robots.get(robot_id)
        heard = None if robot is None else robot.heard.get(kind)
        if robot is None or heard is None:
            return None
        if heard.message is None and not heard.is_broken:
            _decode(robot.clock, Address(robot_id, kind), heard)
        if heard.is_broken:
            heard = heard.before
        if heard is None:
            return None
        assert isinstance(heard.message, form)
        return heard.message, heard.source_s


def _read(heard: Heard | None) -> Heard | None:
    """Return the newest of a message and the one before it that was read."""
    if heard is None:
        return None
    before = heard.before  # first: the other thread forgets it as soon as this message is read
    return before if heard.message is None else heard


def _decode(clock: ClockMap, address: Address, heard: Heard) -> None:
    try:
        message = decode_body(address, heard.payload)
    except WireError:
        heard.is_broken = True
        return
    assert isinstance(message, up.Header)
    heard.source_s = _source_s(clock, heard, message)
    heard.message, heard.before = message, None


def _source_s(clock: ClockMap, heard: Heard, message: up.Header) -> float:
    if heard.is_retained:
        known = clock.source_s(message.boot, message.mono_ms)
        return heard.arrived_s if known is None else min(known, heard.arrived_s)
    return min(clock.observe(message.boot, message.mono_ms, heard.arrived_s), heard.arrived_s)

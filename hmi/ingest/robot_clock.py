"""Decides, per robot, whether a message may count and when it was true."""

from __future__ import annotations

from collections import deque

from backend_clients.edge.messages_up import Header
from backend_clients.edge.topics import Up
from hmi.domain.freshness import LOST_S, ClockMap
from hmi.domain.robot import Stamp

RETAINED_KINDS = frozenset({Up.PRESENCE, Up.FACTSHEET, Up.NODE, Up.WORKSITE})
ORDERED_KINDS = frozenset({Up.FACTSHEET, Up.HEARTBEAT, Up.TELEMETRY, Up.STATE, Up.SAFETY, Up.BODY, Up.WORKSITE})
JUMP_S = 5.0  # a frame this much newer than the fastest one of its boot is a broken clock, not a fast frame
JUMPS_BELIEVED = 3  # but a clock that says so three times running has moved
BOOTS_REMEMBERED = 8
EVENTS_REMEMBERED = 256


class Refusal(Exception):
    """A well-formed message that must not count; ``reason`` is one of the words counted in diagnostics."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class RobotClock:
    """One robot's clock, boots and order of messages.

    A message of an earlier boot is refused while the newer one is heard, so that what the broker or a radio
    held back cannot undo what the robot says now. A retained copy of live data is refused: nobody can tell its age.
    """

    def __init__(self) -> None:
        self._map = ClockMap()
        self._retired: deque[str] = deque(maxlen=BOOTS_REMEMBERED)
        self._newest: dict[Up, tuple[int, int]] = {}
        self._accepted_s: dict[Up, float] = {}
        self._events: deque[str] = deque(maxlen=EVENTS_REMEMBERED)
        self._event_ids: set[str] = set()
        self._heard_s = float("-inf")
        self._jumps = 0

    def admit(self, kind: Up, message: Header, received_s: float, is_retained: bool) -> Stamp:
        """Return when the message was true; raises ``Refusal`` if it must not count."""
        if not is_retained and kind in ORDERED_KINDS and message.boot == self._map.boot:
            return self._next(kind, message, received_s)
        if is_retained:
            if kind not in RETAINED_KINDS:
                raise Refusal("retained")
            source_s = self._map.source_s(message.boot, message.mono_ms)
            return Stamp(received_s if source_s is None else source_s, received_s)
        if kind is Up.PRESENCE or (kind is Up.EVENT and message.boot in self._retired):
            # A last will was written at connect time, and an event of the last life still belongs in the log:
            # neither tells anything about the clock.
            self._check_retired(kind, message, received_s)
            return Stamp(received_s, received_s)
        self._check_retired(kind, message, received_s)
        self._check_boot(message)
        return self._next(kind, message, received_s)

    def _next(self, kind: Up, message: Header, received_s: float) -> Stamp:
        self._check_jump(message, received_s)
        self._check_order(kind, message, received_s)
        self._heard_s = received_s
        return Stamp(min(self._map.observe(message.boot, message.mono_ms, received_s), received_s), received_s)

    def confirm(self, message: Header, received_s: float, rtt_s: float) -> Stamp:
        """Bound the age of a heartbeat by the round trip that it answers."""
        return Stamp(min(self._map.confirm(message.boot, message.mono_ms, received_s, rtt_s), received_s), received_s)

    def console_s(self, boot: str, mono_ms: int, otherwise_s: float) -> float:
        """Return a robot time on the console's clock, or ``otherwise_s`` for a boot not mapped."""
        mapped_s = self._map.source_s(boot, mono_ms)
        return otherwise_s if mapped_s is None else mapped_s

    def is_repeated(self, event_id: str) -> bool:
        """Say whether this event was seen before, and remember it."""
        if event_id in self._event_ids:
            return True
        if len(self._events) == EVENTS_REMEMBERED:
            self._event_ids.discard(self._events[0])
        self._events.append(event_id)
        self._event_ids.add(event_id)
        return False

    def _check_retired(self, kind: Up, message: Header, received_s: float) -> None:
        if message.boot == self._map.boot or message.boot not in self._retired or kind is Up.EVENT:
            return
        if received_s - self._heard_s < LOST_S:
            raise Refusal("old_boot")
        self._retired.remove(message.boot)

    def _check_boot(self, message: Header) -> None:
        current = self._map.boot
        if current is None or message.boot == current:
            return
        self._retired.append(current)
        self._newest.clear()
        self._accepted_s.clear()
        self._jumps = 0

    def _check_jump(self, message: Header, received_s: float) -> None:
        source_s = self._map.source_s(message.boot, message.mono_ms)
        if source_s is None or source_s - received_s <= JUMP_S:
            self._jumps = 0
            return
        self._jumps += 1
        if self._jumps < JUMPS_BELIEVED:
            raise Refusal("clock_jump")
        self._newest.clear()

    def _check_order(self, kind: Up, message: Header, received_s: float) -> None:
        if kind not in ORDERED_KINDS:
            return
        at = (message.mono_ms, message.seq)
        is_older = at <= self._newest.get(kind, (-1, -1))
        if is_older and received_s - self._accepted_s[kind] < LOST_S:
            raise Refusal("out_of_order")
        # Older than one accepted long ago: that one was wrong, and refusing for ever would blind us.
        self._newest[kind] = at
        self._accepted_s[kind] = received_s

"""What waits for one browser, in bounded memory.

Ticks and deltas are conflated: a browser that does not keep up skips to a fresh snapshot.
Events are not: a browser that cannot even take those is closed, and starts again from a snapshot.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable

from hmi.live import frames

DELTA_LIMIT = 32  # about a second of one robot; beyond it a snapshot is cheaper than the backlog
# Of hundreds of robots that are ordered or stopped at once each tells something in the same moment: many events are
# no sign of a slow browser before its writer had the time to take them.
EVENT_LIMIT, EVENT_AGE_S = 256, 2.0
EVENT_CHARS = 4_000_000  # bounds memory within that time; a thousand robots ordered at once tell a third of it
BEHIND_S = 2.0  # a browser that shows ticks this old gets no more deltas until it has caught up

Frame = str | bytes


class Outbox:
    """The sending side of one lane; filled by the hub, emptied by the lane's own writer.

    Args:
        session_id: whose lane this is.
        mono_s: the console's monotonic clock.
    """

    def __init__(self, session_id: str, mono_s: Callable[[], float]) -> None:
        self.session_id = session_id
        self.topics: tuple[str, ...] = ()
        self.is_overrun = False
        self.snapshots = 0
        self._mono_s = mono_s
        self._deltas: list[Frame] = []
        self._events: deque[str] = deque()
        self._events_chars, self._events_since_s = 0, 0.0
        self._tick: str | None = None
        self._needs_snapshot = False
        self._is_behind = False
        self._bye: tuple[str, str] | None = None
        self._ready = asyncio.Event()

    @property
    def is_ended(self) -> bool:
        """Whether ``bye`` was said."""
        return self._bye is not None

    def tick(self, text: str) -> None:
        """Replace the tick that waits."""
        self._tick = text
        self._ready.set()

    def delta(self, frame: Frame) -> None:
        """Queue a delta, or note that only a snapshot helps now."""
        if self._needs_snapshot:
            return
        if self._is_behind or len(self._deltas) >= DELTA_LIMIT:
            self.wants_snapshot()
            return
        self._deltas.append(frame)
        self._ready.set()

    def event(self, text: str) -> None:
        """Queue an event; too many that wait too long, or more than memory has room for, end the lane."""
        if not self._events:
            self._events_since_s = self._mono_s()
        is_late = len(self._events) >= EVENT_LIMIT and self._mono_s() - self._events_since_s > EVENT_AGE_S
        if is_late or self._events_chars + len(text) > EVENT_CHARS:
            self.is_overrun = True
        if not self.is_overrun:
            self._events.append(text)
            self._events_chars += len(text)
        self._ready.set()

    def wants_snapshot(self) -> None:
        """Drop the backlog; the next thing sent is the full state."""
        self._deltas.clear()
        self._needs_snapshot = True
        self._ready.set()

    def bye(self, code: str, text: str) -> None:
        """End the lane with a reason."""
        self._bye = (code, text)
        self._ready.set()

    def seen(self, tick_ms: float) -> None:
        """Note the newest tick the browser has; what lies in buffers between us makes it old."""
        is_behind = self._mono_s() * 1000 - tick_ms > BEHIND_S * 1000
        if self._is_behind and not is_behind:
            self.wants_snapshot()
        self._is_behind = is_behind

    async def wait(self) -> None:
        """Return when something waits."""
        await self._ready.wait()

    def take(self, snapshot: Callable[[Outbox], str]) -> list[Frame]:
        """Empty the box; the snapshot is made only now, so that it is fresh."""
        self._ready.clear()
        taken: list[Frame] = list(self._events)
        self._events.clear()
        self._events_chars = 0
        if self._needs_snapshot and not self._is_behind:
            self._needs_snapshot = False
            self.snapshots += 1
            taken.append(snapshot(self))
        taken.extend(self._deltas)
        self._deltas.clear()
        if self._tick is not None:
            taken.append(self._tick)
            self._tick = None
        if self._bye is not None:
            code, text = self._bye
            taken.append(frames.encode({"k": "bye", "code": code, "text": text}))
        return taken

"""Between the thread that pulls a camera and the one that encodes: the newest picture wins."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass

MOST_UNITS = 120  # H.264 that waits; more than that and only the next key picture helps


@dataclass(frozen=True, slots=True)
class Shot:
    """A JPEG as it came; ``captured_ms`` on the machine's monotonic clock."""

    data: bytes
    captured_ms: float
    is_dated: bool


@dataclass(frozen=True, slots=True)
class Unit:
    """One H.264 access unit as it came, Annex B."""

    data: bytes
    captured_ms: float
    is_key: bool


class Inbox:
    """One JPEG or a short row of H.264, and the reason why there will be no more. Thread-safe.

    Args:
        mark: of the last picture that came without a time, before this.
    """

    def __init__(self, mark: str = "") -> None:
        self._changed = threading.Condition()
        self._shot: Shot | None = None
        self._units: deque[Unit] = deque()
        self._needs_key = False
        self._is_nudged = False
        self._end: str | None = None
        self.pictures = self.size = self.bad = self.skipped = 0
        self.why, self.mark = "", mark

    def put(self, shot: Shot) -> None:
        """A newer JPEG replaces one that nobody took yet."""
        with self._changed:
            self.pictures += 1
            self.size += len(shot.data)
            self.skipped += self._shot is not None
            self._shot = shot
            self._changed.notify()

    def put_unit(self, unit: Unit) -> None:
        """H.264 queues, for each needs the one before; a row that grows too long is dropped up to a key picture."""
        with self._changed:
            self.pictures += 1
            self.size += len(unit.data)
            if self._needs_key and not unit.is_key:
                self.skipped += 1
                return
            self._needs_key = False
            if len(self._units) >= MOST_UNITS:
                self.skipped += len(self._units)
                self._units.clear()
                if not unit.is_key:
                    self.skipped += 1
                    self._needs_key = True
                    return
            self._units.append(unit)
            self._changed.notify()

    def refuse(self, why: str) -> None:
        """Count something that came and is no picture."""
        with self._changed:
            self.bad += 1
            self.why = why

    def nudge(self) -> None:
        """Let ``take`` return now."""
        with self._changed:
            self._is_nudged = True
            self._changed.notify()

    def end(self, reason: str) -> None:
        """There will be no more."""
        with self._changed:
            self._end = self._end or reason
            self._changed.notify()

    @property
    def ended(self) -> str | None:
        """Why there will be no more."""
        return self._end

    def take(self, limit_s: float) -> Shot | Unit | None:
        """Return what is next, ``None`` after ``limit_s``, a nudge or at the end."""
        with self._changed:
            self._changed.wait_for(self._is_due, limit_s)
            self._is_nudged = False
            if self._units:
                return self._units.popleft()
            shot, self._shot = self._shot, None
            return shot

    def _is_due(self) -> bool:
        return self._shot is not None or bool(self._units) or self._is_nudged or self._end is not None

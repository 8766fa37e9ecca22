"""What happened on the robot: events for the console, and log lines for a technician."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Any, Literal

EventKind = Literal["state_entered", "state_left", "alarm_raised", "alarm_cleared", "treatment", "mission", "safety"]
MAX_PENDING = 2000  # an outage of some hours at the usual rate
MAX_LOG_LINES = 2000
SUPERVISOR = "supervisor"


@dataclass(frozen=True, slots=True)
class Happening:
    """One event not yet sent; ``mono_ms`` is when it happened on the robot."""

    event_id: str
    mono_ms: int
    kind: EventKind
    name: str
    text: str
    data: dict[str, Any] = field(default_factory=dict)


class Journal:
    """Bounded lists of events and log lines; the oldest go first.

    Args:
        boot: boot id, part of each event id, so that ids never repeat.
    """

    def __init__(self, boot: str) -> None:
        self._boot = boot
        self._count = 0
        self.pending: deque[Happening] = deque(maxlen=MAX_PENDING)
        self._lines: deque[tuple[str, str]] = deque(maxlen=MAX_LOG_LINES)

    def event(self, mono_ms: int, kind: EventKind, name: str, text: str = "", **data: Any) -> None:
        """Note one event and its log line."""
        self._count += 1
        self.pending.append(Happening(f"{self._boot}-{self._count}", mono_ms, kind, name[:80], text[:400], data))
        self.log(mono_ms, f"{kind} {name} {text}".rstrip())

    def log(self, mono_ms: int, line: str, *, node: str = SUPERVISOR) -> None:
        """Note one line of a software node."""
        self._lines.append((node, f"{mono_ms / 1000:.3f} [{node}] {line}"))

    def take(self) -> list[Happening]:
        """Return the events not yet taken, oldest first."""
        taken = list(self.pending)
        self.pending.clear()
        return taken

    def tail(self, lines: int, node: str = "") -> str:
        """Return the last ``lines`` log lines, of one node or of all."""
        kept = [line for of, line in self._lines if node in ("", of)]
        return "\n".join(kept[-lines:] if lines > 0 else [])

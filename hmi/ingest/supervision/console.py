"""The console's own parts: broker, STOP service, other processes, disk, database, records, load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Any

from hmi.domain.alarm.finding import MAX_TEXT, Finding, Findings, detail_of

SHOWN_S = 5.0
TROUBLE_S = 60.0  # a loss of messages is over when none was lost for a minute
DISK_SHARE, DISK_BYTES = 0.05, 1_000_000_000
SLOW_S = 1.0
STARTING_S, STARTING_SLOW_S = 60.0, 5.0  # parts that come later are loaded, and the records of the night looked through
LATELY = timedelta(seconds=60)


@dataclass(frozen=True, slots=True)
class Health:
    """How the console is now.

    Args:
        parts: what the process keeper says, by part; empty where no keeper runs.
        disk_free: bytes and share of the disk under the data folder, ``None`` if that cannot be told.
        writers: name -> what is wrong with keeping records, empty for nothing.
        late_s: how late the last round came.
        clock_jump_s: by how much the wall clock was set in the last round.
        audit_text: what is wrong with the chain of the audit, empty for nothing.
    """

    is_broker_up: bool
    parts: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    disk_free: tuple[int, float] | None = None
    writers: Mapping[str, str] = field(default_factory=dict)
    is_database_up: bool = True
    late_s: float = 0.0
    clock_jump_s: float = 0.0
    audit_text: str = ""
    utc: datetime | None = None


class ConsoleRules:
    """Watches the console; one for the whole process."""

    def __init__(self) -> None:
        self._restarts: dict[str, int] = {}
        self._restarted_s: dict[str, float] = {}
        self._jumped: tuple[float, float] | None = None
        self._troubles: dict[str, tuple[str, float]] = {}
        self._begun_s: float | None = None

    def trouble(self, code: str, text: str, now_s: float) -> None:
        """Note what the connection to the robots reported, such as messages that were lost."""
        self._troubles[code] = text, now_s

    def look(self, health: Health, now_s: float) -> Findings:
        """Return what holds now."""
        found = [*self._parts(health, now_s), *self._told(now_s)]
        self._begun_s = now_s if self._begun_s is None else self._begun_s
        if not health.is_broker_up:
            found.append(Finding("broker-lost", "Not connected to the MQTT broker."))
        if health.disk_free is not None and _is_full(*health.disk_free):
            free, share = health.disk_free
            found.append(Finding("disk-full", f"{free / 1e9:.1f} GB free, {100 * share:.0f} %."))
        if not health.is_database_up:
            found.append(Finding("database-down", "It does not answer."))
        found += [Finding("records-lost", f"{name}: {text}"[:MAX_TEXT], detail_of(name))
                  for name, text in health.writers.items() if text]  # fmt: skip
        if health.late_s > (STARTING_SLOW_S if now_s - self._begun_s < STARTING_S else SLOW_S):
            found.append(Finding("console-slow", f"Held up for {health.late_s:.1f} s."))
        if health.audit_text:
            found.append(Finding("audit-broken", health.audit_text))
        return (*found, *self._clock(health.clock_jump_s, now_s))

    def _parts(self, health: Health, now_s: float) -> list[Finding]:
        found = []
        for name, part in health.parts.items():
            restarts = int(part.get("restarts") or 0)
            # this console may itself be what was started again: then nothing is known of before
            before = self._restarts.get(name, restarts - 1 if _is_back_lately(part, health.utc) else restarts)
            if restarts > before:
                self._restarted_s[name] = now_s
            self._restarts[name] = restarts
            if now_s - self._restarted_s.get(name, float("-inf")) < SHOWN_S:
                found.append(Finding("part-restarted", f"{name} ended and was started again.", detail_of(name)))
            if name == "stop" and part.get("state") != "ok":
                found.append(Finding("gateway-down", f"It is {part.get('state', 'unknown')}."))
        return found

    def _told(self, now_s: float) -> list[Finding]:
        self._troubles = {code: told for code, told in self._troubles.items() if now_s - told[1] < TROUBLE_S}
        return [Finding("messages-lost", text, detail_of(code)) for code, (text, _at) in self._troubles.items()]

    def _clock(self, jump_s: float, now_s: float) -> list[Finding]:
        if abs(jump_s) > SLOW_S:
            self._jumped = jump_s, now_s
        if self._jumped is None or now_s - self._jumped[1] > SHOWN_S:
            return []
        return [Finding("clock-jumped", f"The server's clock was set by {self._jumped[0]:+.0f} s.")]


def _is_back_lately(part: Mapping[str, Any], now: datetime | None) -> bool:
    until = (part.get("last_down") or {}).get("until_utc")
    return now is not None and bool(until) and now - datetime.fromisoformat(str(until)) < LATELY


def _is_full(free: int, share: float) -> bool:
    return (free < DISK_BYTES and share < 2 * DISK_SHARE) or (share < DISK_SHARE and free < 20 * DISK_BYTES)

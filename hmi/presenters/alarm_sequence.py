"""What happened around an alarm, in order: what the robot told, what people did, what was raised."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, Protocol

from hmi.domain.alarm.journal import Line
from hmi.domain.event import RobotEvent

MOST = 60
REPEATED = timedelta(seconds=2)
_EVENT_KINDS = frozenset({"state_entered", "alarm_raised", "alarm_cleared", "mission", "safety", "mode"})


class Deed(Protocol):
    """A line of the audit."""

    @property
    def at(self) -> datetime:
        """When."""
        ...

    @property
    def actor(self) -> str:
        """Who."""
        ...

    @property
    def device(self) -> str:
        """On which tablet."""
        ...

    @property
    def kind(self) -> str:
        """What it is about."""
        ...

    @property
    def outcome(self) -> str:
        """What came of it."""
        ...

    @property
    def text(self) -> str:
        """One sentence."""
        ...


@dataclass(frozen=True, slots=True)
class _Entry:
    at: datetime
    kind: str
    text: str
    is_alarm: bool = False
    alarm_id: str = ""


def sequence(
    lines: Iterable[Line], events: Iterable[RobotEvent], deeds: Iterable[Deed], first: str
) -> list[dict[str, Any]]:
    """Return what happened, oldest first; ``first`` is the id of the first-out alarm."""
    entries = [
        *(_Entry(one.at, f"alarm_{one.what}", _said(one), True, one.alarm_id) for one in lines),
        *(_Entry(one.at_utc, one.kind, one.text or one.name) for one in events if _is_told(one)),
        *(_Entry(one.at, one.kind, _done(one)) for one in deeds if one.kind != "alarm"),
    ]
    return [_shown(one, first) for one in _once(sorted(entries, key=lambda one: one.at))][:MOST]


def _once(entries: Sequence[_Entry]) -> list[_Entry]:
    """Leave out what was just said: a state is told as an event and by the console's own watching, too."""
    kept: list[_Entry] = []
    for one in entries:
        recent = (other for other in kept[-4:] if one.at - other.at < REPEATED)
        if one.is_alarm or all(_words(one) != _words(other) for other in recent):
            kept.append(one)
    return kept


def _words(entry: _Entry) -> str:
    return entry.text.replace(" > ", " / ").casefold()


def _is_told(event: RobotEvent) -> bool:
    # what holds the innermost state is entered with it: told once
    return event.kind in _EVENT_KINDS and event.data.get("is_leaf") is not False


def _said(line: Line) -> str:
    words = {"raised": "", "returned": ": gone", "acknowledged": ": seen", "escalated": ": nobody answered"}
    by = f" by {line.by}" if line.by else ""
    return f"{line.title}{words.get(line.what, ': ' + line.what.replace('_', ' '))}{by}"


def _done(deed: Deed) -> str:
    if deed.kind == "stop" and deed.outcome == "sent":
        return ", ".join(part for part in ("STOP pressed", deed.actor, deed.device) if part)
    return deed.text or f"{deed.kind.capitalize()} {deed.outcome}, {deed.actor}"


def _shown(entry: _Entry, first: str) -> dict[str, Any]:
    return {
        "at": round(entry.at.timestamp() * 100) * 10,
        "kind": entry.kind,
        "text": entry.text,
        "is_alarm": entry.is_alarm,
        "is_first": entry.is_alarm and entry.alarm_id == first and entry.kind == "alarm_raised",
    }


__all__: Sequence[str] = ("Deed", "sequence")

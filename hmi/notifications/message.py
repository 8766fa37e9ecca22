"""What is told: one alarm, several at once, or a test."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from hmi.domain.alarm.live_alarm import What
from hmi.domain.alarm.priority import Priority

MAX_LISTED, MAX_KEPT = 50, 200
_OCCASION = {
    What.RAISED: "Alarm",
    What.ESCALATED: "Nobody answered",
    What.RETURNED: "Gone",
    What.ACKNOWLEDGED: "Seen",
}


@dataclass(frozen=True, slots=True)
class Told:
    """One step of one alarm, in words; ``responsible`` answers for the robot, empty if nobody does."""

    id: str
    what: What
    at: datetime
    priority: Priority
    source: str
    name: str
    title: str
    text: str
    steps: tuple[str, ...]
    by: str = ""
    responsible: str = ""


@dataclass(frozen=True, slots=True)
class Message:
    """What goes out at once. ``left_out`` counts what found no room any more."""

    farm: str
    items: tuple[Told, ...]
    left_out: int = 0
    is_test: bool = False

    @property
    def priority(self) -> Priority:
        """The most urgent in it."""
        return min((one.priority for one in self.items), default=Priority.LOW)

    @property
    def subject(self) -> str:
        """One line."""
        if self.is_test:
            return f"{self.farm}: test of the alarm notification"
        if len(self.items) == 1:
            one = self.items[0]
            return _line(f"{self.farm}: {_OCCASION[one.what]}, {one.title}, {one.name}, priority {int(one.priority)}")
        return _line(
            f"{self.farm}: {len(self.items) + self.left_out} alarms, most urgent priority {int(self.priority)}"
        )

    @property
    def listed(self) -> list[Told]:
        """What is told in words: the most urgent first, and so never left out for what is less."""
        return sorted(self.items, key=lambda one: one.priority)[:MAX_LISTED]

    @property
    def _unlisted(self) -> int:
        return self.left_out + max(0, len(self.items) - MAX_LISTED)

    def body(self) -> str:
        """Return the text of a mail."""
        if self.is_test:
            return "This is a test. Alarms will arrive like this.\n"
        parts = [_paragraph(one) for one in self.listed]
        if self._unlisted:
            parts.append(f"And {self._unlisted} more. Look at the Alarms screen.")
        parts.append("Acknowledging means that it was seen. It resets and moves nothing.")
        return "\n\n".join(parts) + "\n"

    def payload(self) -> bytes:
        """Return the body of a webhook."""
        listed = [_fields(one) for one in self.listed]
        content = {"v": 1, "kind": "test" if self.is_test else "alarms", "farm": self.farm, "subject": self.subject}
        return json.dumps({**content, "alarms": listed, "more": self._unlisted}, ensure_ascii=False).encode()


def _paragraph(one: Told) -> str:
    head = f"{_OCCASION[one.what]}: {one.title}, {one.name}, priority {int(one.priority)}"
    by = f" by {one.by}" if one.by else ""
    lines = [head + by, f"{one.at:%Y-%m-%d %H:%M:%S} UTC", one.text]
    if one.what in (What.RAISED, What.ESCALATED):
        lines += [f"{number}. {step}" for number, step in enumerate(one.steps, 1)]
        lines += [f"Responsible: {one.responsible}"] if one.responsible else []
    return "\n".join(line for line in lines if line)


def _fields(one: Told) -> dict[str, Any]:
    return {
        "id": one.id,
        "what": one.what.value,
        "at": one.at.isoformat(timespec="milliseconds"),
        "priority": int(one.priority),
        "source": one.source,
        "name": one.name,
        "title": one.title,
        "text": one.text,
        "steps": list(one.steps),
        "by": one.by,
        "responsible": one.responsible,
    }


def merged(messages: Sequence[Message]) -> Message:
    """Return one message of several, in their order; what finds no room is the oldest of what is least urgent."""
    items = [item for one in messages for item in one.items]
    kept = sorted(range(len(items)), key=lambda i: (items[i].priority, -i))[:MAX_KEPT]
    left_out = sum(one.left_out for one in messages) + len(items) - len(kept)
    return Message(messages[0].farm, tuple(items[i] for i in sorted(kept)), left_out)


def _line(text: str) -> str:
    return " ".join(text.split())[:180]

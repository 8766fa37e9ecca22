"""What a rule finds wrong now: raw, before delays, chattering and what people know of it."""

from __future__ import annotations

import re
from dataclasses import dataclass

from hmi.domain.alarm.priority import Priority

MAX_DETAIL, MAX_TEXT = 40, 300


@dataclass(frozen=True, slots=True)
class Finding:
    """One condition that holds at a source.

    Args:
        code: type in the catalogue.
        text: what is so now, with values.
        detail: which one of several, such as the node's name; fit for an alarm id, see ``detail_of``.
        priority, advice: what the source itself says, where the catalogue has no words for it.
        since_s: when it began, on the console's monotonic clock; ``None`` now.
    """

    code: str
    text: str = ""
    detail: str = ""
    priority: Priority | None = None
    advice: str = ""
    since_s: float | None = None


Findings = tuple[Finding, ...]
NOTHING: Findings = ()


def detail_of(text: str) -> str:
    """Return words of a robot as part of an alarm id: lower case, digits and dashes."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:MAX_DETAIL]

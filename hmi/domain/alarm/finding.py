"""What a rule finds wrong now: raw, before delays, chattering and what people know of it."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass

from hmi.domain.alarm.priority import Priority

MAX_DETAIL, MAX_TEXT = 40, 300
_STYLES = ("[a-z0-9]+(-[a-z0-9]+)*", "[a-z0-9]+(_[a-z0-9]+)*", "[A-Z0-9]+(_[A-Z0-9]+)*")
_MARK = 6  # digits that tell apart what would shorten to the same words


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


def detail_of_id(name: str) -> str:
    """Return a robot's own name of something as part of an alarm id; names of one style stay different.

    Names in one of the usual styles keep their words; others, and long ones, get a mark of their own.
    """
    words = detail_of(name)
    if len(name) <= MAX_DETAIL and any(re.fullmatch(style, name) for style in _STYLES):
        return words
    mark = hashlib.sha256(name.encode()).hexdigest()[:_MARK]
    return f"{words[: MAX_DETAIL - _MARK - 1]}-{mark}".lstrip("-")

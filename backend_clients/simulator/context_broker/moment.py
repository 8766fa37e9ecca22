"""Dates as Orion keeps them: UTC, milliseconds, a Z at the end."""

from __future__ import annotations

import re
from datetime import UTC, datetime

_FORM = re.compile(r"\d{4}-\d{2}-\d{2}(T\d{2}:\d{2}(:\d{2}(\.\d{1,6})?)?(Z|[+-]\d{2}(:?\d{2})?)?)?", re.ASCII)


def parse(text: str) -> datetime | None:
    """Return the aware time of an ISO 8601 text, ``None`` if it is none; without a zone it is UTC."""
    if not _FORM.fullmatch(text):
        return None
    try:
        found = datetime.fromisoformat(text)
        return (found if found.tzinfo else found.replace(tzinfo=UTC)).astimezone(UTC)
    except (ValueError, OverflowError):
        return None


def text_of(moment: datetime) -> str:
    """Return the text of a time as the broker writes it."""
    return moment.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")

"""A reason to wait, as it is shown and told."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum
from zoneinfo import ZoneInfo


class Who(StrEnum):
    """Who can clear a reason."""

    ITSELF = "itself"
    OPERATOR = "operator"
    PLANNER = "planner"
    ADMIN = "admin"
    SITE = "anybody at the machine"


@dataclass(frozen=True, slots=True)
class Waiting:
    """One sentence, what clears it, who can, and when it clears by itself (UTC) if that is known.

    ``outlook`` is a further sentence on what is expected, which is never known.
    """

    code: str
    text: str
    clears: str
    who: Who
    clears_at: datetime | None = None
    outlook: str = ""


def clock_text(at: datetime, now: datetime, zone: ZoneInfo, *, seconds: bool = False) -> str:
    """Return a time on the farm's clock, with the day where it is not today, and the year where that is another one.

    ``07:42``, ``Sun 22 Nov 07:42``, ``Fri 1 Jan 2027 07:42``.
    """
    local, today = at.astimezone(zone), now.astimezone(UTC).astimezone(zone).date()
    text = local.strftime("%H:%M:%S" if seconds else "%H:%M")
    if local.date() == today:
        return text
    year = "" if local.year == today.year else f"{local.year} "
    return f"{local.strftime('%a')} {local.day} {local.strftime('%b')} {year}{text}"

"""When the shift that runs now ends, on the farm's clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, time, timedelta
from zoneinfo import ZoneInfo

LEAST = timedelta(minutes=5)  # at the very end of a shift the next one is meant
WITHOUT = timedelta(hours=8)


@dataclass(frozen=True, slots=True)
class ShiftBook:
    """Times of day such as ``14:00`` when shifts end; without any, a shift is 8 hours from now."""

    ends: Sequence[str]
    zone: ZoneInfo

    def end_after(self, now: datetime) -> datetime:
        """Return the next end of a shift, 12 hours from now at most, in UTC."""
        latest = now + timedelta(hours=12)
        if not self.ends:
            return now + WITHOUT
        here = now.astimezone(self.zone)
        days = [here.date() + timedelta(days=number) for number in (0, 1)]
        found = [
            datetime.combine(day, time.fromisoformat(one), self.zone).astimezone(UTC)
            for day in days
            for one in self.ends
        ]
        return min(latest, min((one for one in found if one >= now + LEAST), default=latest))

"""Windows in which nothing starts by itself: nights, Sundays, the hour when children walk to school."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, time, timedelta
from zoneinfo import ZoneInfo

from hmi.domain.queue.repeat import local_instant

DAY_MIN = 24 * 60
MAX_WINDOWS = 64
_LOOKED_THROUGH = 2 * MAX_WINDOWS


@dataclass(frozen=True, slots=True)
class Blackout:
    """A window on the farm's clock, by the weekday on which it begins.

    Args:
        days: 0 (Monday) to 6.
        from_min, to_min: minutes after local midnight, 0 to 1439; an end at or before the beginning is
            on the day after.
        robots: whom it is about; empty means all.

    Raises:
        ValueError: no day, or a time that is none.
    """

    id: str
    farm_id: str
    name: str
    days: frozenset[int]
    from_min: int
    to_min: int
    robots: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.days or not self.days <= frozenset(range(7)):
            raise ValueError("Choose at least one day, 0 (Monday) to 6 (Sunday).")
        if not (0 <= self.from_min < DAY_MIN and 0 <= self.to_min < DAY_MIN):
            raise ValueError("A time is 00:00 to 23:59.")

    def ends(self, now: datetime, zone: ZoneInfo) -> datetime | None:
        """Return when the window that holds ``now`` ends, UTC; ``None`` outside of it."""
        today = now.astimezone(zone).date()
        for day in (today, today - timedelta(days=1)):
            if day.weekday() not in self.days:
                continue
            begins = local_instant(day, _time(self.from_min), zone)
            last = day if self.to_min > self.from_min else day + timedelta(days=1)
            ends = local_instant(last, _time(self.to_min), zone)
            if begins <= now < ends:
                return ends
        return None


def blocked_until(
    windows: Sequence[Blackout], robot_id: str, now: datetime, zone: ZoneInfo
) -> tuple[Blackout, datetime] | None:
    """Return the window that holds ``now`` for this robot and when the way is free, through windows that join it."""
    mine = [one for one in windows if not one.robots or robot_id in one.robots]
    first = next((one for one in mine if one.ends(now, zone) is not None), None)
    if first is None:
        return None
    free = now
    for _ in range(_LOOKED_THROUGH):
        ends = [end for one in mine if (end := one.ends(free, zone)) is not None]
        if not ends:
            break
        free = max(ends)
    return first, free


def _time(minutes: int) -> time:
    return time(minutes // 60, minutes % 60)

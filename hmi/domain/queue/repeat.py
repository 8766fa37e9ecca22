"""When a job comes again: a rule over calendar days, at a time of day on the farm's clock."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, date, datetime, time, timedelta
from enum import StrEnum
from zoneinfo import ZoneInfo

MAX_EVERY_DAYS = 60
WORKDAYS = frozenset(range(5))


class RepeatKind(StrEnum):
    """How days are chosen."""

    DAILY = "daily"
    WORKDAYS = "workdays"
    WEEKLY = "weekly"
    EVERY_N_DAYS = "every_n_days"


@dataclass(frozen=True, slots=True)
class Repeat:
    """A rule; the time of day is that of the first job.

    Args:
        days: weekdays 0 (Monday) to 6 for ``weekly``, else empty.
        every_days: distance of two days for ``every_n_days``, else 1.
        until: last local day on which it may come.
        at: local time of day, ``None`` that of the job itself; see ``kept``.

    Raises:
        ValueError: a weekly rule without days, or a distance out of 1 to 60.
    """

    kind: RepeatKind
    days: frozenset[int] = frozenset()
    every_days: int = 1
    until: date | None = None
    at: time | None = None

    def __post_init__(self) -> None:
        if self.kind is RepeatKind.WEEKLY and not self.days:
            raise ValueError("Choose at least one day of the week.")
        if not self.days <= frozenset(range(7)):
            raise ValueError("Days are 0 (Monday) to 6 (Sunday).")
        if not 1 <= self.every_days <= MAX_EVERY_DAYS:
            raise ValueError(f"Every 1 to {MAX_EVERY_DAYS} days.")


def kept(rule: Repeat, start: datetime, zone: ZoneInfo) -> Repeat:
    """Return the rule for the job after ``start``: its time of day stays also where a gap of the clock moves a job."""
    return rule if rule.at is not None else replace(rule, at=_time_of_day(start.astimezone(zone)))


def next_start(rule: Repeat, start: datetime, now: datetime, zone: ZoneInfo) -> datetime | None:
    """Return the next time after both ``start`` and ``now``, UTC; ``None`` when the rule has ended.

    What lies between ``start`` and ``now`` is gone: missed days never come in a burst. The local time of day stays
    through a change of the clocks; a time that does not exist that day comes an hour later by the clock.
    """
    local = start.astimezone(zone)
    day, at = local.date(), rule.at or _time_of_day(local)
    for _ in range(_most_days(start, now)):
        day += timedelta(days=1)
        if rule.until is not None and day > rule.until:
            return None
        found = local_instant(day, at, zone)
        if _is_day(rule, local.date(), day) and found > now:
            return found
    return None


def _time_of_day(local: datetime) -> time:
    return local.timetz().replace(tzinfo=None, fold=0)


def local_instant(day: date, at: time, zone: ZoneInfo) -> datetime:
    """Return the UTC instant of a local time; the first of two, and the later one in a gap."""
    return datetime.combine(day, at, tzinfo=zone).astimezone(UTC)


def _is_day(rule: Repeat, first: date, day: date) -> bool:
    match rule.kind:
        case RepeatKind.DAILY:
            return True
        case RepeatKind.WORKDAYS:
            return day.weekday() in WORKDAYS
        case RepeatKind.WEEKLY:
            return day.weekday() in rule.days
        case RepeatKind.EVERY_N_DAYS:
            return (day - first).days % rule.every_days == 0


def _most_days(start: datetime, now: datetime) -> int:
    return max(0, (now - start).days) + MAX_EVERY_DAYS + 8

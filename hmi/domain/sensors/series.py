"""Measured values over time: folded into means with their extremes, and laid into equal steps with gaps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from enum import StrEnum

ANGLES = frozenset({"wind_bearing"})
"""Quantities whose mean is that of directions: between 350 and 10 degrees lies 0, not 180."""


class Span(StrEnum):
    """How far back a chart looks."""

    DAY = "24h"
    WEEK = "7d"
    SEASON = "season"

    @property
    def length(self) -> timedelta:
        """Return how far back."""
        return {Span.DAY: timedelta(days=1), Span.WEEK: timedelta(days=7), Span.SEASON: timedelta(days=200)}[self]

    def step_s(self, period_s: float) -> int:
        """Return the width of a step that each report of a station reaches."""
        least = {Span.DAY: 600, Span.WEEK: 3600, Span.SEASON: 86_400}[self]
        return least * max(1, math.ceil(period_s / least))


@dataclass(frozen=True, slots=True)
class Point:
    """Values from ``at`` on; ``count`` of them."""

    at: datetime
    mean: float
    low: float
    high: float
    count: int = 1


def folded(quantity: str, points: Sequence[Point], at: datetime) -> Point:
    """Return several points as one; there must be at least one."""
    count = sum(one.count for one in points)
    low, high = min(one.low for one in points), max(one.high for one in points)
    if quantity not in ANGLES:
        return Point(at, sum(one.mean * one.count for one in points) / count, low, high, count)
    east = sum(math.sin(math.radians(one.mean)) * one.count for one in points)
    north = sum(math.cos(math.radians(one.mean)) * one.count for one in points)
    return Point(at, math.degrees(math.atan2(east, north)) % 360, low, high, count)


def floor_to(at: datetime, step_s: int) -> datetime:
    """Return the begin of the step that ``at`` lies in; steps count from the epoch."""
    return datetime.fromtimestamp(at.timestamp() // step_s * step_s, UTC)


def stepped(quantity: str, points: Iterable[Point], step_s: int) -> dict[datetime, Point]:
    """Return points by the begin of their step, folded."""
    groups: dict[datetime, list[Point]] = {}
    for one in points:
        groups.setdefault(floor_to(one.at, step_s), []).append(one)
    return {at: folded(quantity, group, at) for at, group in groups.items()}


def with_gaps(steps: dict[datetime, Point], step_s: int, until: datetime) -> list[tuple[datetime, Point | None]]:
    """Return every step from the first with a value to ``until``; ``None`` where nothing was measured."""
    if not steps:
        return []
    at, found = min(steps), []
    while at <= until:
        found.append((at, steps.get(at)))
        at += timedelta(seconds=step_s)
    return found

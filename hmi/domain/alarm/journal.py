"""What the journal of alarms says: its lines, and the figures counted from them."""

from __future__ import annotations

from datetime import datetime
from typing import NamedTuple


class Line(NamedTuple):
    """One step in the life of an alarm."""

    id: int
    at: datetime
    alarm_id: str
    code: str
    source: str
    name: str
    title: str
    what: str
    priority: int
    by: str
    device: str
    text: str


class Figures(NamedTuple):
    """What the journal says about a span of time; ``at`` of a bin is its beginning.

    Args:
        answers_s: how long each acknowledged alarm had waited.
        mix: raised alarms by priority.
        flood_s: how long of ``span_s`` was flood.
    """

    bins: list[tuple[datetime, int]]
    last_10min: int
    answers_s: list[int]
    mix: dict[int, int]
    top: list[tuple[str, int]]
    raised: int
    flood_s: float
    span_s: float

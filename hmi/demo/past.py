"""Which finished missions the demo farm has, and how such a run ended; ``history`` makes them."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta


@dataclass(frozen=True, slots=True)
class PastRun:
    """A mission of the catalogue that was driven ``ago`` before the first start."""

    id: str
    mission_id: str
    ago: timedelta
    seed: int


PAST_RUNS = (
    PastRun("trial-strip-run-1", "trial-strip", timedelta(days=1, hours=3), 9001),
    PastRun("trial-strip-rows-run-1", "trial-strip-rows", timedelta(days=2, hours=5), 9002),
    PastRun("site-wheat-2-run-1", "site-wheat-2-05", timedelta(days=3, hours=2), 9003),
)


@dataclass(frozen=True, slots=True)
class RunOutcome:
    """How a simulated run ended."""

    status: str
    started: datetime
    ended: datetime
    row: int
    rows: int
    area_done_m2: float
    distance_m: float

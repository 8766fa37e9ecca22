"""What stations measured in a season that was not simulated: a function of seed and time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime
from typing import NamedTuple

from backend_clients.simulator.field.soil import Ground
from backend_clients.simulator.field.station import Key, Probe, StationConfig
from backend_clients.simulator.field.sun import DAY_S
from backend_clients.simulator.field.weather import HOUR_S, Weather

RECENT_S = 48 * HOUR_S
STEP_S = 600.0
DAY_STEP_S = 2 * HOUR_S
MOST_DAYS = 150  # soil is reckoned from six months before


class Day(NamedTuple):
    """A day's values, UTC, of what was read every two hours."""

    station: str
    quantity: str
    depth_m: float | None
    day: date
    low: float
    mean: float
    high: float


class Reading(NamedTuple):
    """One value."""

    station: str
    quantity: str
    depth_m: float | None
    utc: datetime
    value: float


@dataclass(frozen=True, slots=True)
class Season:
    """Daily values, oldest first within a station and quantity, and the last 48 h each ten minutes."""

    days: list[Day]
    recent: list[Reading]


def season_of(stations: Sequence[StationConfig], seed: int, now: datetime, days: int) -> Season:
    """Return the season until ``now`` (aware), today's begun day included; cameras have no values.

    Raises:
        ValueError: ``days`` is not 1 to 150, or there is no station.
    """
    if not 1 <= days <= MOST_DAYS or not stations:
        raise ValueError(f"a season of {days} days with {len(stations)} stations: use 1 to {MOST_DAYS} days, a station")
    until_s = now.timestamp()
    weather = Weather(seed, stations[0].lat_deg, stations[0].lon_deg)
    ground = Ground(weather, until_s)
    found, recent = list[Day](), list[Reading]()
    for station in stations:
        if station.kind != "camera":
            probe = Probe(station, weather, ground)
            found += _days(station, probe, until_s, days)
            recent += _recent(station, probe, until_s)
    return Season(found, recent)


def _days(station: StationConfig, probe: Probe, until_s: float, days: int) -> list[Day]:
    first_s = (until_s // DAY_S - days + 1) * DAY_S
    kept: dict[tuple[Key, int], list[float]] = {}
    for step in range(int(first_s // DAY_STEP_S), int(until_s // DAY_STEP_S) + 1):
        for sample in probe.read(step * DAY_STEP_S):
            kept.setdefault((sample[:2], int(step * DAY_STEP_S // DAY_S)), []).append(sample.value)
    rows = [
        Day(station.id, quantity, depth_m, datetime.fromtimestamp(number * DAY_S, UTC).date(),
            min(values), _mean(quantity, values), max(values))
        for ((quantity, depth_m), number), values in kept.items()
    ]  # fmt: skip
    return sorted(rows, key=_order)


def _recent(station: StationConfig, probe: Probe, until_s: float) -> list[Reading]:
    last = int(until_s // STEP_S)
    return [
        Reading(station.id, sample.quantity, sample.depth_m, datetime.fromtimestamp(step * STEP_S, UTC), sample.value)
        for step in range(last - int(RECENT_S // STEP_S) + 1, last + 1)
        for sample in probe.read(step * STEP_S)
    ]


def _order(row: Day) -> tuple[str, float, date]:
    return row.quantity, row.depth_m or 0.0, row.day


def _mean(quantity: str, values: list[float]) -> float:
    if quantity == "wind_bearing":  # 350 and 10 degrees are north, not south
        east = sum(math.sin(math.radians(one)) for one in values)
        north = sum(math.cos(math.radians(one)) for one in values)
        return math.degrees(math.atan2(east, north)) % 360
    return sum(values) / len(values)

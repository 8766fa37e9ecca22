"""What weather is expected: a forecast is never a measurement, and too old it is none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import StrEnum

OLD = timedelta(hours=3)  # services make a new one each one to six hours; older, it is said how old
REFUSED = timedelta(hours=24)
AHEAD = timedelta(minutes=5)  # a service's clock may be this far ahead
STEADY = timedelta(hours=2)  # a lull of an hour between two gusts is no clearing
NEAR_DEG = 0.3
HOUR = timedelta(hours=1)


class Expected(StrEnum):
    """Quantities of a forecast, with the units of the wire."""

    AIR_TEMPERATURE = "air_temperature"
    """degC"""
    RAIN_RATE = "rain_rate"
    """mm/h"""
    WIND_SPEED = "wind_speed"
    """m/s"""
    WIND_GUST = "wind_gust"
    """m/s"""


class ForecastAge(StrEnum):
    """How far a forecast may be relied on."""

    FRESH = "fresh"
    OLD = "old"
    REFUSED = "refused"


@dataclass(frozen=True, slots=True)
class Hour:
    """What is expected in the hour that begins at ``utc``; ``None`` where the service says nothing."""

    utc: datetime
    air_temperature: float | None = None
    rain_rate: float | None = None
    wind_speed: float | None = None
    wind_gust: float | None = None

    def value(self, what: Expected) -> float | None:
        """Return one quantity."""
        found: float | None = getattr(self, what.value)
        return found


@dataclass(frozen=True, slots=True)
class Forecast:
    """One forecast for one place.

    Args:
        made_at: when the service made it.
        hours: in order, each an hour after the one before.
        place: longitude and latitude it is for.
        source: who made it.
    """

    made_at: datetime
    hours: tuple[Hour, ...]
    place: tuple[float, float]
    source: str = ""

    @property
    def ends_at(self) -> datetime:
        """When its last hour ends."""
        return self.hours[-1].utc + HOUR

    def is_near(self, place: tuple[float, float]) -> bool:
        """Say whether it tells anything of a place, longitude and latitude: within some 30 km."""
        east = math.remainder(self.place[0] - place[0], 360) * math.cos(math.radians(place[1]))
        return math.hypot(east, self.place[1] - place[1]) <= NEAR_DEG

    def age(self, now: datetime) -> timedelta:
        """Return how old it is; never less than nothing."""
        return max(now - self.made_at, timedelta())

    def reliance(self, now: datetime) -> ForecastAge:
        """Say how far it may be relied on; one from the future, or that is over, may not."""
        age = now - self.made_at
        if age < -AHEAD or age >= REFUSED or now >= self.ends_at:
            return ForecastAge.REFUSED
        return ForecastAge.OLD if age >= OLD else ForecastAge.FRESH


@dataclass(frozen=True, slots=True)
class Clearing:
    """When something measured over a limit is expected below it.

    Args:
        at: from when; ``None`` not before ``until``.
        until: where the forecast, or what it says of this, ends.
        age: ``None`` while the forecast is fresh.
    """

    at: datetime | None
    until: datetime
    age: timedelta | None = None


def clearing(forecast: Forecast | None, what: Expected, limit: float, now: datetime) -> Clearing | None:
    """Return when a quantity is expected to fall below a limit and stay there for two hours.

    ``None`` where nothing can be said: no forecast, too old, nothing of this quantity, or it is expected below
    already, which the measurement that is over the limit belies.
    """
    if forecast is None or forecast.reliance(now) is ForecastAge.REFUSED:
        return None
    hours = _known(forecast.hours, what, now)
    if not hours or hours[0][1] < limit:
        return None
    age = forecast.age(now) if forecast.reliance(now) is ForecastAge.OLD else None
    end = hours[-1][0] + HOUR
    for at, value in hours:
        stays = all(other < limit for other_at, other in hours if at <= other_at < at + STEADY)
        if value < limit and stays:
            return Clearing(at, end, age)
    return Clearing(None, end, age)


def _known(hours: Sequence[Hour], what: Expected, now: datetime) -> list[tuple[datetime, float]]:
    """Return the hours from now on up to the first of which nothing is said."""
    found: list[tuple[datetime, float]] = []
    for hour in hours:
        value = hour.value(what)
        if hour.utc + HOUR <= now:
            continue
        if value is None or (found and hour.utc - found[-1][0] != HOUR):
            break
        found.append((hour.utc, value))
    return found if found and found[0][0] <= now else []

"""Sunrise and sunset, computed here: a farm without Internet has daylight too.

Source: NOAA Global Monitoring Laboratory, solar calculation details (after J. Meeus, Astronomical Algorithms);
good to a minute or two between the polar circles, which the tests hold against published times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta

ZENITH_RAD = math.radians(90.833)  # half the sun's disc and the refraction at the horizon
_J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)


@dataclass(frozen=True, slots=True)
class SunDay:
    """One day at one place. ``rises`` and ``sets`` UTC, both ``None`` when the sun stays up or down."""

    rises: datetime | None
    sets: datetime | None
    is_always_up: bool = False


def sun_day(day: date, lat_deg: float, lon_deg: float) -> SunDay:
    """Return when the sun rises and sets around the solar noon of ``day``."""
    noon_min = 720.0 - 4.0 * lon_deg
    for _ in range(2):
        noon_min = 720.0 - 4.0 * lon_deg - _sun(day, noon_min)[1]
    cosine = _hour_cosine(lat_deg, _sun(day, noon_min)[0])
    if not -1.0 <= cosine <= 1.0:
        return SunDay(None, None, is_always_up=cosine < -1.0)
    return SunDay(_event(day, lat_deg, lon_deg, noon_min, -1), _event(day, lat_deg, lon_deg, noon_min, +1))


def daylight(
    now: datetime, lat_deg: float, lon_deg: float, *, after_rise: timedelta, before_set: timedelta
) -> tuple[bool, datetime | None]:
    """Say whether it is day now, and until when if not: light begins ``after_rise`` and ends ``before_set``.

    Returns:
        ``(is_day, begins)``; ``begins`` is ``None`` by day, and where the sun does not rise within the year.
    """
    # solar noon of the place's own day: the UTC date is another one far from Greenwich
    here = (now + timedelta(hours=lon_deg / 15)).date()
    for offset in range(367):
        sun = sun_day(here + timedelta(days=offset), lat_deg, lon_deg)
        if sun.is_always_up:
            return (True, None) if offset == 0 else (False, _solar_midnight(here + timedelta(days=offset), lon_deg))
        if sun.rises is None or sun.sets is None:
            continue
        begins, ends = sun.rises + after_rise, sun.sets - before_set
        if begins <= now < ends:
            return True, None
        if now < begins < ends:
            return False, begins
    return False, None


def _solar_midnight(day: date, lon_deg: float) -> datetime:
    return datetime(day.year, day.month, day.day, tzinfo=UTC) - timedelta(hours=lon_deg / 15)


def _event(day: date, lat_deg: float, lon_deg: float, noon_min: float, side: int) -> datetime:
    at_min = noon_min
    for _ in range(3):  # the sun moves on between noon and the event
        declination, equation_min = _sun(day, at_min)
        hour_rad = math.acos(max(-1.0, min(1.0, _hour_cosine(lat_deg, declination))))
        at_min = 720.0 - 4.0 * lon_deg - equation_min + side * 4.0 * math.degrees(hour_rad)
    midnight = datetime(day.year, day.month, day.day, tzinfo=UTC)
    return midnight + timedelta(minutes=at_min)


def _hour_cosine(lat_deg: float, declination: float) -> float:
    """Return the cosine of the hour angle of rise and set; below -1 the sun stays up, above 1 down."""
    lat = math.radians(max(-89.9, min(89.9, lat_deg)))
    return math.cos(ZENITH_RAD) / (math.cos(lat) * math.cos(declination)) - math.tan(lat) * math.tan(declination)


def _sun(day: date, minutes: float) -> tuple[float, float]:
    """Return declination in radians and the equation of time in minutes."""
    at = datetime(day.year, day.month, day.day, tzinfo=UTC) + timedelta(minutes=minutes)
    t = (at - _J2000).total_seconds() / 86_400 / 36_525
    mean_long = math.radians((280.46646 + t * (36_000.76983 + t * 0.0003032)) % 360)
    anomaly = math.radians(357.52911 + t * (35_999.05029 - 0.0001537 * t))
    eccentricity = 0.016708634 - t * (0.000042037 + 0.0000001267 * t)
    centre = math.radians(
        math.sin(anomaly) * (1.914602 - t * (0.004817 + 0.000014 * t))
        + math.sin(2 * anomaly) * (0.019993 - 0.000101 * t)
        + math.sin(3 * anomaly) * 0.000289
    )
    node = math.radians(125.04 - 1934.136 * t)
    long_rad = mean_long + centre - math.radians(0.00569 + 0.00478 * math.sin(node))
    tilt_deg = 23 + (26 + (21.448 - t * (46.815 + t * (0.00059 - t * 0.001813))) / 60) / 60
    tilt = math.radians(tilt_deg + 0.00256 * math.cos(node))
    declination = math.asin(math.sin(tilt) * math.sin(long_rad))
    y = math.tan(tilt / 2) ** 2
    equation = (
        y * math.sin(2 * mean_long)
        - 2 * eccentricity * math.sin(anomaly)
        + 4 * eccentricity * y * math.sin(anomaly) * math.cos(2 * mean_long)
        - 0.5 * y * y * math.sin(4 * mean_long)
        - 1.25 * eccentricity**2 * math.sin(2 * anomaly)
    )
    return declination, 4 * math.degrees(equation)

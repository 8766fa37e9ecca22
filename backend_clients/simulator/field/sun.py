"""How high the sun stands. Seconds since 1970 UTC, degrees."""

from __future__ import annotations

import math

DAY_S = 86_400.0
YEAR_S = 365.25 * DAY_S
TILT_RAD = math.radians(23.44)
SOLSTICE_S = 355.0 * DAY_S  # the winter one, from the begin of a year; within a day of it


def sin_height(at_s: float, lat_deg: float, lon_deg: float) -> float:
    """Return the sine of the sun's height, negative at night; within a degree or two."""
    fall = -TILT_RAD * math.cos(2 * math.pi * (at_s - SOLSTICE_S) / YEAR_S)
    turn = 2 * math.pi * solar_hour(at_s, lon_deg) / 24 - math.pi
    lat = math.radians(lat_deg)
    return math.sin(lat) * math.sin(fall) + math.cos(lat) * math.cos(fall) * math.cos(turn)


def noon_sin_height(at_s: float, lat_deg: float) -> float:
    """Return the sine of the sun's height at noon of that day, not below 0."""
    fall = -TILT_RAD * math.cos(2 * math.pi * (at_s - SOLSTICE_S) / YEAR_S)
    return max(math.cos(math.radians(lat_deg) - fall), 0.0)


def solar_hour(at_s: float, lon_deg: float) -> float:
    """Return the hour by the sun, 0 to 24; the equation of time (16 minutes) is left out."""
    return (at_s / 3600 + lon_deg / 15) % 24

"""The weather of one place in a temperate climate near the sea, as a function of seed and time.

Seconds since 1970 UTC. Radiation follows the sun and the clouds, temperature lags it by about three hours, relative
humidity goes against temperature, wind rises by day, showers come in some quarters of a day.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

from backend_clients.simulator.field.noise import chance, smooth
from backend_clients.simulator.field.sun import DAY_S, YEAR_S, noon_sin_height, sin_height, solar_hour

HOUR_S = 3600.0
YEAR_MEAN_C, YEAR_SWING_C = 10.6, 7.4  # De Bilt 1991-2020 within half a degree
COLDEST_S = 22 * DAY_S  # 22 January
WARMEST_HOUR = 15.0  # by the sun: three hours after the most radiation
SHOWER_CELL_S = 6 * HOUR_S
SHOWER_CHANCE = 0.24  # of a quarter of a day: with the sizes below about 850 mm a year
PA_PER_KPA = 1000.0
_SHOWERS, _LONG, _LATE, _PEAK, _AIR, _CLOUD, _CLOUD_DAY, _DEW, _WIND, _GUST, _TURN, _SPELL = range(12)


@dataclass(frozen=True, slots=True)
class Shower:
    """Rain that swells and fades: ``peak_mm_h`` in its middle."""

    start_s: float
    length_s: float
    peak_mm_h: float

    def rate_mm_h(self, at_s: float) -> float:
        """Return how hard it rains."""
        share = (at_s - self.start_s) / self.length_s
        return self.peak_mm_h * math.sin(math.pi * share) ** 2 if 0 < share < 1 else 0.0

    def sum_mm(self, from_s: float, until_s: float) -> float:
        """Return how much fell in a span."""
        a, b = (min(max((at - self.start_s) / self.length_s, 0.0), 1.0) for at in (from_s, until_s))
        whole = (b - a) / 2 - (math.sin(2 * math.pi * b) - math.sin(2 * math.pi * a)) / (4 * math.pi)
        return self.peak_mm_h * self.length_s / HOUR_S * whole


@dataclass(frozen=True, slots=True)
class Weather:
    """The weather at one place.

    Args:
        seed: the same seed is the same weather.
    """

    seed: int
    lat_deg: float
    lon_deg: float

    def showers(self, from_s: float, until_s: float) -> list[Shower]:
        """Return the showers that may touch a span; none is longer than the cell it begins in and the next."""
        first, last = int(from_s // SHOWER_CELL_S) - 1, int(until_s // SHOWER_CELL_S)
        found = (_shower_of(self.seed, cell) for cell in range(first, last + 1))
        return [one for one in found if one is not None]

    def rain_mm_h(self, at_s: float) -> float:
        """Return how hard it rains."""
        return sum(one.rate_mm_h(at_s) for one in self.showers(at_s, at_s))

    def rain_mm(self, from_s: float, until_s: float) -> float:
        """Return how much rain fell in a span."""
        return sum(one.sum_mm(from_s, until_s) for one in self.showers(from_s, until_s))

    def cloud(self, at_s: float) -> float:
        """Return the share of the sky that is covered, 0 to 1; all of it while it rains."""
        usual = 0.5 + 0.35 * self._cloud_day(at_s) + 0.3 * smooth(self.seed, _CLOUD, at_s, 2.5 * HOUR_S)
        return min(max(usual, 0.0) + self.rain_mm_h(at_s) / 1.5, 1.0)

    def radiation_w_m2(self, at_s: float) -> float:
        """Return global radiation: Haurwitz for a clear sky, Kasten and Czeplak for clouds."""
        height = sin_height(at_s, self.lat_deg, self.lon_deg)
        if height <= 0.005:
            return 0.0
        clear = 1098 * height * math.exp(-0.057 / height)
        return clear * (1 - 0.75 * self.cloud(at_s) ** 3.4)

    def temperature_c(self, at_s: float) -> float:
        """Return the temperature of the air, 2 m above the ground."""
        hour = solar_hour(at_s, self.lon_deg)
        swing = self._swing_c(at_s) * math.cos(2 * math.pi * (hour - WARMEST_HOUR) / 24)
        return self.mean_c(at_s) + swing - min(self.rain_mm_h(at_s), 3.0) * 0.5

    def mean_c(self, at_s: float) -> float:
        """Return the mean of these days: season and air mass."""
        return season_c(at_s) + 3.6 * smooth(self.seed, _AIR, at_s, 3 * DAY_S)

    def humidity(self, at_s: float) -> float:
        """Return relative humidity, 0 to 1: what the dew point of these days makes of the temperature."""
        dew_c = self.mean_c(at_s) - 0.85 * self._swing_c(at_s) - 0.7 + 0.9 * smooth(self.seed, _DEW, at_s, 8 * HOUR_S)
        usual = vapour_kpa(dew_c) / vapour_kpa(self.temperature_c(at_s))
        wet = min(self.rain_mm_h(at_s), 1.0)
        return min(max(usual + (0.96 - usual) * wet, 0.2), 1.0)

    def wind_mps(self, at_s: float) -> float:
        """Return the wind, mean of ten minutes."""
        by_day = 1.3 * math.cos(2 * math.pi * (solar_hour(at_s, self.lon_deg) - 14) / 24)
        days = 1.7 * smooth(self.seed, _WIND, at_s, 1.2 * DAY_S)
        return max(3.3 + by_day + days + 0.6 * smooth(self.seed, _WIND + 100, at_s, 1.5 * HOUR_S), 0.2)

    def gust_mps(self, at_s: float) -> float:
        """Return the strongest gust around a moment, never less than the wind."""
        return self.wind_mps(at_s) * (1.45 + 0.25 * smooth(self.seed, _GUST, at_s, 900.0)) + 0.2

    def bearing_deg(self, at_s: float) -> float:
        """Return where the wind comes from, 0 to 360; mostly the south-west."""
        days = 80 * smooth(self.seed, _TURN, at_s, 1.6 * DAY_S)
        return (235 + days + 12 * smooth(self.seed, _TURN + 100, at_s, 1200.0)) % 360

    def evaporation_mm_h(self, at_s: float) -> float:
        """Return what grass with enough water would evaporate (Makkink)."""
        celsius = self.temperature_c(at_s)
        slope = 4098 * vapour_kpa(celsius) / (celsius + 237.3) ** 2  # kPa/K
        return 0.65 * slope / (slope + 0.066) * self.radiation_w_m2(at_s) * HOUR_S / 2.45e6

    def soil_c(self, at_s: float, depth_m: float) -> float:
        """Return the temperature of the soil: waves of year, air mass and day that fade and lag with depth."""
        year, mass, day = depth_m / 2.2, depth_m / 0.3, depth_m / 0.12
        deep = YEAR_MEAN_C + 0.6 + (season_c(at_s - year * YEAR_S / (2 * math.pi)) - YEAR_MEAN_C) * math.exp(-year)
        air = 2.6 * smooth(self.seed, _AIR, at_s - 0.3 * DAY_S - mass * 0.6 * DAY_S, 3 * DAY_S) * math.exp(-mass)
        lag_h = WARMEST_HOUR + day * 24 / (2 * math.pi)
        wave = math.cos(2 * math.pi * (solar_hour(at_s, self.lon_deg) - lag_h) / 24)
        return deep + air + 0.9 * self._swing_c(at_s) * wave * math.exp(-day)

    def _swing_c(self, at_s: float) -> float:
        """Return how far a day's temperature goes from its mean: more under a high sun and few clouds."""
        clear = 1 - 0.5 * (1 + self._cloud_day(at_s))
        return 1.2 + 5.2 * noon_sin_height(at_s, self.lat_deg) * (0.3 + 0.7 * clear)

    def _cloud_day(self, at_s: float) -> float:
        return smooth(self.seed, _CLOUD_DAY, at_s, 1.5 * DAY_S)


def season_c(at_s: float) -> float:
    """Return the usual mean temperature of the date."""
    return YEAR_MEAN_C - YEAR_SWING_C * math.cos(2 * math.pi * (at_s - COLDEST_S) / YEAR_S)


@lru_cache(maxsize=512)
def _shower_of(seed: int, cell: int) -> Shower | None:
    """Return the shower that begins in a quarter of a day; wet and dry spells last a week or two."""
    wetness = 1 + smooth(seed, _SPELL, cell * SHOWER_CELL_S, 9 * DAY_S)
    if chance(seed, _SHOWERS, cell) >= SHOWER_CHANCE * wetness:
        return None
    length_s = 1200.0 + 7800.0 * chance(seed, _LONG, cell)
    start_s = (cell + chance(seed, _LATE, cell)) * SHOWER_CELL_S
    return Shower(start_s, length_s, 0.6 + 7.5 * chance(seed, _PEAK, cell) ** 2)


def vapour_kpa(celsius: float) -> float:
    """Return the pressure of saturated water vapour (Magnus)."""
    return 0.6108 * math.exp(17.27 * celsius / (celsius + 237.3))

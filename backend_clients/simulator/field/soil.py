"""Water in a column of soil: rain goes in at the top, plants take it out, what is too much seeps down.

Volume of water per volume of soil (m3/m3), metres below ground, millimetres of water, hours.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from backend_clients.simulator.field.weather import HOUR_S, Weather

DEPTHS_M = (0.10, 0.30, 0.60)
THICK_M = (0.20, 0.25, 0.35)  # of the layers around them
FILL_MM = tuple(1000 * one for one in THICK_M)  # of water that would fill a layer
ROOTS = (0.55, 0.33, 0.12)  # where plants drink
SEEP_H = (7.0, 22.0, 80.0)  # in which two thirds of what is above field capacity seep into the next layer
MONTH_S = 30 * 86_400.0
BEFORE_MONTHS = 6  # a season of half a year and its live continuation are reckoned from the same moment
EVEN_OUT_PER_H = 0.0012  # of a difference between two layers, by suction


@dataclass(frozen=True, slots=True)
class Texture:
    """A soil: driest, wilting, field capacity and full, m3/m3. The usual one is a marine clay loam."""

    residual: float = 0.08
    wilting: float = 0.14
    capacity: float = 0.31
    full: float = 0.44

    def room_for(self, water: float) -> float:
        """Return how easily plants drink, 0 to 1."""
        return min(max((water - self.wilting) / (0.6 * (self.capacity - self.wilting)), 0.0), 1.0)


@dataclass(frozen=True, slots=True)
class Column:
    """Three layers at one place; ``water`` from the top downwards."""

    texture: Texture = field(default_factory=Texture)
    water: tuple[float, float, float] = (0.27, 0.29, 0.31)

    def after(self, rain_mm: float, evaporation_mm: float, hours: float = 1.0) -> Column:
        """Return it after a span of at most some hours: rain, then roots, then seeping."""
        soil = self.texture
        water = list(self.water)
        water[0] += min(rain_mm / FILL_MM[0], soil.full - water[0])  # the rest runs off
        for layer, share in enumerate(ROOTS):
            drunk = evaporation_mm * share * soil.room_for(water[layer]) / FILL_MM[layer]
            water[layer] = max(water[layer] - drunk, soil.residual)
        for layer in (2, 1, 0):  # the lowest first: water does not pass two layers in one step
            above = max(water[layer] - soil.capacity, 0.0)
            seeped = above * min(hours / SEEP_H[layer], 1.0)
            if layer < 2:
                fits = (soil.full - water[layer + 1]) * FILL_MM[layer + 1] / FILL_MM[layer]
                seeped = min(seeped, fits)
                water[layer + 1] += seeped * FILL_MM[layer] / FILL_MM[layer + 1]
            water[layer] -= seeped
        for layer in (0, 1):
            moved_mm = (water[layer] - water[layer + 1]) * EVEN_OUT_PER_H * hours * FILL_MM[layer]
            water[layer] -= moved_mm / FILL_MM[layer]
            water[layer + 1] += moved_mm / FILL_MM[layer + 1]
        kept = tuple(min(max(one, soil.residual), soil.full) for one in water)
        return Column(soil, (kept[0], kept[1], kept[2]))


class Ground:
    """The water in the soils of one place, by the hour and straight in between; reckoned once, as far as it is asked.

    Args:
        weather: of the place.
        at_s: it begins some months before, so that nothing of its first state is left; see ``first_s``.
    """

    def __init__(self, weather: Weather, at_s: float) -> None:
        self._weather = weather
        self._first = int(first_s(at_s) // HOUR_S)
        self._forcing: list[tuple[float, float]] = []
        self._columns: dict[Texture, list[Column]] = {}

    def water(self, texture: Texture, at_s: float) -> tuple[float, float, float]:
        """Return the water in the three layers of a soil, m3/m3.

        Raises:
            ValueError: it is asked for a time before it begins.
        """
        hour = int(at_s // HOUR_S) - self._first
        if hour < 0:
            raise ValueError(f"soil is reckoned from hour {self._first}, {-hour} hours later")
        columns = self._columns.setdefault(texture, [Column(texture)])
        while len(columns) < hour + 2:
            columns.append(columns[-1].after(*self._force(len(columns) - 1)))
        low, high, share = columns[hour].water, columns[hour + 1].water, at_s % HOUR_S / HOUR_S
        return (
            low[0] + (high[0] - low[0]) * share,
            low[1] + (high[1] - low[1]) * share,
            low[2] + (high[2] - low[2]) * share,
        )

    def _force(self, hour: int) -> tuple[float, float]:
        """Return rain and evaporation of an hour, mm."""
        while len(self._forcing) <= hour:
            from_s = (self._first + len(self._forcing)) * HOUR_S
            rain_mm = self._weather.rain_mm(from_s, from_s + HOUR_S)
            self._forcing.append((rain_mm, self._weather.evaporation_mm_h(from_s + HOUR_S / 2)))
        return self._forcing[hour]


def first_s(at_s: float) -> float:
    """Return from when soil is reckoned; the same for all moments of 30 days, so that runs agree."""
    return (at_s // MONTH_S - BEFORE_MONTHS) * MONTH_S

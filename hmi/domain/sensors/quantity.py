"""The catalogue of quantities: unit on the wire, unit on a screen, what is plausible, and how they are called.

Values inside are in the unit of the wire; ``Quantity.shown`` converts for screens.
"""

from __future__ import annotations

from dataclasses import dataclass

CM_A_M = 100


@dataclass(frozen=True, slots=True)
class Quantity:
    """One thing that can be measured.

    Args:
        unit: on the wire.
        low, high: what nature can do; a value outside is a fault of the sensor, not weather.
        shown_unit, factor: on screens, value times factor.
        digits: after the point on screens.
        steady: changes within two hours below this are no trend, in the unit of the wire.
        is_slow: changes in hours, not in minutes: an older value still tells of now.
    """

    name: str
    label: str
    unit: str
    low: float
    high: float
    shown_unit: str
    factor: float = 1.0
    digits: int = 1
    steady: float = 0.5
    is_slow: bool = False

    def is_plausible(self, value: float) -> bool:
        """Say whether nature can do this; not for NaN."""
        return self.low <= value <= self.high

    def shown(self, value: float) -> float:
        """Return a value in the unit of screens, rounded."""
        return round(value * self.factor, self.digits)

    def text(self, value: float) -> str:
        """Return a value with its unit, as in a sentence."""
        space = "" if self.shown_unit == "°" else " "
        return f"{value * self.factor:.{self.digits}f}{space}{self.shown_unit}"


_ALL = (
    Quantity("air_temperature", "Air", "degC", -60, 60, "°C", steady=0.5),
    Quantity("air_humidity", "Humidity", "1", 0, 1, "%", 100, 0, 0.03),
    Quantity("rain_rate", "Rain", "mm/h", 0, 500, "mm/h", steady=0.2),
    Quantity("wind_speed", "Wind", "m/s", 0, 75, "m/s", steady=0.5),
    Quantity("wind_gust", "Gusts", "m/s", 0, 120, "m/s", steady=0.8),
    Quantity("wind_bearing", "Wind from", "deg", 0, 360, "°", digits=0, steady=360),
    Quantity("radiation", "Radiation", "W/m2", -20, 1600, "W/m²", digits=0, steady=40),
    Quantity("soil_moisture", "Soil", "m3/m3", 0, 0.7, "%", 100, 0, 0.01, is_slow=True),
    Quantity("soil_temperature", "Soil temperature", "degC", -30, 60, "°C", steady=0.3, is_slow=True),
    Quantity("co2", "CO₂", "umol/mol", 100, 50_000, "ppm", digits=0, steady=30),
    Quantity("h2o", "Water vapour", "mmol/mol", 0, 150, "mmol/mol", steady=0.5),
)
QUANTITIES: dict[str, Quantity] = {one.name: one for one in _ALL}


@dataclass(frozen=True, slots=True, order=True)
class Channel:
    """A quantity of a station, at one depth below ground in centimetres; ``None`` for what has no depth."""

    quantity: str
    depth_cm: int | None = None

    @classmethod
    def of(cls, quantity: str, depth_m: float | None) -> Channel:
        """Return the channel of a wire value."""
        return cls(quantity, None if depth_m is None else round(depth_m * CM_A_M))

    @property
    def depth_m(self) -> float | None:
        """Depth in metres."""
        return None if self.depth_cm is None else self.depth_cm / CM_A_M

    @property
    def key(self) -> str:
        """Return its name in REST, such as ``soil_moisture@0.30``."""
        return self.quantity if self.depth_cm is None else f"{self.quantity}@{self.depth_cm / CM_A_M:.2f}"

    @property
    def order(self) -> tuple[int, int]:
        """Return its place in a list: as in the catalogue, then by depth."""
        names = tuple(QUANTITIES)
        place = names.index(self.quantity) if self.quantity in QUANTITIES else len(names)
        return place, -1 if self.depth_cm is None else self.depth_cm

    @property
    def label(self) -> str:
        """Return what people call it."""
        known = QUANTITIES.get(self.quantity)
        name = known.label if known is not None else self.quantity.replace("_", " ").capitalize()
        return name if self.depth_cm is None else f"{name} {self.depth_cm} cm"

    def about(self, unit: str = "") -> Quantity:
        """Return the catalogue's entry; one that is not in it is shown as it comes, in ``unit``."""
        known = QUANTITIES.get(self.quantity)
        return known or Quantity(self.quantity, self.label, unit, -1e9, 1e9, unit, digits=2, steady=0.0)


def is_unit_right(quantity: str, unit: str) -> bool:
    """Say whether a station names the unit that the wire has for this quantity; unknown ones are free."""
    known = QUANTITIES.get(quantity)
    return known is None or known.unit == unit

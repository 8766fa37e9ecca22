"""What the simulated instruments measure: unit on the wire, range, and how finely they read."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Instrument:
    """One kind of instrument; ``span`` is a usual range of its values, by which drift is reckoned."""

    unit: str
    low: float
    high: float
    decimals: int
    span: float

    def read(self, value: float) -> float:
        """Return what it shows of a true value: rounded, and never beyond its range."""
        return round(min(max(value, self.low), self.high), self.decimals)


INSTRUMENTS = {
    "air_temperature": Instrument("degC", -40.0, 60.0, 1, 30.0),
    "air_humidity": Instrument("1", 0.0, 1.0, 2, 0.6),
    "rain_rate": Instrument("mm/h", 0.0, 200.0, 1, 8.0),
    "wind_speed": Instrument("m/s", 0.0, 60.0, 1, 6.0),
    "wind_gust": Instrument("m/s", 0.0, 75.0, 1, 9.0),
    "wind_bearing": Instrument("deg", 0.0, 359.0, 0, 180.0),
    "radiation": Instrument("W/m2", 0.0, 1600.0, 0, 800.0),
    "soil_moisture": Instrument("m3/m3", 0.0, 0.6, 4, 0.2),
    "soil_temperature": Instrument("degC", -20.0, 60.0, 2, 20.0),
    "co2": Instrument("umol/mol", 300.0, 10_000.0, 0, 1500.0),
    "h2o": Instrument("mmol/mol", 0.0, 60.0, 2, 20.0),
}

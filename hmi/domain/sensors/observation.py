"""What stands in a field and measures; SI, a value that is not known is ``None``."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum


class SensorKind(StrEnum):
    """What a station measures."""

    WEATHER = "weather"
    SOIL = "soil"
    RESPIRATION = "respiration"
    CAMERA = "camera"


@dataclass(frozen=True, slots=True)
class Station:
    """One device in a field; ``battery`` is 0..1, ``parcel_id`` the parcel it stands for."""

    id: str
    name: str
    kind: SensorKind
    lat_deg: float
    lon_deg: float
    battery: float | None = None
    parcel_id: str = ""
    heard_at: datetime | None = None


@dataclass(frozen=True, slots=True)
class WeatherReading:
    """Weather at one time; humidity 0..1, wind direction as a bearing where it comes from."""

    station_id: str
    at: datetime
    temperature_c: float | None = None
    humidity: float | None = None
    rain_mm_h: float | None = None
    wind_mps: float | None = None
    wind_bearing_deg: float | None = None
    radiation_w_m2: float | None = None
    gust_mps: float | None = None


@dataclass(frozen=True, slots=True)
class SoilReading:
    """Soil at one depth; ``moisture`` is volume of water per volume of soil, 0..1."""

    station_id: str
    at: datetime
    depth_m: float
    moisture: float | None = None
    temperature_c: float | None = None


@dataclass(frozen=True, slots=True)
class Measurement:
    """One other value, e.g. CO2 in the soil air, at a depth where it has one.

    Args:
        quantity: in words of the model.
        unit: a UN/CEFACT code.
    """

    station_id: str
    at: datetime
    quantity: str
    value: float
    unit: str
    depth_m: float | None = None

"""A simulated station: where it stands, what it measures, and what it reads at a moment."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import msgspec

from backend_clients.edge.topics import check_id
from backend_clients.field import messages as m
from backend_clients.simulator.field.instrument import INSTRUMENTS
from backend_clients.simulator.field.noise import smooth
from backend_clients.simulator.field.respiration import co2_umol_mol, h2o_mmol_mol
from backend_clients.simulator.field.soil import DEPTHS_M, Ground, Texture
from backend_clients.simulator.field.sun import DAY_S, solar_hour
from backend_clients.simulator.field.weather import Weather

PERIODS_S: dict[m.Kind, float] = {"weather": 60.0, "soil": 600.0, "respiration": 600.0, "camera": 3600.0}
MODELS: dict[m.Kind, str] = {
    "weather": "Simulated weather mast",
    "soil": "Simulated probe, three depths",
    "respiration": "Simulated soil chamber",
    "camera": "Simulated multispectral camera",
}
TEXTURES = (Texture(), Texture(0.07, 0.12, 0.28, 0.42), Texture(0.10, 0.17, 0.34, 0.46))
CHAMBER_M = 0.10  # the soil that breathes into a chamber

Key = tuple[str, float | None]
"""A quantity and its depth in metres."""


@dataclass(frozen=True, slots=True)
class StationConfig:
    """One simulated station.

    Args:
        parcel: id of the map feature it stands on, empty if none.
        number: of its kind; stations of one number have the same soil.
        bearing_deg: where a camera looks.
    """

    id: str
    name: str
    kind: m.Kind
    lat_deg: float
    lon_deg: float
    parcel: str = ""
    number: int = 1
    bearing_deg: float = 0.0

    def __post_init__(self) -> None:
        check_id(self.id)

    @property
    def period_s(self) -> float:
        """How long from one message with data to the next."""
        return PERIODS_S[self.kind]

    @property
    def texture(self) -> Texture:
        """The soil it stands on."""
        return TEXTURES[(self.number - 1) % len(TEXTURES)]

    def about(self, period_s: float) -> m.About:
        """Return what it says of itself."""
        return m.About(
            station=self.id,
            name=self.name,
            kind=self.kind,
            lat_deg=self.lat_deg,
            lon_deg=self.lon_deg,
            period_s=period_s,
            quantities=[
                m.Quantity(quantity=name, unit=INSTRUMENTS[name].unit, depth_m=_wire(depth))
                for name, depth in KEYS[self.kind]
            ],
            model=MODELS[self.kind],
            parcel=self.parcel or msgspec.UNSET,
        )


KEYS: dict[m.Kind, tuple[Key, ...]] = {
    "weather": tuple(
        (name, None)
        for name in (
            "air_temperature", "air_humidity", "rain_rate", "wind_speed", "wind_gust", "wind_bearing", "radiation"
        )
    ),
    "soil": tuple((name, depth) for depth in DEPTHS_M for name in ("soil_moisture", "soil_temperature")),
    "respiration": (("co2", None), ("h2o", None)),
    "camera": (),
}  # fmt: skip


class Sample(NamedTuple):
    """One value; ``depth_m`` below ground, ``None`` above it."""

    quantity: str
    depth_m: float | None
    value: float


class Probe:
    """Reads one station's instruments."""

    def __init__(self, config: StationConfig, weather: Weather, ground: Ground) -> None:
        self._config, self._weather, self._ground = config, weather, ground

    def read(self, at_s: float) -> list[Sample]:
        """Return what the instruments show at a moment, seconds since 1970; a camera has none."""
        true = self._true(at_s)
        return [Sample(*key, INSTRUMENTS[key[0]].read(true[key])) for key in KEYS[self._config.kind]]

    def _true(self, at_s: float) -> dict[Key, float]:
        weather = self._weather
        if self._config.kind == "weather":
            ask: dict[str, Callable[[float], float]] = {
                "air_temperature": weather.temperature_c,
                "air_humidity": weather.humidity,
                "rain_rate": weather.rain_mm_h,
                "wind_speed": weather.wind_mps,
                "wind_gust": weather.gust_mps,
                "wind_bearing": weather.bearing_deg,
                "radiation": weather.radiation_w_m2,
            }
            return {(name, None): value(at_s) for name, value in ask.items()}
        if self._config.kind == "camera":
            return {}
        water = self._ground.water(self._config.texture, at_s)
        if self._config.kind == "soil":
            found: dict[Key, float] = {
                ("soil_moisture", depth): one for depth, one in zip(DEPTHS_M, water, strict=True)
            }
            return found | {("soil_temperature", depth): weather.soil_c(at_s, depth) for depth in DEPTHS_M}
        warm, texture = weather.soil_c(at_s, CHAMBER_M), self._config.texture
        return {
            ("co2", None): co2_umol_mol(warm, water[0], texture),
            ("h2o", None): h2o_mmol_mol(warm, water[0], texture),
        }


def battery(config: StationConfig, weather: Weather, at_s: float) -> float:
    """Return how full its battery is, 0 to 1: a small solar panel fills it by day."""
    day = 0.05 * math.cos(2 * math.pi * (solar_hour(at_s, config.lon_deg) - 16) / 24)
    slow = 0.08 * smooth(weather.seed, sum(config.id.encode()), at_s, 12 * DAY_S)
    return round(min(max(0.84 + day + slow, 0.0), 1.0), 2)


def reading(sample: Sample) -> m.Reading:
    """Return a value as it goes over the wire."""
    return m.Reading(quantity=sample.quantity, value=sample.value, depth_m=_wire(sample.depth_m))


def _wire(depth_m: float | None) -> float | msgspec.UnsetType:
    return msgspec.UNSET if depth_m is None else depth_m

"""Field stations as the cloud shall see them: themselves and the newest of what they measured, once each.

Only accepted stations (one that was taken out as removed), and only values that can be true. What is old keeps its own
time: nothing is told as of now.
"""

from __future__ import annotations

from collections.abc import Iterable
from datetime import datetime

from hmi.domain.sensors.observation import Measurement, SensorKind, SoilReading, Station, WeatherReading
from hmi.domain.sensors.quantity import Channel
from hmi.domain.sensors.station import FieldStation
from hmi.fiware.device import device_entity, device_removed, measurement_entity
from hmi.fiware.soil import record_entity
from hmi.fiware.urn import KeyValues, Urns
from hmi.fiware.weather import weather_entity
from hmi.store.sensor_board import SensorBoard, StationNow, ValueNow

UNIT_CODES = {
    "degC": "CEL", "1": "C62", "m/s": "MTS", "deg": "DD", "W/m2": "D54", "mm/h": "H67", "umol/mol": "59",
    "mmol/mol": "NX",
}  # fmt: skip
"""Units as UN/CEFACT recommendation 20 names them."""
_WEATHER = {
    "air_temperature": "temperature_c", "air_humidity": "humidity", "rain_rate": "rain_mm_h",
    "wind_speed": "wind_mps", "wind_gust": "gust_mps", "wind_bearing": "wind_bearing_deg",
    "radiation": "radiation_w_m2",
}  # fmt: skip
TOGETHER_S = 60.0
_SOIL = {"soil_moisture": "moisture", "soil_temperature": "temperature_c"}


class StationStates:
    """Watches the board; ``told`` notes what arrived.

    Args:
        board: the stations as they are now.
        urns: names of the farm's entities.
    """

    what = "Field stations"

    def __init__(self, board: SensorBoard, urns: Urns) -> None:
        self._board, self._urns = board, urns
        self._waiting: dict[str, None] = {}
        self._told: dict[str, KeyValues] = {}
        self._devices: dict[str, KeyValues] = {}  # as last told, by station: what is left of one that was taken out
        self.forget()
        board.on_report.append(lambda known: self._waiting.setdefault(known.station.id))
        board.on_changed.append(lambda station_id: self._waiting.setdefault(station_id))

    def reports(self, limit: int) -> list[KeyValues]:
        """Return what to tell now, at most so many entities; until told, they come again."""
        found: list[KeyValues] = []
        for station_id in list(self._waiting):
            fresh = [one for one in self._of(station_id) if self._told.get(one["id"]) != one]
            if not fresh:
                del self._waiting[station_id]
                continue
            if found and len(found) + len(fresh) > limit:
                break
            found += fresh
        return found

    def told(self, entities: Iterable[KeyValues]) -> None:
        """Note that these arrived; a station with nothing left to tell waits no more at the next look."""
        for one in entities:
            self._told[one["id"]] = one
            if station_id := self._urns.name_of("Device", one["id"]):
                self._devices[station_id] = one

    def forget(self) -> None:
        """Tell everything again: the broker may have lost it, or be another one."""
        self._told.clear()
        self._waiting.update(dict.fromkeys([*self._devices, *(one.station.id for one in self._board.accepted())]))

    def _of(self, station_id: str) -> list[KeyValues]:
        known = self._board.get(station_id)
        if known is not None and known.station.is_accepted:
            return self._entities(known)
        device = self._devices.get(station_id)
        return [device_removed(device)] if device else []

    def _entities(self, known: StationNow) -> list[KeyValues]:
        station = _station(known.station)
        found = [device_entity(self._urns, station)]
        values = [one for one in known.ordered() if one.is_plausible]
        weather = [one for one in values if one.channel.quantity in _WEATHER]
        if weather and station.kind is SensorKind.WEATHER:
            found.append(weather_entity(self._urns, station, _weather(station.id, weather)))
        found += [record_entity(self._urns, station, one) for one in _soil(station.id, values)]
        rest = [one for one in values if one.channel.quantity not in _SOIL]
        if station.kind is SensorKind.WEATHER:
            rest = [one for one in rest if one.channel.quantity not in _WEATHER]
        return [*found, *(self._measurement(station, known, one) for one in rest)]

    def _measurement(self, station: Station, known: StationNow, one: ValueNow) -> KeyValues:
        unit = known.station.units.get(one.channel, "")
        channel, unit = one.channel, UNIT_CODES.get(unit, unit)
        told = Measurement(station.id, one.measured_at, channel.quantity, one.value, unit, channel.depth_m)
        return measurement_entity(self._urns, station, told)


def _station(one: FieldStation) -> Station:
    return Station(one.id, one.name, one.kind, one.lat_deg, one.lon_deg, one.battery, one.parcel, one.heard_at)


def _weather(station_id: str, values: list[ValueNow]) -> WeatherReading:
    at = max(one.measured_at for one in values)
    parts = {_WEATHER[one.channel.quantity]: one.value for one in values if _is_with(one.measured_at, at)}
    return WeatherReading(station_id, at, **parts)


def _soil(station_id: str, values: list[ValueNow]) -> list[SoilReading]:
    depths: dict[float, dict[str, tuple[float, datetime]]] = {}
    for one in values:
        channel: Channel = one.channel
        if channel.quantity in _SOIL and channel.depth_m is not None:
            depths.setdefault(channel.depth_m, {})[_SOIL[channel.quantity]] = one.value, one.measured_at
    return [_reading(station_id, depth_m, found) for depth_m, found in depths.items()]


def _reading(station_id: str, depth_m: float, found: dict[str, tuple[float, datetime]]) -> SoilReading:
    newest = max(at for _, at in found.values())
    return SoilReading(station_id, newest, depth_m, **{k: v for k, (v, at) in found.items() if _is_with(at, newest)})


def _is_with(at: datetime, newest: datetime) -> bool:
    """Say whether a value was measured together with the newest: what is older has no place under its time."""
    return (newest - at).total_seconds() <= TOGETHER_S

"""WeatherObserved (dataModel.Weather)."""

from __future__ import annotations

from hmi.domain.sensors.observation import Station, WeatherReading
from hmi.fiware.urn import KeyValues, Urns, moment, point, told


def weather_entity(urns: Urns, station: Station, reading: WeatherReading) -> KeyValues:
    """Return the newest weather of a station; degC, mm/h, m/s, W/m2, humidity 0..1."""
    return told(
        {
            "id": urns.of("WeatherObserved", station.id),
            "type": "WeatherObserved",
            "name": station.name,
            "refDevice": urns.of("Device", station.id),
            "dateObserved": moment(reading.at),
            "location": point(station.lat_deg, station.lon_deg),
            "temperature": reading.temperature_c,
            "relativeHumidity": reading.humidity,
            "precipitation": reading.rain_mm_h,
            "windSpeed": reading.wind_mps,
            "gustSpeed": reading.gust_mps,
            "windDirection": reading.wind_bearing_deg,
            "solarRadiation": reading.radiation_w_m2,
        }
    )

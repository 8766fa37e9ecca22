"""AgriSoil and AgriParcelRecord (dataModel.Agrifood): kinds of soil, and what was measured in it."""

from __future__ import annotations

from hmi.domain.sensors.observation import SoilReading, Station
from hmi.fiware.urn import KeyValues, Urns, moment, point, told


def soil_entity(urns: Urns, soil_id: str, name: str) -> KeyValues:
    """Return a kind of soil."""
    return {"id": urns.of("AgriSoil", soil_id), "type": "AgriSoil", "name": name}


def record_entity(urns: Urns, station: Station, reading: SoilReading) -> KeyValues:
    """Return the newest reading at one depth, an entity for each depth; m, degC, moisture 0..1."""
    return told(
        {
            "id": urns.of("AgriParcelRecord", f"{station.id}:{round(reading.depth_m * 100)}cm"),
            "type": "AgriParcelRecord",
            "description": f"{station.name}, {reading.depth_m * 100:.0f} cm",
            "hasAgriParcel": urns.of("AgriParcel", station.parcel_id) if station.parcel_id else urns.farm,
            "hasDevice": [urns.of("Device", station.id)],
            "location": point(station.lat_deg, station.lon_deg),
            "depth": reading.depth_m,
            "soilMoistureVwc": reading.moisture,
            "soilTemperature": reading.temperature_c,
            "dateObserved": moment(reading.at),
        }
    )

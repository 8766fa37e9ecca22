"""AgriSoil and AgriParcelRecord (dataModel.Agrifood): kinds of soil, and what was measured in it."""

from __future__ import annotations

from collections.abc import Iterable

from hmi.domain.sensors.observation import SoilReading, Station
from hmi.fiware.urn import KeyValues, Urns, depth_name, moment, point, told
from hmi.mapping.feature import MapFeature


def soil_of(parcel: MapFeature) -> str | None:
    """Return the kind of soil of a parcel, ``None`` where nobody said it."""
    return str(parcel.properties.get("soil_type") or "") or None


def soil_entities(urns: Urns, parcels: Iterable[MapFeature]) -> list[KeyValues]:
    """Return the kinds of soil of parcels, each once, by id."""
    soils = {urns.soil(name): name for name in map(soil_of, parcels) if name is not None}
    return [{"id": key, "type": "AgriSoil", "name": soils[key]} for key in sorted(soils)]


def record_entity(urns: Urns, station: Station, reading: SoilReading) -> KeyValues:
    """Return the newest reading at one depth, an entity for each depth; m, degC, moisture 0..1."""
    return told(
        {
            "id": urns.of("AgriParcelRecord", f"{station.id}:{depth_name(reading.depth_m)}"),
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

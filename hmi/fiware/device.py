"""Device and DeviceMeasurement (dataModel.Device): stations, their single values, and events of robots."""

from __future__ import annotations

import hashlib

from backend_clients.ngsi.identifier import escaped_name
from hmi.domain.event import RobotEvent
from hmi.domain.sensors.observation import Measurement, SensorKind, Station
from hmi.fiware.urn import OWN, KeyValues, Urns, depth_name, moment, point, told

_MEASURES = {
    SensorKind.WEATHER: ["temperature", "humidity", "windSpeed", "precipitation", "solarRadiation"],
    SensorKind.SOIL: ["soilMoisture", "temperature"],
    SensorKind.RESPIRATION: ["airPollution", "humidity"],
    SensorKind.CAMERA: ["light"],
}
_LONGEST = 96  # of an event's name: the whole id has room for 256
IN_USE, REMOVED = "in use", "removed"


def device_entity(urns: Urns, station: Station) -> KeyValues:
    """Return a station; its battery 0..1."""
    return told(
        {
            "id": urns.of("Device", station.id),
            "type": "Device",
            "name": station.name,
            "category": ["sensor"],
            "controlledProperty": _MEASURES[station.kind],
            "controlledAsset": [urns.of("AgriParcel", station.parcel_id)] if station.parcel_id else None,
            "location": point(station.lat_deg, station.lon_deg),
            "batteryLevel": station.battery,
            "deviceState": IN_USE,
            "dateLastValueReported": moment(station.heard_at) if station.heard_at else None,
        }
    )


def device_removed(device: KeyValues) -> KeyValues:
    """Return the entity of a station that was taken out: what it measured stays true, nothing more will come."""
    return {**device, "deviceState": REMOVED}


def measurement_entity(urns: Urns, station: Station, value: Measurement) -> KeyValues:
    """Return the newest value of one quantity of a station, an entity for each depth."""
    at_depth = "" if value.depth_m is None else f":{depth_name(value.depth_m)}"
    return {
        "id": urns.of("DeviceMeasurement", f"{station.id}:{value.quantity}{at_depth}"),
        "type": "DeviceMeasurement",
        "refDevice": urns.of("Device", station.id),
        "controlledProperty": value.quantity,
        "numValue": value.value,
        "unit": value.unit,
        "dateObserved": moment(value.at),
        "location": point(station.lat_deg, station.lon_deg),
    }


def event_entity(urns: Urns, event: RobotEvent, robot_model: str) -> KeyValues:
    """Return an event of a robot, an entity of its own: sent twice it is the same one, and none replaces another."""
    return {
        "id": urns.of("DeviceMeasurement", f"{event.robot_id}:{_event_name(event.event_id)}"),
        "type": "DeviceMeasurement",
        "refDevice": urns.of(robot_model, event.robot_id),
        "measurementType": "event",
        "controlledProperty": event.kind,
        "textValue": event.text or event.name,
        "dateObserved": moment(event.at_utc),
        OWN: told({"name": event.name, "data": event.data, "mission": event.mission_id}),
    }


def _event_name(event_id: str) -> str:
    """Return an event's id as an entity's id may have it; a robot may choose any characters for its own."""
    name = escaped_name(event_id)
    return name if len(name) <= _LONGEST else hashlib.sha256(event_id.encode()).hexdigest()

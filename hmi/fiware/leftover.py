"""Attributes that an entity of ours may have had and has no more: a broker keeps what is not written anew."""

from __future__ import annotations

from collections.abc import Collection

from hmi.fiware.urn import KeyValues

_OF_UAV = {"location", "flightStatus", "workStatus", "groundSpeed", "fuel"}
_OF_WEATHER = {"temperature", "relativeHumidity", "precipitation", "windSpeed", "gustSpeed", "windDirection"}
_MAY_GO = {
    "StateMessage": frozenset({"battery", "location", "speed"}),
    "UnmannedAerialVehicle": frozenset(_OF_UAV),
    "Device": frozenset({"controlledAsset", "batteryLevel"}),
    "WeatherObserved": frozenset(_OF_WEATHER | {"solarRadiation"}),
    "AgriParcelRecord": frozenset({"soilMoistureVwc", "soilTemperature"}),
    "AgriParcel": frozenset({"hasAgriSoil", "category", "cropStatus", "lastPlantedAt"}),
    "RoadSegment": frozenset({"width"}),
    "AgriParcelOperation": frozenset({"result", "endedAt", "hasOperator"}),
}
_NOT_BEGUN = frozenset({"planned", "scheduled"})


def gone_from(entity: KeyValues, had: Collection[str] | None = None) -> frozenset[str]:
    """Return the attributes that are to be deleted where the entity has them; what others added is never one.

    Args:
        entity: all of it.
        had: the attributes that it was told with last, ``None`` if that is not known.
    """
    found = _MAY_GO.get(entity["type"], frozenset())
    if entity["type"] == "AgriParcelOperation" and entity.get("status") in _NOT_BEGUN:
        found |= {"startedAt"}  # later a console may have forgotten it over a restart, and the cloud knows it
    gone = found - entity.keys()
    return gone if had is None else gone & frozenset(had)

"""Attributes that an entity of ours may have had and has no more: a broker keeps what is not written anew."""

from __future__ import annotations

from hmi.fiware.urn import KeyValues

_MAY_GO = {
    "AgriParcel": frozenset({"hasAgriSoil", "category", "cropStatus", "lastPlantedAt"}),
    "RoadSegment": frozenset({"width"}),
    "AgriParcelOperation": frozenset({"result", "endedAt", "hasOperator"}),
}
_NOT_BEGUN = frozenset({"planned", "scheduled"})


def gone_from(entity: KeyValues) -> frozenset[str]:
    """Return the attributes that are to be deleted where the entity has them; what others added is never one."""
    found = _MAY_GO.get(entity["type"], frozenset())
    if entity["type"] == "AgriParcelOperation" and entity.get("status") in _NOT_BEGUN:
        found |= {"startedAt"}  # later a console may have forgotten it over a restart, and the cloud knows it
    return found - entity.keys()

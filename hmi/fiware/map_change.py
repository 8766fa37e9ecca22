"""What somebody else changed of a map entity in the cloud, as a feature that could be.

Each map entity carries a digest of what we wrote (``headland.told``). Where the digest does not fit any more, somebody
else wrote; nothing else has to be remembered.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any

from hmi.domain.ids import is_id
from hmi.fiware.building import building_entity
from hmi.fiware.parcel import parcel_entity
from hmi.fiware.road import road_entities
from hmi.fiware.urn import OWN, KeyValues, Urns
from hmi.mapping.attributes import LONGEST_NAME
from hmi.mapping.errors import BadFeature
from hmi.mapping.feature import MapFeature, parse_feature

KIND_OF = {"AgriParcel": "parcel", "Building": "building", "RoadSegment": "road"}
"""Models whose changes are proposed."""
_TOLD = "told"
_OURS_ALONE = frozenset({OWN, "area", "length", "startPoint", "endPoint", "belongsTo", "refRoad", "address"})
"""Follows from the rest, or has no place on our map."""


def signed(entity: KeyValues) -> KeyValues:
    """Return a map entity with the digest of what it says."""
    if entity["type"] not in KIND_OF or OWN not in entity:
        return entity
    return {**entity, OWN: {**entity[OWN], _TOLD: _digest(entity)}}


def is_as_told(entity: KeyValues) -> bool:
    """Say whether an entity is what we wrote."""
    own = entity.get(OWN)
    return isinstance(own, dict) and own.get(_TOLD) == _digest(entity)


def mark_of(entity: KeyValues) -> str:
    """Return a mark of what an entity says; another wish has another one."""
    return _digest(entity)


def feature_id_of(entity: KeyValues, urns: Urns) -> str | None:
    """Return the id of the feature that an entity is of, ``None`` if it cannot be one on our map."""
    found = urns.name_of(entity["type"], str(entity["id"])) or str(entity["id"]).rpartition(":")[2].lower()
    return found if is_id(found) else None


def proposed(
    entity: KeyValues, feature: MapFeature | None, urns: Urns, names: dict[str, str] | None = None
) -> MapFeature | None:
    """Return the feature as the cloud wants it, ``None`` if it wants what we have.

    Args:
        entity: of a model of ``KIND_OF``.
        feature: what our map has under that id.
        names: of crops and kinds of soil, by the ids of their entities.

    Raises:
        BadFeature: what the cloud says cannot be on a map.
    """
    kind = KIND_OF[entity["type"]]
    feature_id = feature_id_of(entity, urns)
    if feature_id is None:
        raise BadFeature("bad_id", f"{entity['id']} has no id that a feature may have.")
    if feature is not None and feature.kind != kind:
        raise BadFeature("other_kind", f"{feature.title} is a {feature.kind} here.", feature.id)
    before = {} if feature is None else _entity(feature, urns)
    changed = {key: value for key, value in entity.items() if _plain(before.get(key)) != _plain(value)}
    name = feature.name if feature is not None else str(entity.get("name") or "")[:LONGEST_NAME]
    if "name" in changed and isinstance(changed["name"], str):
        name = changed["name"][:LONGEST_NAME]
    geometry = changed.get("location", feature.geometry if feature is not None else None)
    properties = {**(feature.properties if feature is not None else {}), **_properties(kind, changed, names or {})}
    raw = {"type": "Feature", "id": feature_id, "geometry": geometry,
           "properties": {**properties, "id": feature_id, "kind": kind, "name": name}}  # fmt: skip
    wanted = parse_feature(raw)
    return None if wanted == feature else wanted


def _entity(feature: MapFeature, urns: Urns) -> KeyValues:
    if feature.kind == "parcel":
        return parcel_entity(urns, feature)
    return building_entity(urns, feature) if feature.kind == "building" else road_entities(urns, feature)[1]


def _properties(kind: str, changed: KeyValues, names: dict[str, str]) -> dict[str, Any]:
    """Return the properties of our map that the changed attributes mean."""
    found: dict[str, Any] = {}
    if kind == "parcel":
        found["crop"] = names.get(str(changed.get("hasAgriCrop")))
        found["soil_type"] = names.get(str(changed.get("hasAgriSoil")))
        found["status"] = changed.get("cropStatus")
        found["category"] = changed.get("category")
        planted = changed.get("lastPlantedAt")
        found["seeded"] = planted[:10] if isinstance(planted, str) else None
    elif kind == "building":
        category = changed.get("category")
        found["category"] = category[0] if isinstance(category, list) and category else None
    else:
        found["width_m"] = changed.get("width")
    return {key: value for key, value in found.items() if isinstance(value, str | int | float)}


def _digest(entity: KeyValues) -> str:
    said = {key: _plain(value) for key, value in entity.items() if key not in _OURS_ALONE}
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()[:24]


def _plain(value: Any) -> Any:
    """Return a value as it is after a broker kept it: numbers are doubles there, 1.0 comes back as 1."""
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    return value

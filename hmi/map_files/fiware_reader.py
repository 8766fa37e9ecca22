"""FIWARE smart data models: AgriFarm, AgriParcel, AgriCrop, Building, RoadSegment; as key-values or normalized.

Source: smartdatamodels.org, dataModel.Agrifood, dataModel.Building, dataModel.Transportation; ETSI GS CIM 009, 4.5.
"""

from __future__ import annotations

from typing import Any

from hmi.fiware.urn import OWN
from hmi.map_files.attributes import usable_id
from hmi.map_files.coordinate_system import WGS84
from hmi.map_files.kind_guess import ALL_KINDS
from hmi.map_files.source import Source, SourceFeature, SourceLayer

KIND_OF = {"AgriFarm": "farm", "AgriParcel": "parcel", "Building": "building", "RoadSegment": "road"}
_KNOWN = {*KIND_OF, "AgriCrop"}


def is_entities(root: Any) -> bool:
    """Say whether a JSON value is an entity, or a list of them, of models known here."""
    entities = root if isinstance(root, list) else [root]
    return any(isinstance(e, dict) and isinstance(e.get("type"), str) and e["type"] in _KNOWN for e in entities)


def read(root: Any) -> Source:
    """Return the parcels, farms, buildings and roads of a list of entities; others are passed over."""
    raw = root if isinstance(root, list) else [root]
    entities = [_key_values(e) for e in raw if isinstance(e, dict) and isinstance(e.get("type"), str)]
    names = {str(e.get("id")): e.get("name") for e in entities if e["type"] in ("AgriCrop", "AgriSoil")}
    features = [_feature(e, names) for e in entities if e["type"] in KIND_OF]
    return Source("fiware", [SourceLayer("", WGS84, [f for f in features if f is not None])])


def _key_values(entity: dict[str, Any]) -> dict[str, Any]:
    return {key: value if key == OWN else _value(value) for key, value in entity.items()}


def _value(attribute: Any) -> Any:
    if isinstance(attribute, dict) and isinstance(attribute.get("type"), str):
        return attribute.get("value", attribute.get("object", attribute))
    return attribute


def _feature(entity: dict[str, Any], names: dict[str, Any]) -> SourceFeature | None:
    kind, entity_id = KIND_OF[entity["type"]], str(entity.get("id"))
    geometry = entity.get("landLocation") if kind == "farm" else entity.get("location")
    if geometry is None and kind == "farm":
        return None  # a farm without land is a name only
    name = entity.get("name")
    which = f"{entity['type']} {entity_id[-40:]}"
    own = entity.get(OWN)
    if isinstance(own, dict) and str(own.get("kind")) in ALL_KINDS and isinstance(own.get("properties"), dict):
        return SourceFeature(which, geometry, dict(own["properties"]), str(own.get("name", "")), own["kind"],
                             usable_id(own.get("id")), is_exact=True)  # fmt: skip
    given = {
        "crop": names.get(str(entity.get("hasAgriCrop"))),
        "soil_type": names.get(str(entity.get("hasAgriSoil"))),
        "status": entity.get("cropStatus"),
        "seeded": entity.get("lastPlantedAt"),
        "width_m": entity.get("width"),
        "category": ", ".join(map(str, c)) if isinstance(c := entity.get("category"), list) else c,
        "description": entity.get("description"),
        "source_id": entity_id,
    }
    given = {key: value for key, value in given.items() if value not in (None, "")}
    return SourceFeature(which, geometry, given, name if isinstance(name, str) else None, kind)

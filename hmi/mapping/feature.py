"""A feature of the farm map: parcel, road, home and so on, with its shape and attributes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from hmi.domain.ids import is_id
from hmi.mapping.attributes import HEIGHT, LONGEST_NAME, LONGEST_TEXT, check_height, parse_attributes
from hmi.mapping.coordinates import Geometry, parse_geometry
from hmi.mapping.errors import BadFeature
from hmi.mapping.kinds import KINDS

_HEAD = ("id", "kind", "name")


@dataclass(frozen=True, slots=True)
class MapFeature:
    """One feature; equal if every corner and attribute is.

    Args:
        id: unique on the map, as in ``hmi.domain.ids``.
        kind: a key of ``hmi.mapping.kinds.KINDS``.
        name: what people call it; may be empty.
        geometry: GeoJSON, WGS84 degrees, longitude first, 8 decimals, rings closed.
        properties: attributes without id, kind and name; JSON values.
    """

    id: str
    kind: str
    name: str
    geometry: Geometry
    properties: dict[str, Any]

    @property
    def title(self) -> str:
        """Return what to call it in a sentence: its name, or what to call a feature that nobody named."""
        return self.name or f"Unnamed {KINDS[self.kind].noun}"


def parse_feature(raw: Mapping[str, Any]) -> MapFeature:
    """Return the feature of a GeoJSON feature, shape and attributes checked.

    What can be drawn wrong and mended is let in: crossing edges and wrong winding are for ``hmi.mapping.checks``.
    So are longer names and heights that are none, which maps of before have: ``check_given`` is for what is given now.

    Raises:
        BadFeature: says which rule is broken and how to mend it; carries the feature's id if that could be read.
    """
    properties = raw.get("properties") if isinstance(raw, Mapping) else None
    if not isinstance(raw, Mapping) or raw.get("type") != "Feature" or not isinstance(properties, Mapping):
        raise BadFeature("not_a_feature", "This is no GeoJSON feature with properties and a geometry.")
    feature_id = _id(raw.get("id"), properties.get("id"))
    try:
        return _parsed(feature_id, properties, raw.get("geometry"))
    except BadFeature as error:
        called = properties.get("name")
        title = called if isinstance(called, str) and 0 < len(called) <= LONGEST_TEXT else feature_id
        raise BadFeature(error.code, f"{title}: {error.text}", feature_id) from error


def check_given(feature: MapFeature, name: object = None, height_m: object = None) -> None:
    """Return if a feature may be given the name and the height that it has.

    Args:
        name, height_m: what it had before: the same again is not given.

    Raises:
        BadFeature: the name is too long, or the height is none.
    """
    given = feature.name
    if given != name and len(given) > LONGEST_NAME:
        text = f"{given[:40]}…: Its name has {len(given)} letters, a name has at most {LONGEST_NAME}. Shorten it."
        raise BadFeature("bad_name", text, feature.id)
    if height_m is None or feature.properties.get(HEIGHT) != height_m:
        try:
            check_height(feature.kind, feature.properties)
        except BadFeature as error:
            raise BadFeature(error.code, f"{feature.name or feature.id}: {error.text}", feature.id) from error


def as_geojson(feature: MapFeature) -> dict[str, Any]:
    """Return the GeoJSON feature; shares its coordinates and values with ``feature``."""
    head = {"id": feature.id, "kind": feature.kind, "name": feature.name}
    return {
        "type": "Feature",
        "id": feature.id,
        "properties": {**head, **feature.properties},
        "geometry": feature.geometry,
    }


def collection(features: Iterable[MapFeature]) -> dict[str, Any]:
    """Return a GeoJSON feature collection."""
    return {"type": "FeatureCollection", "features": [as_geojson(one) for one in features]}


def _id(outer: object, inner: object) -> str:
    given = outer if outer is not None else inner
    if not isinstance(given, str) or not is_id(given):
        raise BadFeature(
            "bad_id", "A feature has no usable id. Use small letters, digits, - and _, at most 64, such as north-2."
        )
    if inner is not None and inner != given:
        raise BadFeature("bad_id", f"{given}: its properties carry another id. Make them the same.", given)
    return given


def _parsed(feature_id: str, properties: Mapping[str, Any], raw_geometry: object) -> MapFeature:
    kind, name = properties.get("kind"), properties.get("name", "")
    if not isinstance(kind, str) or kind not in KINDS:
        shown = f"{kind[:40]!r}" if isinstance(kind, str) else "missing"
        raise BadFeature("unknown_kind", f"Its kind is {shown}. Choose one of {', '.join(KINDS)}.")
    name = "" if name is None else name
    if not isinstance(name, str) or len(name) > LONGEST_TEXT or not name.isprintable():
        raise BadFeature("bad_name", f"Its name is no plain text of at most {LONGEST_TEXT} letters. Rename it.")
    geometry = parse_geometry(raw_geometry)
    allowed = KINDS[kind].geometries
    if geometry["type"] not in allowed:
        raise BadFeature(
            "wrong_geometry",
            f"A {KINDS[kind].noun} cannot be a {geometry['type']}. Draw a {' or '.join(allowed)}, or choose"
            " another kind.",
        )
    rest = {key: value for key, value in properties.items() if key not in _HEAD}
    return MapFeature(feature_id, kind, name, geometry, parse_attributes(kind, geometry["type"], rest))

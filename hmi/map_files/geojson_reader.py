"""GeoJSON: RFC 7946, the form of 2008 with its ``crs`` member, and one feature a line."""

from __future__ import annotations

from typing import Any

from hmi.map_files import fiware_reader, json_text
from hmi.map_files.attributes import usable_id
from hmi.map_files.coordinate_system import WGS84, CoordinateSystem, UnknownSystem, from_member
from hmi.map_files.errors import BadMapFile
from hmi.map_files.imported import Skipped
from hmi.map_files.kind_guess import ALL_KINDS
from hmi.map_files.source import Source, SourceFeature, SourceLayer

GEOMETRIES = frozenset(
    {"Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon", "GeometryCollection"}
)


def read(data: bytes) -> Source:
    """Return what a GeoJSON file, or a JSON array of FIWARE entities, holds.

    Raises:
        BadMapFile: it is no JSON, or JSON of something else.
    """
    text = json_text.decoded(data).strip("\ufeff\x1e \t\r\n")
    try:
        root = json_text.whole(text)
    except BadMapFile:
        lines = json_text.by_line(text)
        if lines is None or not _is_geojson(lines[0][1]):
            raise
        return _of_lines(lines)
    if fiware_reader.is_entities(root):
        return fiware_reader.read(root)
    return _of_root(root)


def _of_root(root: Any) -> Source:
    if isinstance(root, list) and any(_is_geojson(value) for value in root):
        root = {"type": "FeatureCollection", "features": root}
    if not _is_geojson(root):
        raise BadMapFile("not_a_map", _what_else(root))
    skipped: list[Skipped] = []
    name = root.get("name")
    features = _features(root, skipped)
    layer = SourceLayer(name if isinstance(name, str) else "", _system(root), features)
    return Source("geojson", [layer], skipped)


def _of_lines(lines: list[tuple[int, Any]]) -> Source:
    skipped: list[Skipped] = []
    features: list[SourceFeature] = []
    for n, value in lines:
        if value is None or not _is_geojson(value):
            skipped.append(Skipped(f"line {n}", "The line is no GeoJSON.", "Export it once more."))
            continue
        for feature in _features(value, skipped):
            feature.which = f"line {n}{_called(feature)}"
            features.append(feature)
    return Source("geojson", [SourceLayer("", WGS84, features)], skipped)


def _features(root: dict[str, Any], skipped: list[Skipped]) -> list[SourceFeature]:
    if root["type"] == "FeatureCollection":
        raw = root.get("features")
        if not isinstance(raw, list):
            text = "The feature collection has no list of features. Export it once more."
            raise BadMapFile("not_a_map", text)
    else:
        raw = [root]
    found = [_feature(i, value, skipped) for i, value in enumerate(raw, start=1)]
    return [feature for feature in found if feature is not None]


def _feature(n: int, raw: Any, skipped: list[Skipped]) -> SourceFeature | None:
    if not _is_geojson(raw):
        skipped.append(Skipped(f"shape {n}", "It is no GeoJSON feature.", "Export it once more."))
        return None
    if raw["type"] != "Feature":
        return SourceFeature(f"shape {n}", raw)
    properties = raw.get("properties")
    properties = dict(properties) if isinstance(properties, dict) else {}
    feature = SourceFeature(f"shape {n}", raw.get("geometry"), properties)
    feature.id = usable_id(raw.get("id")) or usable_id(properties.get("id"))
    geometry = raw["geometry"] if isinstance(raw.get("geometry"), dict) else {}
    try:
        feature.crs = next((from_member(holder["crs"]) for holder in (raw, geometry) if "crs" in holder), None)
    except UnknownSystem as error:
        skipped.append(Skipped(f"shape {n}", str(error), "Export it in WGS84 (EPSG:4326)."))
        return None
    _recognise(feature)
    feature.which += _called(feature)
    return feature


def _recognise(feature: SourceFeature) -> None:
    """Take a feature of the farm map as it is."""
    properties = feature.properties
    kind, name = properties.get("kind"), properties.get("name")
    is_ours = bool(feature.id) and feature.id == properties.get("id") and isinstance(name, str)
    if is_ours and isinstance(kind, str) and kind in ALL_KINDS:
        feature.is_exact, feature.kind, feature.name = True, kind, name
        feature.properties = {key: value for key, value in properties.items() if key not in {"id", "kind", "name"}}


def _system(root: dict[str, Any]) -> CoordinateSystem | None:
    if "crs" not in root:
        return WGS84  # RFC 7946, section 4
    try:
        return from_member(root["crs"])
    except UnknownSystem as error:
        raise BadMapFile("no_coordinate_system", f"{error} Export the file in WGS84 (EPSG:4326).") from error


def _is_geojson(value: Any) -> bool:
    kind = value.get("type") if isinstance(value, dict) else None
    return isinstance(kind, str) and (kind in GEOMETRIES or kind in {"Feature", "FeatureCollection"})


def _what_else(root: Any) -> str:
    if isinstance(root, dict) and root.get("type") == "Topology":
        return "This is TopoJSON. Export it as GeoJSON."
    if isinstance(root, dict) and ("geometryType" in root or "rings" in root):
        return "This is Esri JSON. Export it as GeoJSON."
    return "This JSON is not a map. Export it as GeoJSON."


def _called(feature: SourceFeature) -> str:
    name = feature.name or feature.properties.get("name")
    return f" ({name[:40]})" if isinstance(name, str) and name else ""

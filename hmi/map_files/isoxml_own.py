"""What ISOXML has no place for, in a file beside the task data that an AFE element names (ISO 11783-10, AttachedFile).

The file is ``HEADLAND.JSN`` (names of attached files are 8.3): ``{"headland": 1, "features": {ELEMENT_ID: FEATURE}}``.
FEATURE holds id, kind, name, properties and geometry as the farm map has them, and the words that were written for it.
A program that knows nothing of it sees the task data; what it changed there (a name, a crop, a shape) is taken over.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element

from pyproj import Geod

from hmi.map_files import json_text
from hmi.map_files.archive import Archive
from hmi.map_files.attributes import usable_id
from hmi.map_files.errors import BadMapFile
from hmi.map_files.exported import number
from hmi.map_files.kind_guess import ALL_KINDS
from hmi.map_files.source import SourceFeature
from hmi.map_files.xml_tree import children, cleaned
from hmi.mapping.feature import MapFeature

FILE = "HEADLAND.JSN"
FILE_TYPE = "254"  # attribute D of AFE: 128 to 254 are for each maker to use
VERSION = 1
DESIGNATOR_CHARS = 32
CIRCLE_CORNERS = 24  # the outline lies outside of the circle: its corners stand a little further out
_GEOD = Geod(ellps="WGS84")
_TEXTS = ("crop", "species")  # properties of parcels that the task data tell as well
Entries = Mapping[str, Mapping[str, Any]]


def designator(text: object) -> str:
    """Return a text as a designator holds it: one line of at most 32 letters."""
    return " ".join(cleaned(str(text)).split())[:DESIGNATOR_CHARS].strip()


def circle(feature: MapFeature) -> list[list[float]]:
    """Return the ring around a point obstacle, outside of its radius everywhere."""
    return _ring(feature.geometry["coordinates"], float(feature.properties["radius_m"]))


def told_crop(feature: MapFeature) -> tuple[str, str]:
    """Return crop and variety as designators; the task data have no place for a variety without a crop."""
    crop = designator(feature.properties.get("crop", ""))
    return crop, designator(feature.properties.get("species", "")) if crop else ""


def entry(feature: MapFeature, called: str) -> dict[str, Any]:
    """Return FEATURE; ``called`` is the designator written into the task data."""
    told = dict(zip(_TEXTS, told_crop(feature), strict=True)) if feature.kind == "parcel" else {}
    return {
        "told": told,
        "id": feature.id,
        "kind": feature.kind,
        "name": feature.name,
        "called": called,
        "properties": feature.properties,
        "geometry": feature.geometry,
    }


def read(root: Element, archive: Archive | None, path: str) -> Entries:
    """Return the entries by element id; none where no such file is named or it is not ours."""
    wanted = {element.get("A", "").upper() for element in children(root, "AFE")}
    if archive is None or FILE not in wanted:
        return {}
    folder = path[: len(path) - len(path.replace("\\", "/").rsplit("/", 1)[-1])]
    found = [name for name in archive.names if name.lower() == f"{folder}{FILE}".lower()]
    try:
        told = json_text.whole(json_text.decoded(archive.read(found[0]))) if found else {}
    except BadMapFile:
        return {}  # the task data are whole without it
    features = told.get("features") if isinstance(told, dict) and told.get("headland") == VERSION else None
    return {key: one for key, one in features.items() if _is_entry(one)} if isinstance(features, dict) else {}


def restore(feature: SourceFeature, element_id: str | None, entries: Entries) -> SourceFeature:
    """Give a feature back what the task data had no place for, as far as they still say what was written."""
    own = entries.get(element_id or "")
    if own is None:
        return feature
    properties = dict(own["properties"])
    for key, told in own["told"].items():
        if (feature.properties.get(key) or "") != told:
            properties[key] = feature.properties.get(key)
    if feature.geometry is not None and feature.geometry["type"] == "LineString":
        _take_width(feature, properties)
    is_renamed = (feature.name or "") != own["called"]
    feature.name = (feature.name or "") if is_renamed else own["name"]
    feature.id, feature.kind, feature.is_exact, feature.problems = usable_id(own["id"]), own["kind"], True, []
    feature.geometry = _shape(feature.geometry, own)
    feature.properties = {key: value for key, value in properties.items() if key not in _TEXTS or value is not None}
    return feature


def _take_width(feature: SourceFeature, properties: dict[str, Any]) -> None:
    for key in ("width_m", "swath_m"):
        told, kept = feature.properties.get(key), properties.get(key)
        if told is not None and (not isinstance(kept, (int, float)) or abs(told - kept) > 0.0006):  # written in mm
            properties[key] = told


def _shape(read_geometry: Any, own: Mapping[str, Any]) -> Any:
    """Return the kept geometry where the task data hold what was written for it, else what they hold now."""
    kept = own["geometry"]
    if not isinstance(read_geometry, dict):
        return read_geometry
    if kept["type"] == "Point" and read_geometry["type"] == "Polygon":
        radius = own["properties"].get("radius_m")
        is_round = isinstance(radius, (int, float)) and not isinstance(radius, bool) and 0 < radius < 1e4
        return kept if is_round and _is_circle(read_geometry, kept["coordinates"], float(radius)) else read_geometry
    if kept["type"] == "MultiLineString" and read_geometry["type"] == "LineString":
        return {"type": "MultiLineString", "coordinates": [read_geometry["coordinates"]]}
    return read_geometry


def _is_circle(read_geometry: dict[str, Any], place: Any, radius_m: float) -> bool:
    if not (isinstance(place, list) and len(place) == 2 and all(isinstance(n, (int, float)) for n in place)):
        return False
    drawn = [[float(number(n)) for n in corner] for corner in _ring(place, radius_m)]
    return bool(read_geometry["coordinates"] == [drawn])


def _ring(place: list[float], radius_m: float) -> list[list[float]]:
    lon, lat = place
    out_m = radius_m / math.cos(math.pi / CIRCLE_CORNERS)
    headings = [-360.0 * i / CIRCLE_CORNERS for i in range(CIRCLE_CORNERS)]
    corners = [_GEOD.fwd(lon, lat, heading, out_m)[:2] for heading in headings]
    ring = [[float(x), float(y)] for x, y in corners]
    return [*ring, ring[0]]


def _is_entry(raw: Any) -> bool:
    return (
        isinstance(raw, dict)
        and usable_id(raw.get("id")) is not None
        and raw.get("kind") in ALL_KINDS
        and isinstance(raw.get("name"), str)
        and isinstance(raw.get("called"), str)
        and isinstance(raw.get("properties"), dict)
        and isinstance(raw.get("told"), dict)
        and isinstance(raw.get("geometry"), dict)
        and isinstance(raw["geometry"].get("type"), str)
    )

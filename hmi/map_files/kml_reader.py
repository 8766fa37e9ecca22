"""KML 2.2 and 2.3 (OGC 12-007r2), and KMZ. Links are never followed."""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element

from hmi.map_files.archive import Archive
from hmi.map_files.coordinate_system import WGS84
from hmi.map_files.errors import BadMapFile
from hmi.map_files.imported import Skipped
from hmi.map_files.own_mark import recognise
from hmi.map_files.source import Source, SourceFeature, SourceLayer
from hmi.map_files.xml_tree import child, children, local, parse, text_of

_LINES = ("LineString", "LinearRing")
_HOLDERS = ("Document", "Folder")
_PICTURES = ("GroundOverlay", "PhotoOverlay", "ScreenOverlay")


def read(root: Element) -> Source:
    """Return what a KML document holds, one layer a folder."""
    source = Source("kml", [])
    _folder(root, "", source)
    return source


def read_kmz(archive: Archive) -> Source:
    """Return what the KML documents of a KMZ hold; pictures and models in it are passed over.

    Raises:
        BadMapFile: there is none, or one is broken.
    """
    source = Source("kmz", [])
    for name in archive.ending(".kml"):
        root = parse(archive.read(name))
        if local(root) != "kml":
            raise BadMapFile("not_a_map", f"{name[-60:]} in the archive is not KML. Export it once more.")
        _folder(root, "", source)
    return source


def _folder(holder: Element, name: str, source: Source) -> None:
    layer = SourceLayer(name, WGS84, [])
    source.layers.append(layer)
    for element in holder:
        kind = local(element)
        if kind in _HOLDERS:
            _folder(element, text_of(child(element, "name"))[:80] or name, source)
        elif kind == "Placemark":
            layer.features.append(_placemark(element, len(layer.features) + 1))
        elif kind == "NetworkLink":
            why = "It is a link to another place, and nothing is fetched."
            source.skipped.append(Skipped(_titled("link", element), why, "Download what it links to and import that."))
        elif kind in _PICTURES:
            why = "It is a picture, not a shape."
            source.skipped.append(Skipped(_titled("picture", element), why, "Draw what it shows."))


def _titled(what: str, element: Element) -> str:
    name = text_of(child(element, "name"))[:40]
    return f"{what} ({name})" if name else what


def _placemark(element: Element, n: int) -> SourceFeature:
    name = text_of(child(element, "name"))
    parts = [shape for shape in map(_geometry, element) if shape is not None]
    feature = SourceFeature(_titled(f"shape {n}", element), _joined(parts), name=name or None)
    texts = _attributes(child(element, "ExtendedData"))
    description = text_of(child(element, "description"))
    if description and "description" not in texts:
        texts["description"] = description
    recognise(feature, texts)
    return feature


def _attributes(extended: Element | None) -> dict[str, str]:
    """Return untyped and typed data (OGC 12-007r2: Data and SchemaData)."""
    texts: dict[str, str] = {}
    for element in extended if extended is not None else ():
        if local(element) == "Data":
            texts[element.get("name", "")] = text_of(child(element, "value"))
        elif local(element) == "SchemaData":
            texts |= {data.get("name", ""): text_of(data) for data in children(element, "SimpleData")}
    return texts


def _geometry(element: Element) -> Any:
    kind = local(element)
    if kind == "Point":
        places = _coordinates(element)
        return {"type": "Point", "coordinates": places[0] if places else []}
    if kind in _LINES:
        return {"type": "LineString", "coordinates": _coordinates(element)}
    if kind == "Polygon":
        rings = [ring for side in ("outerBoundaryIs", "innerBoundaryIs") for ring in _rings(element, side)]
        return {"type": "Polygon", "coordinates": rings}
    if kind == "Track":  # gx:Track; KML 2.3 has it without the prefix
        return {"type": "LineString", "coordinates": [_numbers(text_of(c).split()) for c in children(element, "coord")]}
    if kind in {"MultiGeometry", "MultiTrack"}:
        return _joined([shape for shape in map(_geometry, element) if shape is not None])
    return None


def _joined(parts: list[Any]) -> Any:
    if len(parts) < 2:
        return parts[0] if parts else None
    if all(part["type"] == "LineString" for part in parts):
        return {"type": "MultiLineString", "coordinates": [part["coordinates"] for part in parts]}
    return {"type": "GeometryCollection", "geometries": parts}


def _rings(polygon: Element, side: str) -> list[Any]:
    rings = (ring for boundary in children(polygon, side) for ring in children(boundary, "LinearRing"))
    return [_coordinates(ring) for ring in rings]


def _coordinates(element: Element) -> list[Any]:
    """Return the tuples of ``coordinates`` (OGC 12-007r2: coordinatesType); blanks about commas are forgiven."""
    text = " ".join(text_of(child(element, "coordinates")).split())
    return [_numbers(part.split(",")) for part in text.replace(" ,", ",").replace(", ", ",").split()]


def _numbers(parts: list[str]) -> list[Any]:
    return [_number(part) for part in parts[:2]]


def _number(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text  # the shape is refused with it

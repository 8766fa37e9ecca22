"""The farm map as KML 2.2 (OGC 07-147r2) and KMZ; attributes are kept as extended data, see ``own_mark``."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from hmi.map_files import own_mark
from hmi.map_files.exported import MapFile, number, packed, stem, xml_bytes
from hmi.map_files.xml_tree import cleaned
from hmi.mapping.coordinates import paths
from hmi.mapping.feature import MapFeature
from hmi.mapping.kinds import KINDS

_NAMESPACE = "http://www.opengis.net/kml/2.2"
# line and fill, aabbggrr; the colours of static/js/map are for screens, these for satellite pictures
_COLOURS = {"parcel": "ff3cd4ff", "road": "ffffffff", "obstacle": "ff2020ff", "no-go": "ff2020ff", "water": "ffff9030"}
_USUAL = "ffb0ffb0"


def write(features: Sequence[MapFeature], farm_id: str, farm_name: str) -> MapFile:
    """Return a KML document with one folder a kind."""
    data = _document(features, farm_name)
    return MapFile(data, "application/vnd.google-earth.kml+xml", f"{stem(farm_id)}.kml")


def write_kmz(features: Sequence[MapFeature], farm_id: str, farm_name: str) -> MapFile:
    """Return the same document, packed; ``doc.kml`` comes first."""
    data = packed({"doc.kml": _document(features, farm_name)})
    return MapFile(data, "application/vnd.google-earth.kmz", f"{stem(farm_id)}.kmz")


def _document(features: Sequence[MapFeature], farm_name: str) -> bytes:
    root = Element("kml", xmlns=_NAMESPACE)
    document = SubElement(root, "Document")
    SubElement(document, "name").text = cleaned(farm_name)
    kinds = [kind for kind in KINDS if any(feature.kind == kind for feature in features)]
    for kind in kinds:
        _style(document, kind)
    for kind in kinds:
        folder = SubElement(document, "Folder")
        SubElement(folder, "name").text = kind
        for feature in features:
            if feature.kind == kind:
                _placemark(folder, feature)
    return xml_bytes(root)


def _style(document: Element, kind: str) -> None:
    style = SubElement(document, "Style", id=f"kind-{kind}")
    colour = _COLOURS.get(kind, _USUAL)
    line = SubElement(style, "LineStyle")
    SubElement(line, "color").text = colour
    SubElement(line, "width").text = "2"
    SubElement(SubElement(style, "PolyStyle"), "color").text = f"40{colour[2:]}"


def _placemark(folder: Element, feature: MapFeature) -> None:
    placemark = SubElement(folder, "Placemark", id=f"feature-{feature.id}")
    SubElement(placemark, "name").text = cleaned(feature.name)
    SubElement(placemark, "styleUrl").text = f"#kind-{feature.kind}"
    extended = SubElement(placemark, "ExtendedData")
    for key, text in own_mark.written(feature):
        SubElement(SubElement(extended, "Data", name=key), "value").text = text
    _geometry(placemark, feature)


def _geometry(placemark: Element, feature: MapFeature) -> None:
    kind, lines = feature.geometry["type"], paths(feature.geometry)
    if kind == "Polygon":
        polygon = SubElement(placemark, "Polygon")
        for i, ring in enumerate(lines):
            side = SubElement(polygon, "outerBoundaryIs" if i == 0 else "innerBoundaryIs")
            _coordinates(SubElement(side, "LinearRing"), ring)
        return
    holder = SubElement(placemark, "MultiGeometry") if kind == "MultiLineString" else placemark
    for line in lines:
        _coordinates(SubElement(holder, "Point" if kind == "Point" else "LineString"), line)


def _coordinates(element: Element, line: list[list[float]]) -> None:
    SubElement(element, "coordinates").text = " ".join(f"{number(lon)},{number(lat)}" for lon, lat in line)

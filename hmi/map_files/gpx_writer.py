"""The farm map as GPX 1.1: points are waypoints, everything else tracks, with attributes as extensions.

A polygon is a track with one segment a ring; other programs see its outline as a line.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from hmi.map_files import own_mark
from hmi.map_files.exported import MapFile, number, stem, xml_bytes
from hmi.map_files.gpx_reader import NAMESPACE
from hmi.map_files.xml_tree import cleaned
from hmi.mapping.coordinates import paths
from hmi.mapping.feature import MapFeature

_GPX = "http://www.topografix.com/GPX/1/1"


def write(features: Sequence[MapFeature], farm_id: str, farm_name: str) -> MapFile:
    """Return a GPX file; waypoints come first, as its schema wants."""
    root = Element("gpx", {"version": "1.1", "creator": "Headland", "xmlns": _GPX, "xmlns:headland": NAMESPACE})
    SubElement(SubElement(root, "metadata"), "name").text = cleaned(farm_name)
    for feature in features:
        if feature.geometry["type"] == "Point":
            lon, lat = feature.geometry["coordinates"]
            _words(SubElement(root, "wpt", lat=number(lat), lon=number(lon)), feature)
    for feature in features:
        if feature.geometry["type"] != "Point":
            _track(SubElement(root, "trk"), feature)
    return MapFile(xml_bytes(root), "application/gpx+xml", f"{stem(farm_id)}.gpx")


def _track(track: Element, feature: MapFeature) -> None:
    _words(track, feature)
    for line in paths(feature.geometry):
        segment = SubElement(track, "trkseg")
        for lon, lat in line:
            SubElement(segment, "trkpt", lat=number(lat), lon=number(lon))


def _words(element: Element, feature: MapFeature) -> None:
    SubElement(element, "name").text = cleaned(feature.name)
    SubElement(element, "type").text = feature.kind
    own = SubElement(SubElement(element, "extensions"), "headland:feature", geometry=feature.geometry["type"])
    for key, text in own_mark.written(feature):
        SubElement(own, "headland:data", name=key).text = text

"""GPX 1.0 and 1.1 (topografix.com/GPX/1/1): tracks and routes become roads or outlines, waypoints become points."""

from __future__ import annotations

import math
from typing import Any
from xml.etree.ElementTree import Element

from hmi.map_files.coordinate_system import WGS84
from hmi.map_files.own_mark import recognise
from hmi.map_files.source import Source, SourceFeature, SourceLayer
from hmi.map_files.xml_tree import child, children, text_of

NAMESPACE = "urn:headland:map:1"  # of what GPX has no place for, within its extensions
CLOSED_M = 20.0  # a walk about a field ends that near to where it began
OUTLINE_M2 = 500.0  # smaller than any field; a turn of a vehicle is not an outline
_M_PER_DEG = 111_320.0
_CLOSED = "The track ends where it began and was taken as an outline."


def read(root: Element) -> Source:
    """Return the waypoints, routes and tracks."""
    points = [_waypoint(i, element) for i, element in enumerate(children(root, "wpt"), start=1)]
    routes = [_route(i, element) for i, element in enumerate(children(root, "rte"), start=1)]
    tracks = [f for i, element in enumerate(children(root, "trk"), start=1) for f in _track(i, element)]
    return Source("gpx", [SourceLayer("", WGS84, [*points, *routes, *tracks])])


def _waypoint(n: int, element: Element) -> SourceFeature:
    feature = _feature("waypoint", n, element)
    feature.geometry = {"type": "Point", "coordinates": _position(element)}
    return feature


def _route(n: int, element: Element) -> SourceFeature:
    feature = _feature("route", n, element)
    _set_line(feature, [_position(point) for point in children(element, "rtept")])
    return feature


def _track(n: int, element: Element) -> list[SourceFeature]:
    lines = [[_position(p) for p in children(segment, "trkpt")] for segment in children(element, "trkseg")]
    first = _feature("track", n, element)
    if first.is_exact:
        kind = _told_geometry(element)
        is_single = kind == "LineString" and len(lines) == 1
        first.geometry = {"type": kind, "coordinates": lines[0] if is_single else lines}
        return [first]
    features = []
    for i, line in enumerate(line for line in lines if line):
        feature = _feature("track", n, element)
        if i > 0:
            feature.which += f", part {i + 1}"
            feature.name = f"{feature.name} ({i + 1})" if feature.name else None
        _set_line(feature, line)
        features.append(feature)
    return features or [first]


def _feature(what: str, n: int, element: Element) -> SourceFeature:
    name = text_of(child(element, "name"))
    feature = SourceFeature(f"{what} {n} ({name[:40]})" if name else f"{what} {n}", None, name=name or None)
    texts = {key: text_of(child(element, key)) for key in ("desc", "cmt", "type", "sym")}
    texts = {key: text for key, text in texts.items() if text}
    texts |= {e.get("name", ""): e.text or "" for e in _own(element)}
    recognise(feature, texts)
    if feature.is_exact:
        for key in ("desc", "cmt", "type", "sym"):
            if key not in {e.get("name") for e in _own(element)}:
                feature.properties.pop(key, None)
    return feature


def _own(element: Element) -> list[Element]:
    extensions = child(element, "extensions")
    if extensions is None:
        return []
    return [data for own in extensions.iter(f"{{{NAMESPACE}}}feature") for data in own]


def _told_geometry(element: Element) -> str:
    extensions = child(element, "extensions")
    own = None if extensions is None else extensions.find(f"{{{NAMESPACE}}}feature")
    return own.get("geometry", "LineString") if own is not None else "LineString"


def _set_line(feature: SourceFeature, line: list[list[Any]]) -> None:
    if _is_outline(line):
        closed = line if line[0] == line[-1] else [*line, line[0]]
        feature.geometry = {"type": "Polygon", "coordinates": [closed]}
        feature.problems.append(_CLOSED)
    else:
        feature.geometry = {"type": "LineString", "coordinates": line}


def _is_outline(line: list[list[Any]]) -> bool:
    if len(line) < 4 or not all(isinstance(n, float) and math.isfinite(n) for place in line for n in place):
        return False
    east = _M_PER_DEG * math.cos(math.radians(line[0][1]))
    flat = [((lon - line[0][0]) * east, (lat - line[0][1]) * _M_PER_DEG) for lon, lat in line]
    doubled = sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(flat, [*flat[1:], flat[0]], strict=True))
    return math.dist(flat[0], flat[-1]) <= CLOSED_M and abs(doubled) / 2 >= OUTLINE_M2


def _position(element: Element) -> list[Any]:
    return [_number(element.get("lon", "")), _number(element.get("lat", ""))]


def _number(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text  # the shape is refused with it

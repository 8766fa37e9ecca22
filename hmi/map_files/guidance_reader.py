"""Guidance groups and patterns of ISOXML (ISO 11783-10, annex D: GGP and GPN) as rows."""

from __future__ import annotations

import math
from typing import Any
from xml.etree.ElementTree import Element

from pyproj import Geod

from hmi.map_files.imported import Skipped
from hmi.map_files.isoxml_line import places, width_m
from hmi.map_files.source import SourceFeature
from hmi.map_files.xml_tree import child, children

LINE_M = 100.0  # how long a line is drawn that the file gives by one point and a heading
_GEOD = Geod(ellps="WGS84")
_AB, _A_PLUS, _CURVE, _PIVOT, _SPIRAL = "1", "2", "3", "4", "5"  # attribute C of GPN
TYPE_OF = {_AB: "a-b", _A_PLUS: "a-b", _CURVE: "curve", _SPIRAL: "curve"}


def group(n: int, ggp: Element, layer: str, skipped: list[Skipped], *, is_one: bool = False) -> list[SourceFeature]:
    """Return the rows of one guidance group: one feature a pattern, or one a type where only the group has a name.

    Args:
        is_one: the group was written for one feature of ours.
    """
    found = []
    for i, gpn in enumerate(children(ggp, "GPN"), start=1):
        which = f"guidance {n}.{i}"
        if gpn.get("C") == _PIVOT:
            why = "It is a circle of a pivot, which the map does not know."
            skipped.append(Skipped(f"{layer}: {which}", why, "Draw rows by hand."))
            continue
        found.append(_pattern(which, gpn, ggp.get("B")))
    if len(found) > 1 and not any(gpn.get("B") for gpn in children(ggp, "GPN")):
        types = dict.fromkeys("" if is_one else one.properties["type"] for one in found)
        same = [[one for one in found if type_ in ("", one.properties["type"])] for type_ in types]
        return [_joined(rows) if len(rows) > 1 else rows[0] for rows in same]
    return found


def _pattern(which: str, gpn: Element, group_name: str | None) -> SourceFeature:
    lsg = child(gpn, "LSG")
    line = places(lsg) if lsg is not None else []
    kind = gpn.get("C", _AB)
    properties: dict[str, Any] = {"type": TYPE_OF.get(kind, "a-b")}
    wide_m = width_m(lsg)
    if wide_m is not None:
        properties["swath_m"] = wide_m
    feature = SourceFeature(which, None, properties, gpn.get("B") or group_name, "rows")
    if kind == _A_PLUS and len(line) == 1:
        line = _ahead(line[0], gpn.get("G", ""))
        feature.problems.append(f"The file gives a point and a heading; {LINE_M:g} m of the line were drawn.")
    feature.geometry = {"type": "LineString", "coordinates": line} if line else None
    return feature


def _ahead(start: list[Any], heading: str) -> list[list[Any]]:
    """Return the line from a place along a heading in degrees clockwise from north (attribute G of GPN)."""
    try:
        lon, lat, heading_deg = float(start[0]), float(start[1]), float(heading)
        if not all(math.isfinite(n) for n in (lon, lat, heading_deg)) or abs(lat) > 90:
            return [start]
        end_lon, end_lat, _ = _GEOD.fwd(lon, lat, heading_deg, LINE_M)
    except ValueError:
        return [start]
    return [start, [float(end_lon), float(end_lat)]]


def _joined(found: list[SourceFeature]) -> SourceFeature:
    lines = [feature.geometry["coordinates"] for feature in found if feature.geometry is not None]
    first = found[0]
    first.which = first.which.rsplit(".", 1)[0]
    first.geometry = {"type": "MultiLineString", "coordinates": lines}
    first.problems = [problem for feature in found for problem in feature.problems]
    return first

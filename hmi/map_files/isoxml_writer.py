"""The farm map as ISOXML task data, version 4.3 (ISO 11783-10, annex D), in a zip with the folder TASKDATA.

Each parcel is a partfield (PFD); everything else goes into the partfield it lies in or next to. The format has room for
a kind where its types have one, 32 letters of a name, the crop, the variety and the width of a line, and for nothing
else. What loses its kind: farm, slow zone and treatment area become "other" areas, trees obstacles or windbreaks. A
point obstacle becomes an outline of its radius, so that a machine keeps away from all of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from pyproj import Geod
from shapely.geometry import shape

from hmi import __version__
from hmi.map_files.exported import MapFile, number, packed, stem, xml_bytes
from hmi.map_files.isoxml_reader import EXTERIOR, GUIDANCE, INTERIOR, ROOT
from hmi.map_files.xml_tree import cleaned
from hmi.mapping.coordinates import paths
from hmi.mapping.feature import MapFeature

DESIGNATOR_CHARS = 32
CIRCLE_CORNERS = 24  # the outline lies outside of the circle: its corners stand a little further out
_GEOD = Geod(ellps="WGS84")
_POLYGON = {"water": "3", "building": "4", "road": "5", "obstacle": "6", "farm": "8", "slow": "8", "no-go": "11",
            "treatment": "8", "hedge": "12", "tree": "12"}  # fmt: skip
_LINE = {"road": "3", "water": "6", "hedge": "7", "tree": "9"}
_POINT = {"gate": "3", "tree": "2", "home": "11"}
_GUIDANCE = {"a-b": "1", "curve": "3", "recorded": "3"}
_A, _B, _BETWEEN = "6", "7", "9"  # attribute A of the PNT of a guidance line


def write(features: Sequence[MapFeature], farm_id: str, farm_name: str) -> MapFile:
    """Return ``TASKDATA/TASKDATA.XML`` in a zip."""
    told = {
        "VersionMajor": "4",
        "VersionMinor": "3",
        "ManagementSoftwareManufacturer": "Headland",
        "ManagementSoftwareVersion": __version__[:DESIGNATOR_CHARS],
        "DataTransferOrigin": "1",
    }
    root = Element(ROOT, told)
    parcels = [feature for feature in features if feature.kind == "parcel"]
    crops = _crops(root, parcels)
    SubElement(root, "FRM", A="FRM1", B=_designator(farm_name) or "Farm")
    numbers = _Numbers()
    for parcel, inside in _shared_out(parcels, [f for f in features if f.kind != "parcel"]):
        _partfield(root, parcel, inside, crops, numbers, farm_name)
    data = packed({"TASKDATA/TASKDATA.XML": xml_bytes(root)})
    return MapFile(data, "application/zip", f"{stem(farm_id)}-isoxml.zip")


class _Numbers:
    """Gives ids such as PLN1, PLN2 (attribute of type xs:ID)."""

    def __init__(self) -> None:
        self._last: dict[str, int] = {}

    def next(self, element: str) -> str:
        self._last[element] = self._last.get(element, 0) + 1
        return f"{element}{self._last[element]}"


def _crops(root: Element, parcels: list[MapFeature]) -> dict[tuple[str, str], tuple[str, str]]:
    """Write crop types and varieties; return their ids by the names of crop and variety."""
    pairs = sorted({_crop(parcel) for parcel in parcels if _crop(parcel)[0]})
    ids: dict[tuple[str, str], tuple[str, str]] = {}
    types: dict[str, Element] = {}
    for crop, variety in pairs:
        if crop not in types:
            types[crop] = SubElement(root, "CTP", A=f"CTP{len(types) + 1}", B=crop)
        variety_id = ""
        if variety:
            variety_id = f"CVT{sum(1 for _, second in ids.values() if second) + 1}"
            SubElement(types[crop], "CVT", A=variety_id, B=variety)
        ids[crop, variety] = (types[crop].get("A", ""), variety_id)
    return ids


def _crop(parcel: MapFeature) -> tuple[str, str]:
    return _designator(parcel.properties.get("crop", "")), _designator(parcel.properties.get("species", ""))


def _shared_out(
    parcels: list[MapFeature], others: list[MapFeature]
) -> list[tuple[MapFeature | None, list[MapFeature]]]:
    """Return each parcel with what belongs to it; one group without a parcel where there is none."""
    if not parcels:
        return [(None, others)] if others else []
    outlines = [shape(parcel.geometry) for parcel in parcels]
    groups: list[list[MapFeature]] = [[] for _ in parcels]
    ids = [parcel.id for parcel in parcels]
    for other in others:
        wanted = other.properties.get("parcel_id")
        middle = shape(other.geometry).centroid
        i = ids.index(wanted) if wanted in ids else min(range(len(ids)), key=lambda k: outlines[k].distance(middle))
        groups[i].append(other)
    return list(zip(parcels, groups, strict=True))


def _partfield(
    root: Element,
    parcel: MapFeature | None,
    inside: list[MapFeature],
    crops: dict[tuple[str, str], tuple[str, str]],
    numbers: _Numbers,
    farm_name: str,
) -> None:
    title = _designator(parcel.title if parcel else farm_name) or "Field"
    told = {"A": numbers.next("PFD"), "C": title, "D": "0", "F": "FRM1"}
    if parcel is not None:
        told["D"] = str(round(abs(_GEOD.geometry_area_perimeter(shape(parcel.geometry))[0])))
        crop, variety = crops.get(_crop(parcel), ("", ""))
        told |= {key: value for key, value in (("G", crop), ("H", variety)) if value}
    partfield = SubElement(root, "PFD", told)
    if parcel is not None:
        _polygon(partfield, "1", "", paths(parcel.geometry), numbers)
    areas = [f for f in inside if f.geometry["type"] == "Polygon" or f.kind == "obstacle"]
    lines = [f for f in inside if f.geometry["type"] == "LineString" and f.kind != "rows"]
    for area in areas:
        rings = paths(area.geometry) if area.geometry["type"] == "Polygon" else [_circle(area)]
        _polygon(partfield, _POLYGON[area.kind], area.name, rings, numbers)
    for line in lines:
        _line(partfield, line)
    for point in inside:
        if point.kind in _POINT and point.geometry["type"] == "Point":
            _place(partfield, _POINT[point.kind], point.geometry["coordinates"], _designator(point.name))
    for rows in inside:
        if rows.kind == "rows":
            _guidance(partfield, rows, numbers)


def _polygon(partfield: Element, kind: str, name: str, rings: list[list[list[float]]], numbers: _Numbers) -> None:
    told = {"A": kind, "B": _designator(name), "E": numbers.next("PLN")}
    polygon = SubElement(partfield, "PLN", {key: value for key, value in told.items() if value})
    for i, ring in enumerate(rings):
        outline = SubElement(polygon, "LSG", A=EXTERIOR if i == 0 else INTERIOR)
        for position in ring:
            _place(outline, "2", position)


def _line(partfield: Element, feature: MapFeature) -> None:
    told = {"A": _LINE[feature.kind], "B": _designator(feature.name), "C": _millimetres(feature, "width_m")}
    line = SubElement(partfield, "LSG", {key: value for key, value in told.items() if value})
    for position in feature.geometry["coordinates"]:
        _place(line, "2", position)


def _guidance(partfield: Element, rows: MapFeature, numbers: _Numbers) -> None:
    group = SubElement(partfield, "GGP", A=numbers.next("GGP"), B=_designator(rows.title))
    for line in paths(rows.geometry):
        kind = _GUIDANCE.get(str(rows.properties.get("type", "")), "1" if len(line) == 2 else "3")
        pattern = SubElement(group, "GPN", A=numbers.next("GPN"), C=kind)
        told = {"A": GUIDANCE, "C": _millimetres(rows, "swath_m")}
        drawn = SubElement(pattern, "LSG", {key: value for key, value in told.items() if value})
        for i, position in enumerate(line):
            _place(drawn, _A if i == 0 else _B if i == len(line) - 1 else _BETWEEN, position)


def _place(holder: Element, kind: str, position: list[float], name: str = "") -> None:
    told = {"A": kind, "B": name, "C": number(position[1]), "D": number(position[0])}
    SubElement(holder, "PNT", {key: value for key, value in told.items() if value})


def _circle(feature: MapFeature) -> list[list[float]]:
    lon, lat = feature.geometry["coordinates"]
    out_m = float(feature.properties["radius_m"]) / math.cos(math.pi / CIRCLE_CORNERS)
    headings = [-360.0 * i / CIRCLE_CORNERS for i in range(CIRCLE_CORNERS)]
    corners = [_GEOD.fwd(lon, lat, heading, out_m)[:2] for heading in headings]
    ring = [[float(x), float(y)] for x, y in corners]
    return [*ring, ring[0]]


def _millimetres(feature: MapFeature, key: str) -> str:
    value = feature.properties.get(key)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool) and 0 < value < 1e6
    return str(round(value * 1000)) if is_number and value is not None else ""


def _designator(text: object) -> str:
    return " ".join(cleaned(str(text)).split())[:DESIGNATOR_CHARS].strip()

"""The farm map as ISOXML task data, version 4.3 (ISO 11783-10, annex D), in a zip with the folder TASKDATA.

Each parcel is a partfield (PFD); everything else goes into the partfield it lies in or next to. The format has room for
a kind where its types have one, 32 letters of a name, the crop, the variety and the width of a line. To other programs
farm, slow zone and treatment area are "other" areas, trees obstacles or windbreaks, and a point obstacle is an
outline of its radius, so that a machine keeps away from all of it. Everything else goes beside it, see ``isoxml_own``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from pyproj import Geod
from shapely.geometry import shape

from hmi import __version__
from hmi.map_files import isoxml_own
from hmi.map_files.exported import MapFile, json_bytes, number, packed, stem, xml_bytes
from hmi.map_files.isoxml_own import DESIGNATOR_CHARS, circle, designator, told_crop
from hmi.map_files.isoxml_reader import EXTERIOR, GUIDANCE, INTERIOR, ROOT
from hmi.mapping.coordinates import paths
from hmi.mapping.feature import MapFeature

_GEOD = Geod(ellps="WGS84")
_OTHER = "8"
_POLYGON = {"water": "3", "building": "4", "road": "5", "obstacle": "6", "farm": "8", "slow": "8", "no-go": "11",
            "treatment": "8", "hedge": "12", "tree": "12"}  # fmt: skip
_LINE = {"road": "3", "water": "6", "hedge": "7", "tree": "9"}
_POINT = {"gate": "3", "tree": "2", "home": "11"}
_AB, _CURVE = "1", "3"  # attribute C of a GPN; an A-B line has these two points and no more
_GUIDANCE = {"curve": _CURVE, "recorded": _CURVE}
_A, _B, _BETWEEN = "6", "7", "9"  # attribute A of the PNT of a guidance line
_BOTH_SIDES, _NO_SIDE = "1", "4"  # attribute E of a GPN: on which side its parallels lie
_BOTH_ENDS, _NO_END = "1", "4"  # attribute F of a GPN: at which ends it is driven on straight


def write(features: Sequence[MapFeature], farm_id: str, farm_name: str) -> MapFile:
    """Return ``TASKDATA/TASKDATA.XML`` in a zip, with what it has no place for in a file beside it."""
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
    SubElement(root, "FRM", A="FRM1", B=designator(farm_name) or "Farm")
    numbers = _Numbers()
    for parcel, inside in _shared_out(parcels, [f for f in features if f.kind != "parcel"]):
        _partfield(root, parcel, inside, crops, numbers, farm_name)
    SubElement(root, "AFE", A=isoxml_own.FILE, B="1", C="", D=isoxml_own.FILE_TYPE)
    own = {"headland": isoxml_own.VERSION, "features": numbers.entries}
    files = {"TASKDATA/TASKDATA.XML": xml_bytes(root), f"TASKDATA/{isoxml_own.FILE}": json_bytes(own)}
    data = packed(files)
    return MapFile(data, "application/zip", f"{stem(farm_id)}-isoxml.zip")


class _Numbers:
    """Gives ids such as PLN1, PLN2 (attribute of type xs:ID), and notes whose they are."""

    def __init__(self) -> None:
        self._last: dict[str, int] = {}
        self.entries: dict[str, dict[str, Any]] = {}

    def of(self, element: str, feature: MapFeature, called: str) -> str:
        """Return a new id for an element; the feature's entry stands under it."""
        own = self.next(element)
        self.entries[own] = isoxml_own.entry(feature, called)
        return own

    def next(self, element: str) -> str:
        self._last[element] = self._last.get(element, 0) + 1
        return f"{element}{self._last[element]}"


def _crops(root: Element, parcels: list[MapFeature]) -> dict[tuple[str, str], tuple[str, str]]:
    """Write crop types and varieties; return their ids by the names of crop and variety."""
    pairs = sorted({told_crop(parcel) for parcel in parcels if told_crop(parcel)[0]})
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
    title = designator(parcel.title if parcel else farm_name) or "Field"
    told = {"A": numbers.next("PFD"), "C": title, "D": "0", "F": "FRM1"}
    if parcel is not None:
        told["D"] = str(round(abs(_GEOD.geometry_area_perimeter(shape(parcel.geometry))[0])))
        crop, variety = crops.get(told_crop(parcel), ("", ""))
        told |= {key: value for key, value in (("G", crop), ("H", variety)) if value}
    partfield = SubElement(root, "PFD", told)
    if parcel is not None:
        _polygon(partfield, "1", "", paths(parcel.geometry), numbers.of("PLN", parcel, title))
    areas = [f for f in inside if f.geometry["type"] == "Polygon" or f.kind == "obstacle"]
    lines = [f for f in inside if f.geometry["type"] == "LineString" and f.kind != "rows"]
    for area in areas:
        rings = paths(area.geometry) if area.geometry["type"] == "Polygon" else [circle(area)]
        name = designator(area.name)
        _polygon(partfield, _POLYGON.get(area.kind, _OTHER), name, rings, numbers.of("PLN", area, name))
    for line in lines:
        _line(partfield, line, numbers)
    for point in inside:
        if point.kind in _POINT and point.geometry["type"] == "Point":
            name = designator(point.name)
            own = numbers.of("PNT", point, name)
            _place(partfield, _POINT[point.kind], point.geometry["coordinates"], name, own)
    for rows in inside:
        if rows.kind == "rows":
            _guidance(partfield, rows, numbers)


def _polygon(partfield: Element, kind: str, name: str, rings: list[list[list[float]]], own: str) -> None:
    told = {"A": kind, "B": name, "E": own}
    polygon = SubElement(partfield, "PLN", {key: value for key, value in told.items() if value})
    for i, ring in enumerate(rings):
        outline = SubElement(polygon, "LSG", A=EXTERIOR if i == 0 else INTERIOR)
        for position in ring:
            _place(outline, "2", position)


def _line(partfield: Element, feature: MapFeature, numbers: _Numbers) -> None:
    name = designator(feature.name)
    told = {
        "A": _LINE[feature.kind],
        "B": name,
        "C": _millimetres(feature, "width_m"),
        "F": numbers.of("LSG", feature, name),
    }
    line = SubElement(partfield, "LSG", {key: value for key, value in told.items() if value})
    for position in feature.geometry["coordinates"]:
        _place(line, "2", position)


def _guidance(partfield: Element, rows: MapFeature, numbers: _Numbers) -> None:
    name = designator(rows.title)
    group = SubElement(partfield, "GGP", A=numbers.of("GGP", rows, name), B=name)
    lines = paths(rows.geometry)
    is_recorded = rows.properties.get("type") == "recorded"  # each row stands for itself
    reach = {"E": _NO_SIDE, "F": _NO_END} if is_recorded else {"E": _BOTH_SIDES, "F": _BOTH_ENDS}
    for line in lines:
        kind = _CURVE if len(line) > 2 else _GUIDANCE.get(str(rows.properties.get("type", "")), _AB)
        told = {"A": numbers.next("GPN"), "B": name if len(lines) == 1 else "", "C": kind, **reach}
        pattern = SubElement(group, "GPN", {key: value for key, value in told.items() if value})
        told = {"A": GUIDANCE, "C": _millimetres(rows, "swath_m")}
        drawn = SubElement(pattern, "LSG", {key: value for key, value in told.items() if value})
        for i, position in enumerate(line):
            _place(drawn, _A if i == 0 else _B if i == len(line) - 1 else _BETWEEN, position)


def _place(holder: Element, kind: str, position: list[float], name: str = "", own: str = "") -> None:
    told = {"A": kind, "B": name, "C": number(position[1]), "D": number(position[0]), "G": own}
    SubElement(holder, "PNT", {key: value for key, value in told.items() if value})


def _millimetres(feature: MapFeature, key: str) -> str:
    value = feature.properties.get(key)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool) and 0 < value < 1e6
    return str(round(value * 1000)) if is_number and value is not None else ""

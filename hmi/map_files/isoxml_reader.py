"""ISOXML task data (ISO 11783-10, annex D): partfields with what lies in them, and guidance lines.

Read are PFD with PLN, LSG and PNT, GGP with GPN, and CTP, CVT and FRM for names, of versions 2 to 4; files that an XFR
element names are read from the same archive.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any
from xml.etree.ElementTree import Element

from hmi.map_files import guidance_reader, isoxml_own
from hmi.map_files.archive import Archive
from hmi.map_files.coordinate_system import WGS84
from hmi.map_files.errors import BadMapFile
from hmi.map_files.imported import Skipped
from hmi.map_files.isoxml_line import Places, binary_file, is_inside, place, places, ring, width_m
from hmi.map_files.source import Source, SourceFeature, SourceLayer
from hmi.map_files.xml_tree import children, local, parse

ROOT = "ISO11783_TaskData"
EXTERNAL_ROOT = "XFC"
# attribute A of PLN, LSG and PNT
KIND_OF_POLYGON = {"1": "parcel", "2": "parcel", "3": "water", "4": "building", "5": "road", "6": "obstacle",
                   "9": "parcel", "10": "parcel", "11": "no-go", "12": "hedge"}  # fmt: skip
# tramline, drain, fence and obstacle; a sampling route (4) and a line of remarks (8) are no things on the ground
KIND_OF_LINE = {"3": "road", "6": "water", "7": "hedge", "9": "tree"}
KIND_OF_POINT = {"1": "obstacle", "2": "tree", "3": "gate", "4": "home", "5": "obstacle", "11": "home"}
BOUNDARY = "1"  # attribute A of a PLN
EXTERIOR, INTERIOR = "1", "2"  # attribute A of an LSG in a PLN
GUIDANCE = "5"  # attribute A of an LSG in a GPN
_EXTERNAL = re.compile(r"^[A-Z]{3}[0-9]{5}$")  # attribute A of XFR
_MENDABLE = {"broken_xml", "damaged_archive", "not_a_map"}  # one such file does not spoil the others
_PART = {"2": "treatment zone", "7": "flagged area", "8": "area", "9": "main field", "10": "headland"}


def read(root: Element, archive: Archive | None = None, path: str = "") -> Source:
    """Return the partfields of task data.

    Args:
        archive, path: where the task data lies, for the files it refers to.

    Raises:
        BadMapFile: a file it refers to is refused as unsafe.
    """
    source = Source("isoxml", [], _not_read(archive, path))
    roots = [root, *_external(root, archive, path, source.skipped)]
    elements = [element for one in roots for element in one]
    names = {element.get("A", ""): element.get("B", "") for element in _all(elements, "CTP", "FRM")}
    names |= {cvt.get("A", ""): cvt.get("B", "") for ctp in _all(elements, "CTP") for cvt in children(ctp, "CVT")}
    own = isoxml_own.read(root, archive, path)
    for i, partfield in enumerate(_all(elements, "PFD"), start=1):
        source.layers.append(_partfield(i, partfield, names, source.skipped, own))
    return source


def task_data_path(archive: Archive) -> str | None:
    """Return the path of TASKDATA.XML, in any case and folder, the least deep first."""
    return min(_task_data(archive), key=lambda name: (name.count("/"), name), default=None)


def _task_data(archive: Archive) -> list[str]:
    return [name for name in archive.ending("taskdata.xml") if _base(name).lower() == "taskdata.xml"]


def _not_read(archive: Archive | None, path: str) -> list[Skipped]:
    why = "The archive holds several task data, and one is read at a time."
    others = [name for name in _task_data(archive) if name != path] if archive is not None else []
    return [Skipped(name[:80], why, "Pack its folder into a zip of its own.") for name in others]


def _all(elements: list[Element], *names: str) -> Iterator[Element]:
    return (element for element in elements if local(element) in names)


def _base(path: str) -> str:
    return path.replace("\\", "/").rsplit("/", 1)[-1]


def _external(root: Element, archive: Archive | None, path: str, skipped: list[Skipped]) -> Iterator[Element]:
    folder = path[: len(path) - len(_base(path))]
    seen: set[str] = set()
    for reference in children(root, "XFR"):
        stem = reference.get("A", "").upper().removesuffix(".XML")
        if not _EXTERNAL.match(stem) or stem in seen:
            continue
        seen.add(stem)
        names = archive.names if archive is not None else []
        found = [name for name in names if name.lower() == f"{folder}{stem}.xml".lower()]
        if found and archive is not None:
            try:
                yield _part(archive, found[0])
            except BadMapFile as error:
                if error.code not in _MENDABLE:
                    raise
                skipped.append(Skipped(f"{stem}.XML", error.text, "Export the task data once more."))
        elif stem.startswith("PFD"):
            why = "The task data refers to this file, and it is not there."
            skipped.append(Skipped(f"{stem}.XML", why, "Pack the whole TASKDATA folder into one zip."))


def _part(archive: Archive, name: str) -> Element:
    external = parse(archive.read(name))
    if local(external) != EXTERNAL_ROOT:
        raise BadMapFile("not_a_map", "The file is not part of task data.")
    return external


def _partfield(
    n: int, pfd: Element, names: dict[str, str], skipped: list[Skipped], own: isoxml_own.Entries
) -> SourceLayer:
    title = pfd.get("C") or pfd.get("B") or f"Field {n}"
    layer = SourceLayer(f"field {n} ({title[:40]})", WGS84, [])
    for i, pln in enumerate(_readable(pfd, "PLN", "area", layer.name, skipped), start=1):
        area = _polygon(i, pln, _called(pfd, pln, title), _crop(pfd, names))
        layer.features.append(isoxml_own.restore(area, pln.get("E"), own))
    for i, lsg in enumerate(_readable(pfd, "LSG", "line", layer.name, skipped), start=1):
        layer.features.append(isoxml_own.restore(_line(i, lsg), lsg.get("F"), own))
    for i, pnt in enumerate(_readable(pfd, "PNT", "point", layer.name, skipped), start=1):
        if pnt.get("A") != "10":  # the reference point of the field is no thing on it
            layer.features.append(isoxml_own.restore(_point(i, pnt), pnt.get("G"), own))
    for i, ggp in enumerate(_readable(pfd, "GGP", "guidance", layer.name, skipped), start=1):
        told = ggp.get("A")
        rows = guidance_reader.group(i, ggp, layer.name, skipped, is_one=told in own)
        layer.features += [isoxml_own.restore(one, told if len(rows) == 1 else None, own) for one in rows]
    for feature in layer.features:
        feature.site = n
    if not own and next(children(pfd, "PLN"), None) is None:  # ours may have no field at all
        why = "It has no boundary in the file; " + (
            "what lies in it was read." if layer.features else "it is a name only."
        )
        skipped.append(Skipped(layer.name, why, "Draw its edge or walk it, or export it with its boundary."))
    return layer


def _called(pfd: Element, pln: Element, title: str) -> str:
    """Return what people call a field: its name; programs call boundaries "Boundary" or "1", of several both count."""
    own = pln.get("B")
    if not own or own == title:
        return title
    if not (pfd.get("C") or pfd.get("B")):
        return own
    return title if sum(one.get("A", BOUNDARY) == BOUNDARY for one in children(pfd, "PLN")) < 2 else f"{title}, {own}"


def _readable(pfd: Element, name: str, word: str, layer: str, skipped: list[Skipped]) -> Iterator[Element]:
    """Yield the elements whose corners stand in the task data, and name the others."""
    for i, element in enumerate(children(pfd, name), start=1):
        file = binary_file(element)
        if file is None:
            yield element
        else:
            why = f"Its corners are in a binary file ({file[:40]}), which is not read."
            skipped.append(Skipped(f"{layer}: {word} {i}", why, "Export the task data with the corners as XML."))


def _crop(pfd: Element, names: dict[str, str]) -> dict[str, str]:
    told = {"crop": names.get(pfd.get("G", "")), "species": names.get(pfd.get("H", "")), "field_code": pfd.get("B")}
    return {key: value for key, value in told.items() if value}


def _polygon(n: int, pln: Element, title: str, crop: dict[str, str]) -> SourceFeature:
    told = pln.get("A", BOUNDARY)
    name = title if told in {BOUNDARY, "9"} else pln.get("B")
    feature = SourceFeature(f"area {n}", _rings(pln), name=name, kind=KIND_OF_POLYGON.get(told))
    if feature.kind == "parcel":
        feature.properties = dict(crop)
    if told in _PART:
        feature.problems.append(f"The file calls it a {_PART[told]}; choose what it is.")
    return feature


def _rings(pln: Element) -> Any:
    """Return a polygon, or several where version 3 puts several outlines into one PLN."""
    outer = [ring(lsg) for lsg in children(pln, "LSG") if lsg.get("A") != INTERIOR]
    holes = [ring(lsg) for lsg in children(pln, "LSG") if lsg.get("A") == INTERIOR]
    if len(outer) == 1:
        return {"type": "Polygon", "coordinates": [outer[0], *holes]}
    if not outer:
        return None
    return {"type": "MultiPolygon", "coordinates": [[o, *(h for h in holes if _owner(h, outer) is o)] for o in outer]}


def _owner(hole: Places, outer: list[Places]) -> Places | None:
    return next((outline for outline in outer if hole and is_inside(hole[0], outline)), None)


def _line(n: int, lsg: Element) -> SourceFeature:
    kind = "rows" if lsg.get("A") == GUIDANCE else KIND_OF_LINE.get(lsg.get("A", ""))
    geometry = {"type": "LineString", "coordinates": places(lsg)}
    feature = SourceFeature(f"line {n}", geometry, name=lsg.get("B"), kind=kind)
    wide_m = width_m(lsg)
    if wide_m is not None:
        feature.properties["width_m"] = wide_m
    return feature


def _point(n: int, pnt: Element) -> SourceFeature:
    kind = KIND_OF_POINT.get(pnt.get("A", ""))
    return SourceFeature(f"point {n}", {"type": "Point", "coordinates": place(pnt)}, name=pnt.get("B"), kind=kind)

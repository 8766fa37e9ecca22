"""Points and lines of ISOXML (ISO 11783-10, annex D: PNT and LSG)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any
from xml.etree.ElementTree import Element

from hmi.map_files.xml_tree import children, local

Places = list[list[Any]]
_TRACE = 1e-12


def place(pnt: Element) -> list[Any]:
    """Return longitude and latitude of a PNT: D is east, C is north; what is no number stays text."""
    return [_number(pnt.get("D", "")), _number(pnt.get("C", ""))]


def places(lsg: Element) -> Places:
    """Return the points of an LSG."""
    return [place(pnt) for pnt in children(lsg, "PNT")]


def ring(lsg: Element) -> Places:
    """Return the points of an LSG that bounds a PLN, closed: version 3 leaves the last edge out."""
    points = places(lsg)
    return [*points, points[0]] if points and points[0] != points[-1] else points


def binary_file(element: Element) -> str | None:
    """Return the name of the file that holds corners of an element in binary (attribute I of PNT), or None."""
    points = (one for one in element.iter() if local(one) == "PNT" and one.get("I") and not one.get("C"))
    return next((f"{one.get('I')}.bin" for one in points), None)


def width_m(lsg: Element | None) -> float | None:
    """Return attribute C of an LSG, millimetres in the file, or None where it says nothing."""
    text = lsg.get("C", "") if lsg is not None else ""
    is_number = text.isascii() and text.isdigit() and len(text) < 9
    return int(text) / 1000 if is_number and int(text) > 0 else None


def is_inside(point: list[Any], outline: Places) -> bool:
    """Say whether a place lies in a ring, by counting the edges to its east."""
    if not all(isinstance(n, float) for p in (point, *outline) for n in p):
        return False
    is_in = False
    for (x1, y1), (x2, y2) in pairwise(outline):
        if (y1 > point[1]) != (y2 > point[1]) and point[0] < (x2 - x1) * (point[1] - y1) / (y2 - y1 or _TRACE) + x1:
            is_in = not is_in
    return is_in


def _number(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text  # the shape is refused with it

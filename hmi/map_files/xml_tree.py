"""XML from strangers: no document types, no entities, nothing fetched."""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element, ParseError  # names only; parsing is done by defusedxml

from defusedxml import DefusedXmlException, ElementTree

from hmi.map_files.errors import BadMapFile

_UNCLEAN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff\u2028\u2029]")
DEPTH = 200  # elements within elements; KML folders may be nested, and never that deep


def parse(data: bytes) -> Element:
    """Return the root.

    Raises:
        BadMapFile: ``broken_xml``, or ``unsafe_xml`` where it declares a document type or entities.
    """
    try:
        root: Element = ElementTree.fromstring(data, forbid_dtd=True, forbid_entities=True, forbid_external=True)
    except DefusedXmlException as error:
        text = "The file declares a document type or entities, which maps do not need. It is refused."
        raise BadMapFile("unsafe_xml", text) from error
    except (ParseError, ValueError, LookupError, OverflowError) as error:
        where = f" in line {error.position[0]}" if isinstance(error, ParseError) else ""
        text = f"The XML is broken{where}, or the file is cut off. Export or download it once more."
        raise BadMapFile("broken_xml", text) from error
    _check_depth(root)
    return root


def local(element: Element) -> str:
    """Return the name without its namespace."""
    return str(element.tag).rsplit("}", 1)[-1]


def children(element: Element, *names: str) -> Iterator[Element]:
    """Yield the direct children with one of the local ``names``; all without names."""
    return (child for child in element if not names or local(child) in names)


def child(element: Element, name: str) -> Element | None:
    """Return the first direct child of that local name."""
    return next(children(element, name), None)


def text_of(element: Element | None) -> str:
    """Return the stripped text, empty where there is none."""
    return (element.text or "").strip() if element is not None else ""


def is_clean(text: str) -> bool:
    """Say whether XML 1.0 can hold the text as it is (section 2.2, and 2.11 on line ends)."""
    return _UNCLEAN.search(text) is None


def cleaned(text: str) -> str:
    """Return the text without what XML 1.0 cannot hold."""
    return _UNCLEAN.sub("", text)


def _check_depth(root: Element) -> None:
    level, depth = [root], 0
    while level:
        depth += 1
        if depth > DEPTH:
            raise BadMapFile("broken_xml", "The XML is nested too deeply for a map. It is refused.")
        level = [below for element in level for below in element]

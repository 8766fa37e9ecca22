"""The mark by which files of this program are known again, so that names and values come back as they were.

In KML and GPX a feature of ours carries its id and kind and the attribute ``_headland``; its other attributes are
written as ``attribute_text`` says.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from hmi.map_files.attribute_text import decode, encode
from hmi.map_files.attributes import usable_id
from hmi.map_files.kind_guess import ALL_KINDS
from hmi.map_files.source import SourceFeature
from hmi.map_files.xml_tree import is_clean
from hmi.mapping.feature import MapFeature

MARK = "_headland"
VERSION = "1"


def written(feature: MapFeature) -> Iterator[tuple[str, str]]:
    """Yield the attributes to write, as text; the name only where its own element would change it."""
    yield "id", feature.id
    yield "kind", feature.kind
    if not feature.name or feature.name != feature.name.strip() or not is_clean(feature.name):
        yield "name", encode(feature.name)
    for key, value in sorted(feature.properties.items()):
        yield key, encode(value)
    yield MARK, VERSION


def recognise(feature: SourceFeature, texts: Mapping[str, str]) -> None:
    """Make ``feature`` exact if its attributes ``texts`` bear the mark; else keep them as text."""
    kind, own_id = texts.get("kind"), usable_id(texts.get("id"))
    if texts.get(MARK) != VERSION or kind not in ALL_KINDS or own_id is None:
        feature.properties = dict(texts)
        return
    feature.is_exact, feature.kind, feature.id = True, kind, own_id
    rest = {key: decode(text) for key, text in texts.items() if key not in {MARK, "id", "kind", "name"}}
    feature.properties = rest
    if "name" in texts:
        name = decode(texts["name"])
        feature.name = name if isinstance(name, str) else texts["name"]
    feature.name = feature.name or ""

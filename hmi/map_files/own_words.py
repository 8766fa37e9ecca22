"""Own attributes checked by the rules of the map, such that what was imported can also be taken."""

from __future__ import annotations

from typing import Any

from hmi.map_files.imported import Geometry
from hmi.mapping.errors import BadFeature
from hmi.mapping.feature import check_given, parse_feature

RADIUS_M = 1.0  # of a point obstacle that comes without one; the operator is told
_SMALLEST = {
    "Point": [0, 0],
    "LineString": [[0, 0], [1, 1]],
    "MultiLineString": [[[0, 0], [1, 1]]],
    "Polygon": [[[0, 0], [1, 0], [1, 1], [0, 0]]],
}
_TRIES = 20
_FEWER = 30  # attributes that are kept where all together are too long


def settled(kind: str, geometry: Geometry, properties: dict[str, Any], problems: list[str]) -> dict[str, Any]:
    """Return the properties that a feature of ``kind`` may have; append what was put aside, and why."""
    kept = dict(properties)
    stand_in = {"type": geometry["type"], "coordinates": _SMALLEST[geometry["type"]]}  # the shape itself is fit already
    for _ in range(_TRIES):
        head = {"id": "x", "kind": kind, "name": ""}
        try:
            feature = parse_feature({"type": "Feature", "properties": {**kept, **head}, "geometry": stand_in})
            check_given(feature)
            return feature.properties
        except BadFeature as error:
            key = error.code.removeprefix("bad_")
            sentence = error.text.removeprefix("x: ")
            if key in kept:
                problems.append(f"{sentence.split('. ')[0]}. It was put aside.")
                kept[f"{key}_as_given"] = kept.pop(key)
            elif key == "radius_m":
                problems.append(f"The file gives no radius; {RADIUS_M:g} m was assumed. Check it.")
                kept["radius_m"] = RADIUS_M
            elif error.code == "too_large" and len(kept) > _FEWER:
                problems.append(f"Its attributes are too long together; the first {_FEWER} were kept.")
                kept = dict(list(kept.items())[:_FEWER])
            else:
                break
    return {}

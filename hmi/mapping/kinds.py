"""The kinds of features and what shape each may have (docs/protocols/map.md)."""

from __future__ import annotations

from types import MappingProxyType
from typing import NamedTuple

POLYGON, LINE, LINES, POINT = "Polygon", "LineString", "MultiLineString", "Point"


class Kind(NamedTuple):
    """One kind of feature.

    Args:
        noun: what a farmer calls it, in a sentence.
        geometries: allowed GeoJSON types, the usual one first.
        attributes: own properties; all others are kept as they come.
    """

    noun: str
    geometries: tuple[str, ...]
    attributes: tuple[str, ...] = ()


_PARCEL = (
    "crop", "species", "status", "seeded", "row_spacing_m", "row_bearing_deg", "headland_m", "category", "type",
    "soil_type", "valid_from",
)  # fmt: skip

KINDS: MappingProxyType[str, Kind] = MappingProxyType(
    {
        "farm": Kind("farm", (POLYGON,)),
        "parcel": Kind("parcel", (POLYGON,), _PARCEL),
        "obstacle": Kind("obstacle", (POLYGON, POINT), ("radius_m", "height_m")),
        "road": Kind("road", (LINE, POLYGON), ("width_m",)),
        "building": Kind("building", (POLYGON,), ("category", "height_m")),
        "home": Kind("home", (POINT,), ("heading_deg", "type", "robot")),
        "gate": Kind("gate", (POINT,), ("width_m",)),
        "no-go": Kind("keep-out zone", (POLYGON,)),
        "slow": Kind("slow zone", (POLYGON,), ("speed_mps",)),
        "treatment": Kind("treatment area", (POLYGON,), ("dose",)),
        "rows": Kind("rows", (LINE, LINES), ("parcel_id", "type")),
        "tree": Kind("tree", (POLYGON, LINE, POINT), ("width_m", "radius_m", "height_m")),
        "hedge": Kind("hedge", (POLYGON, LINE), ("width_m", "height_m")),
        "water": Kind("water", (POLYGON, LINE), ("width_m",)),
    }
)

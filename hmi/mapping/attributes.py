"""The attributes of features: which values each may have; what is not known here is kept as it comes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import date
from typing import Any, NamedTuple

from hmi.domain.ids import is_id
from hmi.domain.map_ground import HIGHEST_M
from hmi.mapping.errors import BadFeature
from hmi.mapping.kinds import KINDS, POINT

LONGEST_NAME = 80  # of a feature; a robot is told names of fields, and takes no longer ones
LONGEST_TEXT = 200
LARGEST_BYTES = 32_768  # of one feature's properties as JSON: a note of some pages, never a picture
DEEPEST = 8


HEIGHT = "height_m"
"""Above the ground, of what can be flown over."""


class Range(NamedTuple):
    """Allowed numbers: from ``least`` (itself only if ``is_least_allowed``) to ``most``, in ``unit``."""

    label: str
    least: float
    most: float
    unit: str
    is_least_allowed: bool = False


RANGES = {
    "row_spacing_m": Range("Row spacing", 0, 10, "m"),
    "row_bearing_deg": Range("Row direction", 0, 360, "degrees", True),
    "headland_m": Range("Headland", 0, 200, "m", True),
    "radius_m": Range("Radius", 0, 1000, "m"),
    "width_m": Range("Width", 0, 200, "m"),
    HEIGHT: Range("Height", 0, HIGHEST_M, "m"),
    "heading_deg": Range("Heading", -360, 360, "degrees", True),
    "speed_mps": Range("Speed", 0, 20, "m/s"),
    "dose": Range("Dose", 0, 2, "times the usual one", True),
}
TYPES = {"home": ("home", "garage", "charging"), "rows": ("a-b", "curve", "recorded")}
TEXTS = {"crop": "Crop", "species": "Species", "status": "Growth stage", "category": "Category", "type": "Type",
         "soil_type": "Soil"}  # fmt: skip
VALID_FROM = "valid_from"
"""Own attribute of parcels: the day, by attribute, from which its value holds."""
DATED = ("crop", "species", "status", "seeded", "row_spacing_m", "row_bearing_deg", "headland_m")
IDS = {"parcel_id": "Parcel", "robot": "Robot"}
LABELS = {
    "name": "Name",
    "seeded": "Seeded",
    VALID_FROM: "Valid from",
    "parcel_id": "Parcel",
    "robot": "Robot",
    **TEXTS,
    **{key: one.label for key, one in RANGES.items()},
}
"""What people call them, where it is not the key itself."""


def parse_attributes(kind: str, geometry_type: str, raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return the properties to keep; own attributes without a value are left out.

    A height that cannot be one is let in: maps of before may have it from a file. ``check_height`` is for new ones.

    Raises:
        BadFeature: an own attribute has a value it cannot have, or the rest is no JSON or too large.
    """
    own = KINDS[kind].attributes
    kept = {key: value for key, value in raw.items() if not (key in own and value is None)}
    for key in own:
        if key in kept and key != HEIGHT:
            _check(kind, key, kept[key])
    if kind == "obstacle" and geometry_type == POINT and "radius_m" not in kept:
        raise _bad("radius_m", "A point obstacle needs a radius. Give it one in metres, or draw its outline.")
    return _plain_json(kept)


def check_height(kind: str, properties: Mapping[str, Any]) -> None:
    """Return if the height is one, or there is none.

    Raises:
        BadFeature: it is not.
    """
    if HEIGHT in KINDS[kind].attributes and HEIGHT in properties:
        _check_number(HEIGHT, properties[HEIGHT])


def _check(kind: str, key: str, value: object) -> None:
    if key in RANGES:
        _check_number(key, value)
    elif key == "seeded":
        _check_date("seeded", "Seeded", value)
    elif key == VALID_FROM:
        _check_days(value)
    elif key in IDS:
        if not isinstance(value, str) or not is_id(value):
            raise _bad(key, f"{IDS[key]} is {_shown(value)}. Give an id such as north-2.")
    elif key == "type" and kind in TYPES:
        if value not in TYPES[kind]:
            raise _bad(key, f"Type is {_shown(value)}. Choose {', '.join(TYPES[kind][:-1])} or {TYPES[kind][-1]}.")
    elif not isinstance(value, str) or len(value) > LONGEST_TEXT:
        raise _bad(key, f"{TEXTS[key]} is {_shown(value)}. Give a text of at most {LONGEST_TEXT} letters.")


def _check_number(key: str, value: object) -> None:
    allowed = RANGES[key]
    shown = _shown(value)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        above = value >= allowed.least if allowed.is_least_allowed else value > allowed.least
        if above and value <= allowed.most:
            return
        shown = f"{shown} {allowed.unit}" if abs(value) <= 10**15 else shown
    least = f"from {allowed.least:g}" if allowed.is_least_allowed else f"above {allowed.least:g}"
    raise _bad(key, f"{allowed.label} is {shown}. Give a number {least}, at most {allowed.most:g} {allowed.unit}.")


def _check_date(key: str, label: str, value: object) -> None:
    try:
        if not isinstance(value, str) or len(value) != 10:
            raise ValueError
        year = date.fromisoformat(value).year
    except ValueError:
        raise _bad(key, f"{label} is {_shown(value)}. Give a date such as 2026-04-08.") from None
    if not 1900 <= year <= 2200:
        raise _bad(key, f"{label} is {value}. Check the year.")


def _check_days(value: object) -> None:
    if not isinstance(value, dict) or not all(key in DATED for key in value):
        raise _bad(VALID_FROM, f"Valid from is {_shown(value)}. Give a day for {', '.join(DATED[:-1])} or {DATED[-1]}.")
    for key, day in value.items():
        _check_date(VALID_FROM, f"{key} valid from", day)


def _plain_json(kept: Mapping[str, Any]) -> dict[str, Any]:
    if not all(isinstance(key, str) and 0 < len(key) <= 64 for key in kept):
        raise BadFeature("bad_attribute", "A property has a name that is empty or longer than 64 letters. Rename it.")
    if any(_depth(value) > DEEPEST for value in kept.values()):
        raise BadFeature("too_large", f"Its properties are nested deeper than {DEEPEST} levels. Leave some out.")
    try:
        text = json.dumps(kept, allow_nan=False, ensure_ascii=False)
        size = len(text.encode("utf-8"))
    except (TypeError, ValueError) as error:
        raise BadFeature(
            "bad_attribute", "A property is neither text, number, list nor table, or not finite. Leave it out."
        ) from error
    if size > LARGEST_BYTES:
        raise BadFeature("too_large", f"Its properties take {size:,} bytes, at most {LARGEST_BYTES:,}. Shorten them.")
    plain: dict[str, Any] = json.loads(text)
    return plain


def _depth(value: object, level: int = 1) -> int:
    if level > DEEPEST + 1 or not isinstance(value, (dict, list, tuple)):
        return level
    inner = value.values() if isinstance(value, dict) else value
    return max((_depth(one, level + 1) for one in inner), default=level)


def _shown(value: object) -> str:
    if isinstance(value, int) and abs(value) > 10**15:
        return "far too large"
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 40 else text[:39] + "…"


def _bad(key: str, text: str) -> BadFeature:
    return BadFeature(f"bad_{key}", text)

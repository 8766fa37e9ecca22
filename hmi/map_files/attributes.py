"""Attributes of other programs, by the names and in the units of the farm map (docs/protocols/map.md, Features)."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from datetime import date, datetime
from typing import Any

from hmi.domain.ids import is_id
from hmi.map_files import limits
from hmi.map_files.xml_tree import cleaned
from hmi.mapping.attributes import HEIGHT

NAMES = ("name", "title", "label", "field_name", "fieldname", "fieldlabel", "field", "parcel", "parcel_name", "plot",
         "naam", "perceel", "perceelnaam", "schlag", "schlagname", "schlagbez", "bezeichnung", "nombre", "parcela",
         "nom", "designator", "field_id", "fid", "ref")  # fmt: skip
_ALIASES = {
    "crop": "crop croptype crop_type crop_name cropname culture kultur frucht fruchtart hauptfrucht gewas gewasnaam "
    "cultivo coltura",
    "species": "species variety sorte crop_variety cultivar ras",
    "status": "status growth_stage growthstage bbch stage",
    "seeded": "seeded seeded_on sown sowing sowing_date sowingdate seeding_date planted planting_date aussaat "
    "saatdatum zaaidatum siembra lastplantedat",
    "row_spacing_m": "row_spacing_m row_spacing rowspacing row_distance rowdist reihenabstand rijafstand row_width",
    "row_bearing_deg": "row_bearing_deg row_bearing row_heading ab_heading row_direction reihenrichtung",
    "headland_m": "headland_m headland headland_width vorgewende kopakker",
    "width_m": "width_m width breite breedte ancho largeur est_width",
    "radius_m": "radius_m radius",
    "speed_mps": "speed_mps",
    "heading_deg": "heading_deg",
    "category": "category",
    "soil_type": "soil_type soiltype soil_name bodenart bodemtype grondsoort tipo_suelo type_sol",
}
_OWN = {alias: own for own, aliases in _ALIASES.items() for alias in aliases.split()}
_CENTIMETRES = {f"{alias}_cm": own for alias, own in _OWN.items() if own.endswith("_m")}
_HEIGHTS = frozenset(
    {"height_m", "height", "building_height", "object_height", "tree_height", "gebaeudehoehe", "gebäudehöhe",
     "baumhoehe", "baumhöhe", "bouwhoogte", "boomhoogte"}
)  # fmt: skip  # of what stands up; "höhe", "hoogte" and "altura" alone mean above the sea as often
_RESERVED = {*_OWN.values(), "id", "kind", "name"}
_NUMBER = re.compile(r"^\s*([+-]?\d+(?:[.,]\d+)?)\s*([a-zA-Z°]*)\s*$")
_UNITS = {"": 1.0, "m": 1.0, "cm": 0.01, "mm": 0.001, "°": 1.0, "deg": 1.0}


def mapped(raw: dict[str, Any], problems: list[str]) -> tuple[str | None, dict[str, Any]]:
    """Return the name and the properties of attributes that another program wrote; append what was wrong with them."""
    given = tidy(raw, problems)
    name_key = next((key for word in NAMES for key in given if key.lower() == word and _is_name(given[key])), None)
    name = str(given.pop(name_key)) if name_key is not None else None
    known: dict[str, Any] = {}
    rest: dict[str, Any] = {}
    for key, value in given.items():
        own, factor = _own_name(key)
        if value is None or value == "":
            continue
        read = _reader(own)(value, factor) if own and own not in known else None
        if own and read is not None:
            known[own] = read
            continue
        if own:
            problems.append(f"{key[:40]} {str(value)[:40]!r} is not understood and was kept as it is.")
        rest[f"{key}_as_given" if key in _RESERVED else key] = value
    return name, {**rest, **known}


def with_height(properties: dict[str, Any], problems: list[str]) -> dict[str, Any]:
    """Return the properties of what stands up with its height by our name; append from what it was taken."""
    for key, value in properties.items():
        word = _word(key)
        if word.removesuffix("_cm") not in _HEIGHTS:
            continue
        read = _number(value, 0.01 if word.endswith("_cm") else 1.0)
        if not read:  # 0 is how tables say that nobody knows
            continue
        if word != HEIGHT:
            problems.append(f"{key[:40]} {str(value)[:40]} was taken as its height above the ground. Check it.")
        return {**{other: one for other, one in properties.items() if other != key}, HEIGHT: read}
    return properties


def tidy(raw: dict[str, Any], problems: list[str], *, is_own: bool = False) -> dict[str, Any]:
    """Return attributes as plain values within the limits; append what was cut.

    Args:
        is_own: written by this program: as long as a feature of the map may have them.
    """
    chars, most = (limits.OWN_CHARS, limits.OWN_ATTRIBUTES) if is_own else (limits.TEXT_CHARS, limits.ATTRIBUTES)
    kept: dict[str, Any] = {}
    for key, value in raw.items():
        name = cleaned(str(key)).strip()[: limits.KEY_CHARS]
        if not name:
            continue
        if len(kept) >= most:
            problems.append(f"Only the first {most} attributes were kept.")
            break
        kept[name] = _plain(value, name, problems, chars)
    return kept


def usable_id(value: Any) -> str | None:
    """Return ``value`` if it may be the id of a feature."""
    return value if isinstance(value, str) and is_id(value) else None


def clean_name(name: str) -> str:
    """Return a name on one line and short enough to be shown."""
    return " ".join(cleaned(name).split())[: limits.NAME_CHARS].strip()


def _plain(value: Any, name: str, problems: list[str], chars: int) -> Any:
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    if isinstance(value, (date, datetime)):
        return value.isoformat()
    if isinstance(value, str):
        value = value.encode("utf-8", "replace").decode("utf-8")
        if len(value) > chars:
            problems.append(f"{name[:40]} was cut to {chars} characters.")
        return value[:chars]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) > 2**53:
        return str(value)[: limits.TEXT_CHARS] if abs(value) < 10**100 else None
    if isinstance(value, (list, dict)):
        return _nested(value, name, problems, chars)
    return value


def _nested(value: Any, name: str, problems: list[str], chars: int) -> Any:
    try:
        text = json.dumps(value, allow_nan=False, ensure_ascii=False)
        if len(text) <= chars:
            return json.loads(text.encode("utf-8", "replace"))
    except (ValueError, TypeError, RecursionError):
        pass
    problems.append(f"{name[:40]} was left out: it is too long or not plain data.")
    return None


def _is_name(value: Any) -> bool:
    return (isinstance(value, str) and bool(clean_name(value))) or (isinstance(value, int) and value is not True)


def _own_name(key: str) -> tuple[str | None, float]:
    word = _word(key)
    if word in _CENTIMETRES:
        return _CENTIMETRES[word], 0.01
    return _OWN.get(word), 1.0


def _word(key: str) -> str:
    return re.sub(r"[^a-z0-9äöü]+", "_", key.lower()).strip("_")


def _reader(own: str) -> Callable[[Any, float], Any]:
    if own == "seeded":
        return _day
    return _number if own.endswith(("_m", "_deg", "_mps")) else _text


def _text(value: Any, _factor: float) -> str | None:
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        return None
    return str(value).strip()[:200] or None


def _day(value: Any, _factor: float) -> str | None:
    """Return the day of an ISO 8601 date or time, or of a date in the German way."""
    text = str(value).strip()
    match = re.match(r"^(\d{1,2})\.(\d{1,2})\.(\d{4})$", text)
    if match:
        text = f"{match.group(3)}-{int(match.group(2)):02d}-{int(match.group(1)):02d}"
    try:
        return date.fromisoformat(text[:10]).isoformat()
    except ValueError:
        return None


def _number(value: Any, factor: float) -> float | int | None:
    if isinstance(value, bool):
        return None
    if isinstance(value, (int, float)):
        return value if factor == 1.0 else round(value * factor, 6)
    match = _NUMBER.match(str(value))
    if match is None or match.group(2).lower() not in _UNITS:
        return None
    unit = 1.0 if factor != 1.0 else _UNITS[match.group(2).lower()]
    return round(float(match.group(1).replace(",", ".")) * factor * unit, 6)

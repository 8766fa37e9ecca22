"""Whether a map would leave much less than there was: a slip or a bad file, until a person says otherwise."""

from __future__ import annotations

from collections.abc import Iterable

from hmi.mapping.feature import MapFeature
from hmi.mapping.measures import area_m2, area_text

STAYS = 0.5  # a map that keeps no more than this share of its features, its fields or their area is asked about


def shrinking(before: Iterable[MapFeature], after: Iterable[MapFeature]) -> str:
    """Return in a sentence how much less the new map has, with numbers; nothing if it keeps most of the old one."""
    old, new = list(before), list(after)
    if _shrinks(len(old), len(new)):
        return f"The new map has {_count(len(new), 'feature')}, the published one {len(old)}."
    fields, kept = ([one for one in side if one.kind == "parcel"] for side in (old, new))
    if _shrinks(len(fields), len(kept)):
        return f"The new map has {_count(len(kept), 'field')}, the published one {len(fields)}."
    was_m2, is_m2 = (sum(map(area_m2, side)) for side in (fields, kept))
    if _shrinks(was_m2, is_m2):
        return f"The fields of the new map have {area_text(is_m2)}, those of the published one {area_text(was_m2)}."
    return ""


def _shrinks(was: float, is_now: float) -> bool:
    return was > 0 and is_now <= STAYS * was


def _count(number: int, noun: str) -> str:
    return f"1 {noun}" if number == 1 else f"{number} {noun}s"

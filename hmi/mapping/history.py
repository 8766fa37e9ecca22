"""What changed over the published versions of one feature: crop, growth stage, dates, row spacing and the like."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from hmi.mapping.attributes import LABELS, VALID_FROM

ORDER = ("name", "crop", "species", "status", "seeded", "row_spacing_m", "row_bearing_deg", "headland_m")
"""Attributes in the order a farmer reads them; others follow by name."""


@dataclass(frozen=True, slots=True)
class Published:
    """One feature as a version holds it.

    Args:
        version: number of the version.
        by, at: who published it, and when; ``None`` for a map that came without versions.
        properties: with name, without id and kind; ``None`` where the feature is not on that map.
    """

    version: int
    by: str
    at: datetime | None
    note: str
    properties: Mapping[str, Any] | None


@dataclass(frozen=True, slots=True)
class Entry:
    """One value that changed with one version.

    Args:
        key: attribute; empty where the whole feature came or went.
        label: what people call it.
        before, after: values as stored, ``None`` where there is none.
        valid_from: the day from which the value holds, where somebody gave it; else it holds from publishing.
    """

    key: str
    label: str
    before: Any
    after: Any
    version: int
    by: str
    at: datetime | None
    note: str
    valid_from: str | None


def attribute_history(versions: Iterable[Published]) -> list[Entry]:
    """Return every change of an attribute, newest first.

    Args:
        versions: of one feature, oldest first.
    """
    found: list[Entry] = []
    last: Mapping[str, Any] | None = None
    is_first = True
    for one in versions:
        found += _changes(last, one, is_first=is_first)
        last, is_first = one.properties, False
    return found[::-1]


def _changes(last: Mapping[str, Any] | None, one: Published, *, is_first: bool) -> Iterator[Entry]:
    now = one.properties
    if last is None and now is None:
        return
    if (last is None or now is None) and not is_first:
        yield _entry("", "Drawn" if last is None else "Removed", None, None, one, None)
    old, new = _plain(last), _plain(now)
    for key in sorted({*old, *new}, key=_rank, reverse=True):
        dated = (_days(last).get(key), _days(now).get(key))
        if old.get(key) != new.get(key):
            # a day that was given for the old value says nothing about the new one
            valid = dated[1] if dated[1] != dated[0] or last is None else None
            yield _entry(key, LABELS.get(key, key.capitalize()), old.get(key), new.get(key), one, valid)
        elif dated[0] != dated[1] and key in new:
            yield _entry(key, LABELS.get(key, key.capitalize()), old.get(key), new.get(key), one, dated[1])


def _entry(key: str, label: str, before: Any, after: Any, one: Published, valid_from: str | None) -> Entry:
    return Entry(key, label, before, after, one.version, one.by, one.at, one.note, valid_from)


def _plain(properties: Mapping[str, Any] | None) -> dict[str, Any]:
    rest = {key: value for key, value in (properties or {}).items() if key not in ("id", "kind", VALID_FROM)}
    return {key: value for key, value in rest.items() if value not in (None, "")}


def _days(properties: Mapping[str, Any] | None) -> Mapping[str, str]:
    days = (properties or {}).get(VALID_FROM)
    return days if isinstance(days, dict) else {}


def _rank(key: str) -> tuple[int, str]:
    return (ORDER.index(key) if key in ORDER else len(ORDER), key)

"""A wish for a feature, brought into what became of that feature meanwhile."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hmi.mapping.errors import BadFeature
from hmi.mapping.feature import MapFeature

_WORDS = {"name": "name", "geometry": "shape"}


def merged(mine: MapFeature | None, before: MapFeature | None, after: MapFeature | None) -> MapFeature | None:
    """Return ``mine`` with what differs from ``before`` to ``after``; ``None`` is absent.

    Raises:
        BadFeature: ``mine`` differs from ``before`` in the same, in another way.
    """
    if mine in (before, after):
        return after
    known = mine or before or after
    title = "" if known is None else known.title
    if mine is None:
        raise _twice(title, "removed it")
    if before is None or after is None or mine.kind != before.kind:
        raise _twice(title, "changed it")
    old, new, now = _parts(before), _parts(after), _parts(mine)
    for key in sorted(old.keys() | new.keys()):
        if old.get(key) == new.get(key) or now.get(key) == new.get(key):
            continue
        if now.get(key) != old.get(key):
            raise _twice(title, f"changed its {_WORDS.get(key, key.replace('_', ' '))}")
        now[key] = new.get(key)
    name, geometry = now.pop("name"), now.pop("geometry")
    return replace(
        mine, name=name, geometry=geometry, properties={key: value for key, value in now.items() if value is not None}
    )


def is_within(mine: MapFeature | None, before: MapFeature | None, after: MapFeature | None) -> bool:
    """Say whether ``mine`` has what differs from ``before`` to ``after`` already, whatever else was changed there."""
    try:
        return merged(mine, before, after) == mine
    except BadFeature:
        return False


def _parts(feature: MapFeature) -> dict[str, Any]:
    return {**feature.properties, "name": feature.name, "geometry": feature.geometry}


def _twice(title: str, what: str) -> BadFeature:
    text = f"{title}: your draft {what}, too. Take that back in the draft first, or refuse the change."
    return BadFeature("changed_in_draft", text)

"""What the console asks of a map's geometry, by name: loaded with the first question, not with the console.

numpy, shapely and pyproj take a quarter of a second that nobody who waits for the console shall wait for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hmi.mapping.feature import MapFeature

if TYPE_CHECKING:
    from hmi.mapping.checks import Finding
    from hmi.mapping.diff import Difference
    from hmi.mapping.effect import Effect
    from hmi.mapping.operations import Outcome
    from hmi.mapping.walk import Walked

Position = tuple[float, float, float, float]
"""Longitude and latitude in degrees, accuracy in metres, seconds from any start."""


def apply(op: str, features: Mapping[str, MapFeature], ids: Sequence[str], args: Mapping[str, Any]) -> Outcome:
    """See ``hmi.mapping.operations.apply``."""
    from hmi.mapping import operations

    return operations.apply(op, features, ids, args)


def check(features: Iterable[MapFeature], machine_width_m: float | None = None) -> list[Finding]:
    """See ``hmi.mapping.checks.check``."""
    from hmi.mapping import checks

    return checks.check(features, machine_width_m)


def compare(old: Iterable[MapFeature], new: Iterable[MapFeature]) -> list[Difference]:
    """See ``hmi.mapping.diff.compare``."""
    from hmi.mapping import diff

    return diff.compare(old, new)


def effect_of(outcome: Outcome) -> Effect:
    """See ``hmi.mapping.effect.effect_of``."""
    from hmi.mapping import effect

    return effect.effect_of(outcome)


def outline(points: Sequence[Position], is_closed: bool, tolerance_m: float) -> Walked:
    """See ``hmi.mapping.walk.outline``."""
    from hmi.mapping import walk

    return walk.outline([walk.WalkPoint(*one) for one in points], is_closed, tolerance_m)


def shrinking(before: Iterable[MapFeature], after: Iterable[MapFeature]) -> str:
    """See ``hmi.mapping.shrinking.shrinking``."""
    from hmi.mapping import shrinking

    return shrinking.shrinking(before, after)

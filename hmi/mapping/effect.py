"""What an operation would do to a shape, in numbers: for looking before anything is changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import shapely
from shapely.geometry import LinearRing, LineString, MultiPoint

from hmi.mapping.coordinates import is_ring, paths
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import Shape, frame_of
from hmi.mapping.kinds import POINT
from hmi.mapping.measures import area_m2
from hmi.mapping.operations import Outcome


@dataclass(frozen=True, slots=True)
class Effect:
    """An outcome in numbers.

    Args:
        corners_before, corners_after: of all features together; a ring's first corner counts once.
        area_before_m2, area_after_m2: of all areas together.
        off_m: how far the new edges are from the old corners at most, metres; ``None`` where nothing can be compared.
        pieces: features there are afterwards.
    """

    corners_before: int
    corners_after: int
    area_before_m2: float
    area_after_m2: float
    off_m: float | None
    pieces: int

    def as_json(self) -> dict[str, Any]:
        """Return ``effect`` of docs/protocols/map.md."""
        return asdict(self)


def effect_of(outcome: Outcome) -> Effect:
    """Return what the changes of an outcome come to."""
    before = [one.before for one in outcome.changes if one.before is not None]
    after = [one.after for one in outcome.changes if one.after is not None]
    return Effect(
        corners_before=sum(map(_corners, before)),
        corners_after=sum(map(_corners, after)),
        area_before_m2=sum(map(area_m2, before)),
        area_after_m2=sum(map(area_m2, after)),
        off_m=_off_m(before, after),
        pieces=len(after),
    )


def _corners(feature: MapFeature) -> int:
    return sum(len(path) - int(is_ring(feature.geometry)) for path in paths(feature.geometry))


def _off_m(before: Sequence[MapFeature], after: Sequence[MapFeature]) -> float | None:
    if not before or not after or any(one.geometry["type"] == POINT for one in (*before, *after)):
        return None
    frame = frame_of([*before, *after])
    old = MultiPoint([tuple(p) for one in before for path in paths(one.geometry) for p in frame.to_local(path)])
    edges: list[Shape] = []
    for one in after:
        kind = LinearRing if is_ring(one.geometry) else LineString
        edges += [kind(frame.to_local(path)) for path in paths(one.geometry)]
    return float(shapely.distance(shapely.get_parts(old), shapely.union_all(edges)).max())

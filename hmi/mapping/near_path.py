"""What of a map a mission meets: whatever touches its field, and what closes, opens or slows its ways."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import shapely

from hmi.domain.map_ground import CLOSED_KINDS, WAY_KINDS
from hmi.mapping.coordinates import paths
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import covered_by
from hmi.planning.projection import LocalFrame

NEAR_DEG = 0.0006  # some 60 m: a machine's way around a field and its turns lie within
WAY_M = 15.0  # of what it passes on its way: half a wide machine, and room to see that it was missed by little
IGNORED_KINDS = ("farm",)
MET_KINDS = frozenset((*CLOSED_KINDS, *WAY_KINDS, "slow", "home", "gate"))
"""What matters where a machine only passes by."""
WAYS = ("approach", "exit")
Box = tuple[float, float, float, float]


class NearPath:
    """Answers whether a feature lies near a mission.

    Args:
        document: the mission's, with parcel, datum and segments.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        self._field = _wide(_box((p[0], p[1]) for ring in document["parcel"] for p in ring))
        datum = document["datum"]
        self._frame = LocalFrame(datum["lat_deg"], datum["lon_deg"])
        lines = [np.asarray(one["points"], dtype=float) for one in document["segments"] if one["kind"] in WAYS]
        self._ways = shapely.MultiLineString(lines)
        self._ways_box = None
        if lines:
            self._ways_box = _wide(_box((p[0], p[1]) for p in self._frame.to_lon_lat(np.vstack(lines))))
        shapely.prepare(self._ways)

    def of(self, features: Iterable[MapFeature]) -> Iterator[MapFeature]:
        """Return those that lie near the field or the ways to it."""
        return (one for one in features if one.kind not in IGNORED_KINDS and self._is_near(one))

    def _is_near(self, feature: MapFeature) -> bool:
        own = _box((p[0], p[1]) for path in paths(feature.geometry) for p in path)
        if _meet(own, self._field):
            return True
        if feature.kind not in MET_KINDS or self._ways_box is None or not _meet(own, self._ways_box):
            return False
        return bool(shapely.dwithin(self._ways, covered_by(feature, self._frame), WAY_M))


def _box(points: Iterable[tuple[float, float]]) -> Box:
    lons, lats = zip(*points, strict=True)
    return min(lons), min(lats), max(lons), max(lats)


def _wide(box: Box) -> Box:
    return box[0] - NEAR_DEG, box[1] - NEAR_DEG, box[2] + NEAR_DEG, box[3] + NEAR_DEG


def _meet(a: Box, b: Box) -> bool:
    return a[0] <= b[2] and b[0] <= a[2] and a[1] <= b[3] and b[1] <= a[3]

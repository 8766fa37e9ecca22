"""What of a map stands in a path that is flown, however long ago it was planned."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import shapely

from hmi.domain.flight import in_the_way
from hmi.domain.mission_plan import Surroundings
from hmi.domain.mission_rest import kept_behind, kept_of
from hmi.planning.projection import LocalFrame
from hmi.planning.surroundings import area_of

ASIDE_M = 2.0  # a plan keeps more, to the middle of the machine: the clearance of its outline and half its width


def met_in_flight(document: Mapping[str, Any], around: Surroundings, flown: int | None = None) -> str:
    """Say what is in the way of a mission, empty if nothing is.

    Args:
        document: the mission's; of the rest of one the part that was planned with it counts.
        around: of the map as it is now, for the robot as it is now.
        flown: segments behind the robot: what the rest kept of the mission before and is still ahead counts, too.
    """
    frame = LocalFrame(document["datum"]["lat_deg"], document["datum"]["lon_deg"])
    first = kept_behind(kept_of(document), flown)
    lines = [np.asarray(one["points"], dtype=float) for one in document["segments"][first:]]
    path = shapely.MultiLineString(lines)
    shapely.prepare(path)
    hit = list(_hit(path, frame, around))
    names = [around.names[k] for k in hit]
    return in_the_way(names, [around.names[k] for k in hit if k in around.unmeasured], around.flight_height_m)


def _hit(path: shapely.MultiLineString, frame: LocalFrame, around: Surroundings) -> Iterator[int]:
    for number, (geometry, width_m) in enumerate(around.obstacles):
        if shapely.dwithin(path, area_of(geometry, width_m, frame), ASIDE_M):
            yield number

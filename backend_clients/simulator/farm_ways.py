"""Ways over the farm for what drives: along its roads, and round what must not be entered."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from backend_clients.simulator.cameras.map_feature import MapFeature
from backend_clients.simulator.enu import EnuFrame, Point
from hmi.domain.map_ground import CLOSED_KINDS

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from shapely.geometry.base import BaseGeometry

    from hmi.planning.ways import Ways

CLEAR_M = 2.5  # of the middle of a machine from what is closed: half of the widest, and a little
COARSE_M = 0.5  # round shapes get few corners
BEND_M = 0.3  # further out, so that a way may touch the corner it bends at
EVERY_M = 40.0  # along a road a machine may join or leave it
ROOM_M = 400.0  # around the farm
FAR_M = 5000.0  # another site
USUAL_WIDTH_M, USUAL_RADIUS_M = 5.0, 1.0


@dataclass(frozen=True, slots=True, eq=False)
class _Ground:
    """One site in the plane of its frame."""

    frame: EnuFrame
    ways: Ways


class FarmWays:
    """The ways over a farm's map.

    What draws on the map (shapely) is loaded with the first way; ``prepare`` does that beforehand, in any thread.
    """

    def __init__(self, features: Sequence[MapFeature]) -> None:
        self._features = tuple(features)
        self._grounds: dict[tuple[float, float], _Ground | None] = {}
        self._lock = threading.Lock()

    def prepare(self, frame: EnuFrame) -> None:
        """Look around from most corners of the ground beforehand: a way from anywhere is then found in some 20 ms."""
        if self._ground(frame) is None:
            return
        homes = [one for one in self._features if one.kind == "home"]
        for parcel in (one for one in self._features if one.kind == "parcel"):
            place = _shape(parcel, frame).representative_point()
            home = min((_shape(one, frame) for one in homes), key=place.distance, default=place)
            if place.distance(home) < FAR_M:
                self.way(frame, (place.x, place.y), (home.x, home.y))

    def way(self, frame: EnuFrame, start: Point, goal: Point) -> list[Point]:
        """Return a way between two places, both included, metres in ``frame``; straight where there is no map."""
        ground = self._ground(frame)
        found = None
        if ground is not None:
            with self._lock:
                found = ground.ways.cheapest(np.asarray([start, goal], dtype=np.float64))
        if found is None:
            return [start, goal]
        return [start, *((float(x), float(y)) for x, y in found[1:-1]), goal]

    def _ground(self, frame: EnuFrame) -> _Ground | None:
        key = (frame.lat_deg, frame.lon_deg)
        with self._lock:
            if key not in self._grounds:
                self._grounds[key] = _laid(self._features, frame)
            return self._grounds[key]


def _laid(features: Sequence[MapFeature], frame: EnuFrame) -> _Ground | None:
    import shapely

    from hmi.planning.ways import Ways

    shapes = [(one, _shape(one, frame)) for one in features]
    near = [(one, shape) for one, shape in shapes if shape.distance(shapely.Point(0, 0)) < FAR_M]
    roads = [(one, shape) for one, shape in near if one.kind == "road"]
    if not roads:
        return None
    room = shapely.box(*shapely.union_all([shape for _, shape in near]).bounds).buffer(ROOM_M)
    closed = shapely.union_all([_wide(one, shape, CLEAR_M) for one, shape in near if one.kind in CLOSED_KINDS])
    paved = shapely.union_all([_wide(one, shape, 0.5) for one, shape in roads])
    free, rough = room.difference(closed), room.difference(paved)
    for ground in (free, rough):
        shapely.prepare(ground)
    corners = np.vstack([_along([shape for _, shape in roads]), _around(closed)])
    return _Ground(frame, Ways(free, rough, corners[shapely.covers(free, shapely.points(corners))]))


def _shape(one: MapFeature, frame: EnuFrame) -> BaseGeometry:
    import shapely
    from shapely.geometry import shape

    def local(places: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray([frame.to_enu(lat, lon) for lon, lat in places], dtype=np.float64)

    return shapely.transform(shape(one.geometry), local)


def _wide(one: MapFeature, shape: BaseGeometry, more_m: float) -> BaseGeometry:
    """Return the ground that a feature takes up, and ``more_m`` around it, with few corners."""
    given: dict[str, Any] = dict(one.properties)
    if shape.geom_type == "LineString":
        return shape.buffer(float(given.get("width_m", USUAL_WIDTH_M)) / 2 + more_m, quad_segs=1, cap_style="square")
    if shape.geom_type == "Point":
        return shape.buffer(float(given.get("radius_m", USUAL_RADIUS_M)) + more_m, cap_style="square")
    return shape.simplify(COARSE_M).buffer(more_m + COARSE_M, join_style="mitre", mitre_limit=2.0)


def _along(roads: Sequence[BaseGeometry]) -> NDArray[np.float64]:
    """Return places along the middle of roads and where they meet, and the corners of yards a little inside."""
    import shapely

    places: list[Any] = []
    lines = [road for road in roads if road.geom_type == "LineString"]
    for line in lines:
        count = max(round(line.length / EVERY_M), 1)
        places += [line.interpolate(k / count, normalized=True).coords[0] for k in range(count + 1)]
        places += list(line.coords)
    for one, other in itertools.combinations(lines, 2):
        meeting = one.intersection(other)
        if meeting.geom_type == "Point":
            places.append(meeting.coords[0])
    for yard in roads:
        if yard.geom_type == "Polygon":
            inside = yard.buffer(-2.0)
            places += [*shapely.get_coordinates(inside), yard.centroid.coords[0]]
    return np.asarray(places, dtype=np.float64).reshape(-1, 2)


def _around(closed: BaseGeometry) -> NDArray[np.float64]:
    import shapely

    wider = closed.buffer(BEND_M, join_style="mitre", mitre_limit=2.0)
    return np.asarray(shapely.get_coordinates(wider), dtype=np.float64)

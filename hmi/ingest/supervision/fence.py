"""Is it on the ground it may work on?"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.robot import Family, Mode
from hmi.ingest.supervision.view import View, is_under_way

if TYPE_CHECKING:
    import shapely

METRES_PER_DEG = 111_320.0
MARGIN_M = 0.5
SELF_MOVING = (Mode.AUTO, Mode.MANUAL)


@dataclass(frozen=True, slots=True)
class Ground:
    """A closed area on a plane in metres around its first corner."""

    area: shapely.Polygon
    edge: shapely.Geometry
    lat_deg: float
    lon_deg: float
    metres_per_lon: float

    @classmethod
    def of(cls, ring: Sequence[tuple[float, float]]) -> Ground | None:
        """Return the ground inside a ring of longitude and latitude; ``None`` if that encloses nothing.

        The first call loads shapely, a quarter of a second: not on the event loop.
        """
        import shapely

        if len(ring) < 4:
            return None
        lon, lat = ring[0]
        per_lon = METRES_PER_DEG * math.cos(math.radians(lat))
        area = shapely.Polygon([((x - lon) * per_lon, (y - lat) * METRES_PER_DEG) for x, y in ring])
        if not area.is_valid or area.is_empty:
            return None
        shapely.prepare(area)
        return cls(area, area.exterior, lat, lon, per_lon)

    def metres(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        """Return a place on the plane."""
        return (lon_deg - self.lon_deg) * self.metres_per_lon, (lat_deg - self.lat_deg) * METRES_PER_DEG

    def outside_m(self, x_m: float, y_m: float) -> float:
        """Return how far a place is outside; negative is how far inside."""
        import shapely

        point = shapely.Point(x_m, y_m)
        distance_m = float(shapely.distance(self.edge, point))
        return -distance_m if self.area.covers(point) else distance_m


class Fence:
    """Whether a machine that moves by itself left the farm's ground; drones may.

    The distance to the edge is measured anew only when the machine left a box around where it was measured last,
    in which it cannot have come that far.
    """

    codes = frozenset({"outside-fence"})

    def __init__(self, ground_of: Callable[[], Ground | None]) -> None:
        self._ground_of = ground_of
        self._ground: Ground | None = None
        self._at = self._safe = (0.0, 0.0)
        self._outside_m = 0.0

    def look(self, view: View) -> Findings | None:
        """See ``Rule``."""
        robot, ground = view.robot, self._ground_of()
        telemetry, state = robot.telemetry, robot.state
        if ground is None or telemetry is None or state is None:
            return None
        if robot.factsheet is not None and robot.factsheet.family is Family.UAV:
            return NOTHING
        if not is_under_way(robot) and state.mode not in SELF_MOVING:
            return NOTHING  # it may be on a trailer
        pose = telemetry.pose
        lat_deg, lon_deg = self._at
        safe_lat, safe_lon = self._safe
        is_near = -safe_lat < pose.lat_deg - lat_deg < safe_lat and -safe_lon < pose.lon_deg - lon_deg < safe_lon
        if ground is self._ground and is_near:
            return NOTHING
        self._measure(ground, pose.lat_deg, pose.lon_deg)
        accuracy_m = telemetry.gnss.accuracy_m if telemetry.gnss is not None else 0.0
        if self._outside_m <= max(MARGIN_M, accuracy_m):
            return NOTHING
        return (Finding("outside-fence", f"{self._outside_m:.1f} m outside the farm's edge."),)

    def _measure(self, ground: Ground, lat_deg: float, lon_deg: float) -> None:
        self._ground, self._at = ground, (lat_deg, lon_deg)
        self._outside_m = ground.outside_m(*ground.metres(lat_deg, lon_deg))
        half_m = max(0.0, -self._outside_m) / math.sqrt(2)
        self._safe = half_m / METRES_PER_DEG, half_m / ground.metres_per_lon

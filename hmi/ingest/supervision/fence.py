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
Rings = Sequence[Sequence[tuple[float, float]]]
"""A polygon in longitude and latitude: its outer ring, then its holes."""
SELF_MOVING = (Mode.AUTO, Mode.MANUAL)


@dataclass(frozen=True, slots=True)
class Ground:
    """Where machines may be, on a plane in metres around its first corner: the farms without the keep-out zones.

    Args:
        free: the ground itself, ``None`` where the map has no farm: then only the zones are watched.
        zones: the keep-out zones with what people call them; ``closed`` is all of them together.
        edge: every line that ends the free ground.
    """

    free: shapely.Geometry | None
    zones: Sequence[tuple[str, shapely.Geometry]]
    closed: shapely.Geometry
    edge: shapely.Geometry
    lat_deg: float
    lon_deg: float
    metres_per_lon: float

    @classmethod
    def of(cls, farms: Sequence[Rings], zones: Sequence[tuple[str, Rings]] = ()) -> Ground | None:
        """Return the ground inside farms and outside keep-out zones; ``None`` if there is neither.

        The first call loads shapely, a quarter of a second: not on the event loop.
        """
        import shapely

        corners = [ring[0] for rings in (*farms, *(rings for _, rings in zones)) for ring in rings if ring]
        if not corners:
            return None
        lon, lat = corners[0]
        per_lon = METRES_PER_DEG * math.cos(math.radians(lat))

        def area(rings: Rings) -> shapely.Geometry:
            plane = [[((x - lon) * per_lon, (y - lat) * METRES_PER_DEG) for x, y in ring] for ring in rings]
            outer, *holes = [ring for ring in plane if len(ring) >= 4] or [[]]
            return shapely.make_valid(shapely.Polygon(outer, holes), method="structure", keep_collapsed=False)

        found = [(name, shape) for name, rings in zones if not (shape := area(rings)).is_empty]
        closed = shapely.union_all([shape for _, shape in found])
        farm = shapely.union_all([area(rings) for rings in farms])
        if farm.is_empty and closed.is_empty:
            return None
        free = None if farm.is_empty else farm.difference(closed)
        edge = shapely.boundary(closed if free is None or free.is_empty else free)
        shapely.prepare(closed if free is None else free)
        return cls(free, found, closed, edge, lat, lon, per_lon)

    def metres(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        """Return a place on the plane."""
        return (lon_deg - self.lon_deg) * self.metres_per_lon, (lat_deg - self.lat_deg) * METRES_PER_DEG

    def outside_m(self, x_m: float, y_m: float) -> tuple[float, str]:
        """Return how far a place is off the free ground, negative how far inside it, and where it is instead."""
        import shapely

        point = shapely.Point(x_m, y_m)
        distance_m = float(shapely.distance(self.edge, point))
        if not self.closed.contains(point) if self.free is None else self.free.covers(point):
            return -distance_m, ""
        zone = next((name for name, area in self.zones if area.contains(point)), None)
        return distance_m, f"inside {zone}" if zone is not None else "outside the farm's edge"


class Fence:
    """Whether a machine that moves by itself left the farm's ground or is in a keep-out zone; drones may.

    The distance to the edge is measured anew only when the machine left a box around where it was measured last,
    in which it cannot have come that far.
    """

    codes = frozenset({"outside-fence"})

    def __init__(self, ground_of: Callable[[], Ground | None]) -> None:
        self._ground_of = ground_of
        self._ground: Ground | None = None
        self._at = self._safe = (0.0, 0.0)
        self._outside_m, self._where = 0.0, ""

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
        return (Finding("outside-fence", f"{self._outside_m:.1f} m {self._where}."),)

    def _measure(self, ground: Ground, lat_deg: float, lon_deg: float) -> None:
        self._ground, self._at = ground, (lat_deg, lon_deg)
        self._outside_m, self._where = ground.outside_m(*ground.metres(lat_deg, lon_deg))
        half_m = max(0.0, -self._outside_m) / math.sqrt(2)
        self._safe = half_m / METRES_PER_DEG, half_m / ground.metres_per_lon

"""One plane for the whole site: metres east and north of the datum of the first robot.

Robots have datums of their own. Within a site the planes are parallel, so a shift between them is enough: over 10 km
the turn of the meridians is below 0.1 degrees at the latitudes where crops grow.
"""

from __future__ import annotations

import math

_A_M = 6378137.0  # WGS84
_E2 = 6.69437999014e-3


class SiteFrame:
    """ENU metres at a datum; the first datum asked for becomes the origin."""

    def __init__(self) -> None:
        self._origin: tuple[float, float] | None = None
        self._shifts: dict[tuple[float, float], tuple[float, float]] = {}

    @property
    def origin(self) -> tuple[float, float] | None:
        """Latitude and longitude of the origin in degrees."""
        return self._origin

    def shift(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        """Return where a datum lies in the site's plane, metres east and north."""
        key = (lat_deg, lon_deg)
        if key not in self._shifts:
            if self._origin is None:
                self._origin = key
            self._shifts[key] = self.local(lat_deg, lon_deg)
        return self._shifts[key]

    def local(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        """Return metres east and north of the origin (Meeus, radii of curvature at the mean latitude)."""
        if self._origin is None:
            self._origin = (lat_deg, lon_deg)
        lat0, lon0 = self._origin
        middle = math.radians((lat_deg + lat0) / 2)
        w = math.sqrt(1 - _E2 * math.sin(middle) ** 2)
        north = math.radians(lat_deg - lat0) * _A_M * (1 - _E2) / w**3
        return math.radians(lon_deg - lon0) * _A_M / w * math.cos(middle), north

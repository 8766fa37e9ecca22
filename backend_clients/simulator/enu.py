"""WGS84 to the local ENU frame of a datum and back; x east, y north, metres."""

from __future__ import annotations

from collections.abc import Sequence

from pyproj import Proj

from backend_clients.edge.messages_up import Datum

Point = tuple[float, float]


class EnuFrame:
    """Azimuthal equidistant frame around a datum: under 1 mm from a tangent plane within 5 km."""

    def __init__(self, lat_deg: float, lon_deg: float) -> None:
        self.lat_deg, self.lon_deg = lat_deg, lon_deg
        self._proj = Proj(proj="aeqd", lat_0=lat_deg, lon_0=lon_deg, ellps="WGS84")

    def to_wgs84(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Return (lat_deg, lon_deg)."""
        lon_deg, lat_deg = self._proj(x_m, y_m, inverse=True)
        return float(lat_deg), float(lon_deg)

    def to_enu(self, lat_deg: float, lon_deg: float) -> Point:
        """Return (x_m, y_m)."""
        x_m, y_m = self._proj(lon_deg, lat_deg)
        return float(x_m), float(y_m)

    def from_frame(self, datum: Datum, points: Sequence[Point]) -> list[Point]:
        """Return ``points`` of another datum's frame in this one; shape (N, 2) metres."""
        if abs(datum.lat_deg - self.lat_deg) < 1e-10 and abs(datum.lon_deg - self.lon_deg) < 1e-10:
            return list(points)
        other = Proj(proj="aeqd", lat_0=datum.lat_deg, lon_0=datum.lon_deg, ellps="WGS84")
        xs, ys = zip(*points, strict=True)
        lons, lats = other(list(xs), list(ys), inverse=True)
        new_xs, new_ys = self._proj(lons, lats)
        return [(float(x), float(y)) for x, y in zip(new_xs, new_ys, strict=True)]

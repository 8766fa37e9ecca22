"""WGS84 to a local plane and back.

The plane is an azimuthal equidistant projection at the datum: x east, y north, metres. Within 10 km of the
datum its scale is true to 1e-6, far below RTK noise.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pyproj import Transformer

Floats = NDArray[np.float64]


@lru_cache(maxsize=64)
def _transformer(lat_deg: float, lon_deg: float) -> Transformer:
    plane = f"+proj=aeqd +lat_0={lat_deg!r} +lon_0={lon_deg!r} +ellps=WGS84 +units=m +no_defs"
    return Transformer.from_crs("EPSG:4326", plane, always_xy=True)


class LocalFrame:
    """ENU plane at a datum.

    Args:
        lat_deg, lon_deg: WGS84 origin of the plane.

    Raises:
        ValueError: the datum is not a place on earth.
    """

    def __init__(self, lat_deg: float, lon_deg: float) -> None:
        if not (-90 <= lat_deg <= 90 and -180 <= lon_deg <= 180):
            raise ValueError(f"datum lat {lat_deg}, lon {lon_deg} is not a place on earth")
        self.lat_deg = float(lat_deg)
        self.lon_deg = float(lon_deg)
        self._transformer = _transformer(self.lat_deg, self.lon_deg)

    def to_local(self, lon_lat_deg: ArrayLike) -> Floats:
        """Return (N, 2) metres east and north of (N, 2) longitudes and latitudes, as in GeoJSON."""
        points = np.asarray(lon_lat_deg, dtype=np.float64).reshape(-1, 2)
        x, y = self._transformer.transform(points[:, 0], points[:, 1])
        return np.column_stack([x, y])

    def to_lon_lat(self, xy_m: ArrayLike) -> Floats:
        """Return (N, 2) longitudes and latitudes of (N, 2) metres east and north."""
        points = np.asarray(xy_m, dtype=np.float64).reshape(-1, 2)
        lon, lat = self._transformer.transform(points[:, 0], points[:, 1], direction="INVERSE")
        return np.column_stack([lon, lat])

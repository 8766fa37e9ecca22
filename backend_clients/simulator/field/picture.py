"""Pictures of field cameras, drawn by the drawing process of the robots' cameras and gone when it is done."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import datetime

from backend_clients.simulator.cameras.map_feature import MapFeature
from backend_clients.simulator.cameras.observer import morning_ms
from backend_clients.simulator.cameras.scene import Look, Scene
from backend_clients.simulator.cameras.scenery import Scenery, scene_of
from backend_clients.simulator.cameras.studio import Studio
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.field.station import StationConfig

WIDTH_PX, HEIGHT_PX = 640, 480
IDLE_S = 4.0  # the pictures of one hour come together; after them the drawing process ends


class FieldStudio:
    """Draws what field cameras see: the crop of their parcel in false colours.

    Args:
        features: the farm's map.
        is_always_day: the light of a summer morning at any hour.
    """

    def __init__(self, features: tuple[MapFeature, ...], *, is_always_day: bool = False) -> None:
        self._scenery, self._is_always_day = Scenery(features), is_always_day
        self._studio = Studio(idle_s=IDLE_S)

    async def picture(self, station: StationConfig, utc: datetime) -> bytes:
        """Return a JPEG; raises ``NoPicture``."""
        return (await self._studio.picture(lambda: self._take(station, utc))).jpeg

    async def close(self) -> None:
        """End the drawing process."""
        await self._studio.close()

    def _take(self, station: StationConfig, utc: datetime) -> tuple[Look, Callable[[], Scene]]:
        # the scene is drawn around the camera, which stands where a machine would
        mast = RobotConfig(station.id, station.name, "none", station.lat_deg, station.lon_deg)
        look = Look(
            scene=self._scenery.key(mast, None),
            robot=station.id,
            camera="multispectral",
            family="mast",
            width_px=WIDTH_PX,
            height_px=HEIGHT_PX,
            wall_ms=int(utc.timestamp() * 1000),
            x_m=0.0,
            y_m=0.0,
            theta_rad=math.pi / 2 - math.radians(station.bearing_deg),
            sun_ms=morning_ms(station.lon_deg) if self._is_always_day else None,
        )
        return look, lambda: scene_of(self._scenery, mast, None)

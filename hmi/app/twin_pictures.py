"""Pictures of cameras for the twin: fetched from the camera process while somebody shows them in the scene."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence

from hmi.app.media_link import MediaDown, MediaLink
from hmi.commands.camera_ports import CameraProcess, CamerasAway, NoPicture

FRESH_S = 1.0
log = logging.getLogger(__name__)


class TwinPictures:
    """Carries one picture of each wanted camera from process to process.

    Args:
        process: the camera process; ``None`` where the console has none.
    """

    def __init__(self, link: MediaLink, process: Callable[[], CameraProcess | None]) -> None:
        self._link, self._process = link, process

    async def carry(self, wanted: Mapping[str, Sequence[str]]) -> None:
        """Carry the newest pictures; a camera that shows nothing leaves its place in the scene empty."""
        process = self._process()
        if process is None:
            return
        cameras = [(robot_id, camera) for robot_id, names in wanted.items() for camera in names]
        await asyncio.gather(*(self._one(process, *one) for one in cameras))

    async def _one(self, process: CameraProcess, robot_id: str, camera: str) -> None:
        try:
            still = await process.still(robot_id, camera, FRESH_S)
            await self._link.picture(robot_id, camera, still.data, still.captured_s)
        except (CamerasAway, NoPicture, MediaDown) as error:
            log.debug("no picture of %s of %s for the twin: %s", camera, robot_id, error)

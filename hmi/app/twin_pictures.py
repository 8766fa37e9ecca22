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
        self._tasks: dict[tuple[str, str], asyncio.Task[None]] = {}

    def carry(self, wanted: Mapping[str, Sequence[str]]) -> None:
        """Have the newest pictures carried; a camera that shows nothing leaves its place in the scene empty.

        Each camera by itself: one that gives no picture is waited for, for seconds, while the others go on.
        """
        process = self._process()
        if process is None:
            return
        for robot_id, names in wanted.items():
            for camera in names:
                if (robot_id, camera) not in self._tasks:
                    self._begin(process, robot_id, camera)

    async def close(self) -> None:
        """End what is under way."""
        tasks = list(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _begin(self, process: CameraProcess, robot_id: str, camera: str) -> None:
        name = f"twin picture {robot_id}/{camera}"
        task = asyncio.get_running_loop().create_task(self._one(process, robot_id, camera), name=name)
        self._tasks[(robot_id, camera)] = task
        task.add_done_callback(lambda _done: self._tasks.pop((robot_id, camera)))

    async def _one(self, process: CameraProcess, robot_id: str, camera: str) -> None:
        try:
            still = await process.still(robot_id, camera, FRESH_S)
            await self._link.picture(robot_id, camera, still.data, still.captured_s)
        except (CamerasAway, NoPicture, MediaDown) as error:
            log.debug("no picture of %s of %s for the twin: %s", camera, robot_id, error)
        except Exception:
            log.exception("the picture of %s of %s did not get to the twin", camera, robot_id)

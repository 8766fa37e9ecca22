"""Pictures in the console: what is kept, where pictures come from, what is recorded by itself; plugged together."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Sequence
from datetime import timedelta
from typing import Any

from fastapi import APIRouter

from hmi.api.camera_sources import camera_source_routes, field_frame_routes
from hmi.api.pictures import picture_routes
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.commands.camera_ports import CameraProcess, NoCameras
from hmi.commands.camera_recorder import CameraRecorder, RecorderParts, Recording
from hmi.commands.camera_source_book import CameraSourceBook, SourceParts
from hmi.commands.clip_keeper import ClipKeeper
from hmi.commands.field_frames import FieldFrames
from hmi.commands.mission_pictures import MissionPicture, MissionPictureParts, MissionPictures
from hmi.commands.picture_book import PictureBook, PictureParts
from hmi.commands.ports import FleetReader, LaneEvent
from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.camera_source import FIELD
from hmi.domain.picture import Moment, moment_of
from hmi.domain.picture_retention import Retention
from hmi.presenters.operate import MissionTitle
from hmi.security.authorization import Authorize
from hmi.security.sealed import Seal
from hmi.settings import Settings
from hmi.store.errors import StoreError
from hmi.store.picture_files import PictureFiles
from hmi.store.picture_shelf import PictureShelf

SWEEP_S = 60.0
GB = 1_000_000_000
FRONT = "front"
USUAL_MOST, DEMO_MOST = 16, 4  # cameras held open for clips; simulated ones are drawn on the same machine
log = logging.getLogger(__name__)


class PictureDesk:
    """Everything about kept pictures; one for a console.

    ``place_of`` may be replaced: it says where a field camera stands, if anybody knows.

    Args:
        title_of: name of a stored mission.
        process: the camera process.
    """

    def __init__(
        self, settings: Settings, clock: Clock, records: Records, fleet: FleetReader, authorize: Authorize,
        on_event: LaneEvent, title_of: Callable[[str], MissionTitle | None], process: CameraProcess | None = None,
    ) -> None:  # fmt: skip
        self._clock, self._fleet, self._records, self._title_of = clock, fleet, records, title_of
        self.place_of: Callable[[str], Moment] = lambda _camera: Moment()
        process, farm_id = process or NoCameras(), settings.farm_id
        rules = Retention(
            int(settings.pictures_gb * GB), timedelta(days=settings.pictures_days), int(settings.pictures_free_gb * GB)
        )
        files = PictureFiles((settings.data / "pictures").absolute())  # the camera process writes there too
        self.shelf = PictureShelf(records.pictures, files, farm_id, clock, rules)
        self.sources = CameraSourceBook(
            SourceParts(
                records.camera_sources, records.database, Seal(settings.secret, "camera sources"), process, authorize,
                records.audit, clock, self._robot_url, lambda robot_id: records.robots.get(robot_id) is not None,
                self.shelf.forget_frames, tuple(settings.camera_networks), settings.demo,
            )
        )  # fmt: skip
        self.frames = FieldFrames(self.sources, self.shelf, process, records.database, clock, farm_id)
        self.book = PictureBook(
            PictureParts(
                process, self.shelf, records.database, authorize, records.audit, clock, on_event, self.moment_of,
                lambda camera: self.place_of(camera), self.name_of, self.frames.newest, settings.picture_watermark,
            )
        )  # fmt: skip
        self.recorder = self._recorder(settings, process, on_event)
        self._task: asyncio.Task[None] | None = None

    def routes(self) -> list[APIRouter]:
        """Return the REST routes."""
        return [
            camera_source_routes(self.sources),
            field_frame_routes(self.frames),
            picture_routes(self.book, self.name_of),
        ]

    async def prepare(self) -> None:
        """Bring files and records together, and read the sources."""
        await self.sources.load()
        await self.frames.load()
        try:
            await self.shelf.prepare()
        except StoreError as error:  # a disk without room must not keep the console from starting
            log.warning("the folder of pictures cannot be used: %s", error)

    def start(self) -> None:
        """Begin to record and to tidy up."""
        self.recorder.start()
        self._task = asyncio.get_running_loop().create_task(self._tidy(), name="pictures")

    async def stop(self) -> None:
        """End; what is being written is finished."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await self.recorder.stop()
        await self.shelf.close()

    def health(self) -> dict[str, dict[str, Any]]:
        """Return the part of pictures for ``/api/v1/health``."""
        return {"pictures": {"state": "ok" if self.shelf.health().is_ok else "degraded"}}

    def findings(self) -> Findings:
        """Return what an alarm should say."""
        health = self.shelf.health()
        return NOTHING if health.is_ok else (Finding("pictures-stopped", health.text),)

    # ---- what is known of robots ----

    def cameras_of(self, robot_id: str) -> Sequence[str]:
        """Return the ids of a robot's cameras; the one that looks ahead comes first."""
        robot = self._fleet.robot(robot_id)
        ids = [] if robot is None or robot.factsheet is None else [one.id for one in robot.factsheet.cameras]
        added = [one.camera for one in self.sources.robot_cameras() if one.robot_id == robot_id]
        return sorted(dict.fromkeys([*ids, *added]), key=lambda one: one != FRONT)

    def moment_of(self, robot_id: str, at_s: float) -> Moment:
        """Return where a robot is and what it does."""
        robot = None if robot_id == FIELD else self._fleet.robot(robot_id)
        order = None if robot is None or robot.state is None else robot.state.order
        return moment_of(robot, at_s, "" if order is None else self.mission_name(order.mission_id))

    def mission_name(self, mission_id: str) -> str:
        """Return what people call a mission, empty if it is not stored."""
        title = self._title_of(mission_id)
        return "" if title is None else title.name

    def name_of(self, robot_id: str) -> str:
        """Return what people call a robot."""
        if robot_id == FIELD:
            return "Field"
        robot = self._records.robots.get(robot_id)
        return robot_id if robot is None else robot.name

    def _robot_url(self, robot_id: str) -> str | None:
        robot = self._records.robots.get(robot_id)
        return None if robot is None else robot.http_url

    def _recorder(self, settings: Settings, process: CameraProcess, on_event: LaneEvent) -> CameraRecorder:
        clock, farm_id = self._clock, settings.farm_id
        mode = Recording("watched" if settings.demo else "driving")
        if settings.record_cameras != "auto":
            mode = Recording(settings.record_cameras)
        missions = MissionPictures(
            MissionPictureParts(
                process, self.shelf, clock, farm_id, self.cameras_of, self.moment_of, self.mission_name, on_event,
                MissionPicture(settings.mission_pictures), settings.mission_picture_minutes * 60.0,
                may_open=mode is Recording.DRIVING,
            )
        )  # fmt: skip
        clips = ClipKeeper(process, self.shelf, clock, farm_id, on_event)
        return CameraRecorder(
            RecorderParts(
                process, clips, missions, clock, self.cameras_of, self.moment_of, lambda: self.shelf.health().is_ok,
                mode, settings.record_most or (DEMO_MOST if settings.demo else USUAL_MOST),
            )
        )  # fmt: skip

    async def _tidy(self) -> None:
        while True:
            await asyncio.sleep(SWEEP_S)
            try:
                await self.shelf.sweep()
            except StoreError as error:
                log.warning("pictures were not tidied up: %s", error)
            except Exception:  # the next round must come
                log.exception("pictures were not tidied up")

"""Pictures of missions: at the end of each row, or every few minutes."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from enum import StrEnum
from typing import NamedTuple

from hmi.clock import Clock
from hmi.commands.camera_ports import CameraProcess, CamerasAway, NoPicture, Still
from hmi.commands.ports import LaneEvent
from hmi.domain.ids import new_id
from hmi.domain.picture import Moment, Picture, PictureKind
from hmi.domain.picture_header import BadPicture, read_picture
from hmi.domain.robot import Order, OrderStatus, Robot
from hmi.store.errors import StoreError
from hmi.store.picture_shelf import PictureShelf

LEAST_S = 20.0  # between two pictures of a robot, however short its rows are
MOST_WAITING = 8
OPEN_S = 1.0  # how old a picture may be where the camera is opened for it
STALE_S = 3.0  # a picture that was open anyway
log = logging.getLogger(__name__)


class MissionPicture(StrEnum):
    """When a picture of a mission is taken."""

    ROWS = "rows"
    MINUTES = "minutes"
    OFF = "off"


@dataclass(frozen=True, slots=True)
class MissionPictureParts:
    """What it is wired to.

    Attributes:
        mission_name: what people call a mission, empty if it is not stored.
        may_open: whether a camera that nobody looks at is opened for a picture.
        every_s: seconds between two pictures with ``MINUTES``.
    """

    process: CameraProcess
    shelf: PictureShelf
    clock: Clock
    farm_id: str
    cameras_of: Callable[[str], Sequence[str]]
    moment_of: Callable[[str, float], Moment]
    mission_name: Callable[[str], str]
    on_event: LaneEvent
    when: MissionPicture
    every_s: float
    may_open: bool


class Work(NamedTuple):
    """What a picture is of: by the time it is taken the robot may be done, or in the next row."""

    text: str
    mission_id: str
    row: int


class MissionPictures:
    """Follows robots at work; pictures are taken one after the other, in the background."""

    def __init__(self, parts: MissionPictureParts) -> None:
        self._parts = parts
        self._rows: dict[str, tuple[str, int]] = {}
        self._taken_s: dict[str, float] = {}
        self._waiting: set[str] = set()
        self._one = asyncio.Lock()
        self._tasks: set[asyncio.Task[None]] = set()

    def see(self, robot: Robot) -> None:
        """Look at a robot that changed."""
        order = None if robot.state is None else robot.state.order
        if self._parts.when is MissionPicture.OFF or order is None:
            return
        work = self._work(robot.id, order)
        if work is not None and self._is_due(robot.id):
            self._begin(robot.id, work)

    async def close(self) -> None:
        """Give up what is waited for."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    def _work(self, robot_id: str, order: Order) -> Work | None:
        """Return what a picture is taken of now, if one is."""
        mission_id, row = self._rows.get(robot_id, ("", 0))
        is_same = mission_id == order.mission_id
        if order.status is not OrderStatus.RUNNING:
            self._rows.pop(robot_id, None)
            is_last = order.status is OrderStatus.DONE and is_same
            return Work("End of the mission.", mission_id, row) if is_last else None
        self._rows[robot_id] = order.mission_id, order.row
        if self._parts.when is MissionPicture.MINUTES:
            return Work("During the mission.", order.mission_id, order.row)
        return Work(f"End of row {row}.", mission_id, row) if is_same and order.row > row > 0 else None

    def _is_due(self, robot_id: str) -> bool:
        every_s = self._parts.every_s if self._parts.when is MissionPicture.MINUTES else LEAST_S
        return self._parts.clock.mono_s() - self._taken_s.get(robot_id, float("-inf")) >= every_s

    def _begin(self, robot_id: str, work: Work) -> None:
        cameras = self._parts.cameras_of(robot_id)
        if not cameras or robot_id in self._waiting or len(self._waiting) >= MOST_WAITING:
            return
        if not self._parts.shelf.health().is_ok:
            return
        self._taken_s[robot_id] = self._parts.clock.mono_s()
        self._waiting.add(robot_id)
        task = asyncio.get_running_loop().create_task(self._take(robot_id, cameras[0], work), name="mission-picture")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _take(self, robot_id: str, camera: str, work: Work) -> None:
        try:
            async with self._one:
                await self._kept(robot_id, camera, work)
        except (NoPicture, CamerasAway, BadPicture, StoreError) as error:
            log.info("no picture of %s/%s: %s", robot_id, camera, error)
        except Exception:  # the end of a task: nobody above would say it
            log.exception("no picture of %s/%s", robot_id, camera)
        finally:
            self._waiting.discard(robot_id)

    async def _kept(self, robot_id: str, camera: str, work: Work) -> None:
        parts = self._parts
        still = await parts.process.still(robot_id, camera, OPEN_S if parts.may_open else None)
        now_s = parts.clock.mono_s()
        if now_s - still.captured_s > STALE_S:
            raise NoPicture("no_picture", "Its newest picture is old.")
        moment = replace(parts.moment_of(robot_id, still.captured_s), mission_id=work.mission_id,
                         mission_name=parts.mission_name(work.mission_id), row=work.row or None)  # fmt: skip
        one = draft(still, PictureKind.MISSION, parts.farm_id, robot_id, camera, parts.clock, moment, text=work.text)
        kept = await parts.shelf.keep(one, still.data)
        parts.on_event({"kind": "picture", "what": "kept", "id": kept.id, "robot": robot_id})


def draft(
    still: Still, kind: PictureKind, farm_id: str, robot_id: str, camera: str, clock: Clock, moment: Moment,
    *, text: str = "", note: str = "", by: str = "", device: str = "",
) -> Picture:  # fmt: skip
    """Return a picture as the shelf takes it; raises ``BadPicture`` if the bytes are none."""
    header, now, age_s = read_picture(still.data), clock.utc(), max(0.0, clock.mono_s() - still.captured_s)
    return Picture(
        id=new_id(), farm_id=farm_id, kind=kind, robot_id=robot_id, camera=camera,
        captured_at=now - timedelta(seconds=age_s), added_at=now, media_type=header.media_type,
        width_px=header.width_px, height_px=header.height_px, size_bytes=0, sha256="", moment=moment,
        age_s=round(age_s, 3) if still.is_dated else None, text=text, note=note, by=by, device=device,
    )  # fmt: skip

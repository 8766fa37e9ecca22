"""Pictures for the twin: each camera by itself, whatever another one does."""

from __future__ import annotations

import asyncio
from typing import Any

from hmi.app.twin_pictures import TwinPictures
from hmi.commands.camera_ports import NoPicture, Still

WANTED = {"weeder-01": ["front"], "weeder-02": ["front"]}


class Media:
    """Takes pictures."""

    def __init__(self) -> None:
        self.came: list[tuple[str, str]] = []

    async def picture(self, robot_id: str, camera: str, _data: bytes, _captured_s: float) -> None:
        """See ``MediaLink``."""
        self.came.append((robot_id, camera))


class Cameras:
    """The camera of one robot gives no picture, and it takes long to say so."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.gives_up = asyncio.Event()

    async def still(self, robot_id: str, _camera: str, _fresh_s: float | None) -> Still:
        """See ``CameraProcess``."""
        self.asked.append(robot_id)
        if robot_id == "weeder-02":
            await self.gives_up.wait()
            raise NoPicture("no_picture", "The camera shows no picture now.")
        return Still(b"jpeg", 1.0)


async def test_a_camera_without_a_picture_holds_up_no_other_and_is_asked_once_at_a_time() -> None:
    media, cameras = Media(), Cameras()
    link: Any = media
    process: Any = cameras
    pictures = TwinPictures(link, lambda: process)
    async with asyncio.timeout(10):
        while len(media.came) < 3:
            pictures.carry(WANTED)
            await asyncio.sleep(0)
        assert set(media.came) == {("weeder-01", "front")}
        assert cameras.asked.count("weeder-02") == 1
        cameras.gives_up.set()
        while cameras.asked.count("weeder-02") == 1:
            pictures.carry(WANTED)
            await asyncio.sleep(0)
        await pictures.close()

"""Kept pictures from a real camera process: a snapshot, a clip that plays, a frame of a field camera."""

from __future__ import annotations

import asyncio
import contextlib
import shutil
from datetime import UTC, datetime
from pathlib import Path

import av
import pytest

from hmi.app.camera_calls import camera_calls
from hmi.app.camera_rule import CameraRule
from hmi.clock import SystemClock
from hmi.commands.camera_ports import NoPicture
from hmi.commands.clip_keeper import ClipKeeper
from hmi.domain.incident import Cause, Incident
from hmi.domain.picture import Moment, Picture
from hmi.domain.role import Role
from hmi.store.pictures import PictureFilter
from tests.hmi.app.camera_console import camera_console, camera_process
from tests.hmi.cameras.fake_camera import FakeCamera, fake_camera
from tests.hmi.commands.field import FARM
from tests.hmi.pictures.jpeg import picture
from tests.hmi.pictures.rig import WEEDER, PictureRig


def decoded(path: Path) -> tuple[str, int]:
    """Return codec and number of pictures of a clip."""
    with av.open(str(path)) as video:
        stream = video.streams.video[0]
        return stream.codec_context.name, sum(1 for _ in video.decode(stream))


async def snapshot(rig: PictureRig) -> Picture:
    """Keep what the weeder's camera shows; a busy machine opens it late."""
    for _ in range(5):
        with contextlib.suppress(NoPicture):
            return await rig.desk.book.snapshot(rig.person(Role.OPERATOR), WEEDER, "front", "a stone")
    raise AssertionError("the camera shows nothing")


@pytest.mark.long
async def test_snapshots_clips_and_frames_pass_through_a_real_camera_process(tmp_path: Path, migrated: Path) -> None:
    shutil.copyfile(migrated, tmp_path / "headland.db")
    with camera_process(tmp_path), fake_camera(FakeCamera()) as robot:
        async with camera_console(tmp_path, robot) as console:
            process, clock = camera_calls(console.desk), SystemClock()
            rig = PictureRig(tmp_path, process=process)
            await rig.open()
            console.desk.rule = CameraRule(rig.desk.sources)

            kept = await snapshot(rig)
            assert (kept.width_px, kept.height_px) == (640, 480)
            assert kept.age_s is not None
            assert kept.age_s < 2.0
            assert (await rig.shelf.path(kept)).read_bytes().startswith(b"\xff\xd8")

            await process.record([(WEEDER, "front")])
            await asyncio.sleep(4.0)  # another process records in real time
            clips = ClipKeeper(process, rig.shelf, clock, FARM, rig.events.append)
            now_s = clock.mono_s()
            cause = Cause("stop", "STOP.", is_grave=True)
            incident = Incident(WEEDER, now_s - 1.0, datetime.now(UTC), Moment(), now_s, named=[cause])
            clips.cut(incident, ["front", "rear"])
            await clips.close()
            (clip,) = await rig.records.database.run(rig.records.pictures.some, FARM, PictureFilter(cause="stop"), 9)
            codec, count = decoded(await rig.shelf.path(clip))
            assert codec == "h264"
            assert count >= 8
            assert clip.duration_s is not None
            assert 1.5 < clip.duration_s < 6.0

            await process.record([])
            made = await rig.browser(Role.ADMIN).put("/cameras/field/barn/source", json={"kind": "upload"})
            token = {"Authorization": f"Bearer {made.json()['token']}"}
            with pytest.raises(NoPicture):
                await process.still("field", "barn", None)
            sent = await rig.browser(None).post("/cameras/field/barn/frame", content=picture(), headers=token)
            assert sent.status_code == 204
            assert (await process.still("field", "barn", None)).data == picture()
            await rig.close()

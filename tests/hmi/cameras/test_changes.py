"""A camera whose source changes, is opened anew, hangs, or is asked for a picture in full size."""

from __future__ import annotations

import asyncio
import struct
from typing import Any

import pytest

from hmi.cameras import camera as camera_module
from hmi.cameras import hub as hub_module
from hmi.cameras.camera import SILENT_S, Camera
from hmi.cameras.picture_wire import News
from hmi.cameras.ring import Rings
from hmi.clock import FakeClock
from hmi.domain.camera import CameraInfo, Recording, Source, SourceKind
from tests.hmi.cameras.fake_camera import FakeCamera, fake_camera, jpeg
from tests.hmi.cameras.rig import CameraRig, camera_rig
from tests.hmi.cameras.waiting import until

NOBODY = "http://127.0.0.1:9/video"  # the port of discard, where nothing listens


def newest_seq(rig: CameraRig) -> int:
    """Return the number of the last picture that the page got."""
    return int(struct.unpack("<I", rig.pictures[-1][16:20])[0])


async def test_what_the_old_place_sent_is_no_picture_of_the_new_one() -> None:
    async with camera_rig() as rig:
        rig.watch()
        await rig.until_pictures(2)
        await rig.tell(kind=SourceKind.MJPEG, url=NOBODY)
        assert (rig.camera.newest, rig.camera.newest_jpeg, rig.camera.group) == (None, None, [])
        assert await rig.hub.still(rig.camera, 1.0) is None
        assert rig.camera.reason == "nothing answers at the camera's address"
        before = newest_seq(rig)
        await rig.tell(kind=SourceKind.ROBOT, url=rig.robot.url)
        await rig.until_pictures(1)
        assert newest_seq(rig) > before, "numbers never begin again"


async def test_a_new_name_or_another_size_takes_no_picture_away() -> None:
    async with camera_rig() as rig:
        await rig.tell(kind=SourceKind.UPLOAD)
        rig.hub.upload(rig.camera, jpeg())
        await rig.tell(camera=CameraInfo("front", "Over the door", 320, 240), period_s=60.0)
        assert rig.camera.newest_jpeg is not None


@pytest.mark.slow
async def test_what_is_kept_over_a_change_of_source_belongs_to_one_source_each() -> None:
    async with camera_rig() as rig:
        rings = Rings(rig.clock)
        rings.set([Recording("weeder-01", "front", 15.0)], rig.hub.cameras)
        ring = rings.of("weeder-01", "front")
        assert ring is not None
        with fake_camera(FakeCamera(320, 240)) as other:
            await until(lambda: bool(ring.video.between(0, 1e15).pieces))
            assert rig.camera.describe()["is_kept"]
            await rig.tell(url=other.url)
            await until(lambda: ring.video.between(0, 1e15).has_before)
            new = ring.video.between(0, 1e15)
            old = ring.video.between(0, new.pieces[0].captured_ms - 0.001)
            assert ({one.width for one in new.pieces}, {one.width for one in old.pieces}) == ({320}, {640})
            assert not old.has_before
            rings.set([], rig.hub.cameras)
            assert not rig.camera.describe()["is_kept"]


@pytest.mark.slow
async def test_an_order_to_open_it_anew_is_neither_a_failure_nor_counted() -> None:
    async with camera_rig() as rig:
        rig.watch()
        await rig.until_pictures(2)
        pid = rig.camera.worker_pid
        rig.camera.restart()
        await until(lambda: rig.camera.worker_pid not in (pid, None))
        await rig.until_pictures(2)
        told = [one["camera"] for one in rig.said if one["k"] == "state"]
        assert {(one["restarts"], one["reason"]) for one in told} == {(0, "")}


@pytest.mark.slow
async def test_a_watched_camera_that_sends_by_itself_from_now_on_is_pulled_no_more_and_again_later() -> None:
    async with camera_rig() as rig:
        rig.watch()
        await rig.until_pictures(2)
        await rig.tell(kind=SourceKind.UPLOAD, url="")
        await until(lambda: rig.camera.worker_pid is None and rig.camera._task is None)
        assert (rig.camera.state, rig.camera.restarts) == ("idle", 0)
        rig.hub.upload(rig.camera, jpeg())
        await asyncio.sleep(0.8)  # longer than the first wait before a worker is started again
        assert (rig.camera.state, rig.camera.reason, rig.camera.worker_pid) == ("live", "", None)
        await rig.tell(kind=SourceKind.ROBOT, url=rig.robot.url)
        await until(lambda: rig.camera.worker_pid is not None)
        await rig.until_pictures(2)
        assert rig.camera.state == "live"


@pytest.mark.slow
async def test_a_camera_that_hangs_and_goes_on_sending_bytes_is_opened_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    async with camera_rig() as rig:
        rig.watch()
        await rig.until_pictures(2)
        monkeypatch.setattr(camera_module, "SILENT_S", 1.0)
        rig.robot.is_frozen = rig.robot.is_dripping = True
        await until(lambda: rig.camera.restarts == 1)
        assert rig.camera.reason.startswith("the camera sends nothing new")
        rig.robot.is_frozen = rig.robot.is_dripping = False
        await rig.until_pictures(2)
        assert (rig.camera.state, rig.camera.reason) == ("live", "")


@pytest.mark.slow
async def test_the_last_picture_of_a_hung_camera_is_not_new_because_it_is_opened_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with camera_rig() as rig:
        await rig.tell(kind=SourceKind.SNAPSHOT, url=f"{rig.robot.url}/shot.jpg", period_s=0.1)
        rig.watch()
        await rig.until_pictures(3)
        rig.robot.is_hung = True
        await until(lambda: rig.camera.state == "frozen")
        rig.read()
        count = len(rig.pictures)
        monkeypatch.setattr(camera_module, "SILENT_S", 1.5)
        await until(lambda: rig.camera.restarts == 2)
        rig.read()
        assert len(rig.pictures) == count
        assert rig.camera.reason == "the camera sends nothing new: the same picture again"
        rig.robot.is_hung = False
        await rig.until_pictures(1)


class PlayedWorker:
    """A worker that is only counted."""

    def __init__(self) -> None:
        self.ends = 0

    def let_go(self) -> None:
        """See ``WorkerProcess``."""
        self.ends += 1


def test_a_scene_that_stands_still_is_opened_anew_ever_more_rarely() -> None:
    clock = FakeClock()
    camera = Camera(Source("field", CameraInfo("gate", "Gate", 640, 480)), clock, 1280)
    waited: list[int] = []
    for _ in range(6):
        worker: Any = PlayedWorker()
        camera._began_s, seconds = clock.mono_s(), 0
        while not worker.ends:
            clock.advance(1.0)
            seconds += 1
            camera._end_silent(worker)
        waited.append(seconds)
    assert waited == [int(SILENT_S) + 1, 11, 21, 41, 61, 61]


def test_a_busy_machine_that_has_not_opened_a_camera_yet_does_not_call_it_silent() -> None:
    clock, worker = FakeClock(), PlayedWorker()
    camera = Camera(Source("field", CameraInfo("gate", "Gate", 640, 480)), clock, 1280)
    camera._began_s, camera._has_spoken = clock.mono_s(), False
    clock.advance(3 * SILENT_S)
    camera._end_silent(worker)  # type: ignore[arg-type]
    camera._heard(News(why="the same picture again", bad=1))
    clock.advance(SILENT_S - 1)
    camera._end_silent(worker)  # type: ignore[arg-type]
    assert worker.ends == 0
    clock.advance(2)
    camera._end_silent(worker)  # type: ignore[arg-type]
    assert (worker.ends, camera._ending) == (1, "the camera sends nothing new: the same picture again")


@pytest.mark.slow
async def test_a_picture_to_keep_is_as_large_as_the_camera_makes_it_whoever_watches() -> None:
    async with camera_rig() as rig:
        rig.robot.narrow = [jpeg(320, 240, number) for number in range(10)]
        rig.watch(width=300)
        await rig.until_pictures(2)
        kept, shown = await rig.hub.still(rig.camera, 1.0, is_full=True), await rig.hub.still(rig.camera, None)
        assert kept is not None
        assert shown is not None
        assert (kept.width, kept.height) == (640, 480)
        assert len(rig.camera.watches) == 1
        assert not any(type(one).__name__ == "_Glance" for one in rig.camera.hearers)


@pytest.mark.slow
async def test_a_camera_that_makes_no_larger_one_in_time_gives_the_one_that_is_watched(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(hub_module, "FULL_S", 0.3)
    async with camera_rig() as rig:
        rig.robot.pictures = [jpeg(320, 240, number) for number in range(10)]
        rig.watch(width=300)
        await rig.until_pictures(2)
        kept = await rig.hub.still(rig.camera, 1.0, is_full=True)
        assert kept is not None
        assert kept.width == 320

"""One camera with a real worker: what it pulls, how it fails, and how it comes back."""

from __future__ import annotations

import os
import signal
import struct

import msgspec
import psutil
import pytest

from hmi.cameras import camera as camera_module
from hmi.cameras.demand import Way, Wish
from hmi.cameras.picture_wire import Piece
from hmi.cameras.ring import Rings
from hmi.cameras.worker import MEMORY_BYTES
from hmi.domain.camera import Recording, SourceKind
from tests.hmi.cameras.fake_camera import jpeg
from tests.hmi.cameras.rig import camera_rig
from tests.hmi.cameras.waiting import until


@pytest.mark.slow
async def test_nothing_is_pulled_until_somebody_looks_and_then_the_robots_own_jpeg_is_passed_on() -> None:
    async with camera_rig() as rig:
        assert (rig.camera.state, rig.robot.asked) == ("idle", [])
        rig.watch()
        assert rig.camera.state == "starting"
        await rig.until_pictures(3)
        assert rig.camera.state == "live"
        assert rig.pictures[0][24:] in rig.robot.pictures
        assert psutil.Process(rig.camera.worker_pid).rlimit(psutil.RLIMIT_AS)[0] == MEMORY_BYTES
        _, _, flags, width, captured, _, height, _ = struct.unpack("<4sBBHdIHH", rig.pictures[-1][:24])
        assert (flags, width, height) == (1, 640, 480)
        assert rig.clock.mono_s() * 1000 - captured >= rig.robot.age_ms


async def test_a_smaller_picture_is_asked_of_the_robot_and_made_here_if_it_sends_a_large_one() -> None:
    async with camera_rig() as rig:
        rig.watch(width=300, fps=4)
        await rig.until_pictures(2)
        asked = rig.robot.asked[-1]
        assert (asked["path"], asked["fps"], asked["width"]) == ("/weeder-01/cameras/front/stream", "4", "320")
        width, height = struct.unpack("<H", rig.pictures[-1][6:8])[0], struct.unpack("<H", rig.pictures[-1][20:22])[0]
        assert (width, height) == (320, 240)


@pytest.mark.slow
async def test_the_source_is_let_go_after_the_last_viewer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(camera_module, "LINGER_S", 0.3)
    async with camera_rig() as rig:
        rig.watch()
        await rig.until_pictures(1)
        worker = psutil.Process(rig.camera.worker_pid)
        rig.drop()
        await until(lambda: rig.robot.open == 0 and not worker.is_running())
        assert rig.camera.state == "idle"


@pytest.mark.slow
async def test_a_killed_worker_loses_one_camera_which_comes_back_and_says_why() -> None:
    async with camera_rig() as rig:
        rig.watch()
        await rig.until_pictures(2)
        first_pid = rig.camera.worker_pid
        assert first_pid is not None
        os.kill(first_pid, signal.SIGKILL)
        await until(lambda: rig.camera.restarts == 1)
        assert rig.camera.reason == "its decoder crashed (SIGKILL)"
        sequence = [struct.unpack("<I", picture[16:20])[0] for picture in rig.pictures]
        await rig.until_pictures(2)
        assert rig.camera.state == "live"
        assert rig.camera.worker_pid != first_pid
        assert struct.unpack("<I", rig.pictures[-1][16:20])[0] > max(sequence), "numbers never begin again"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("instead", "why"),
    [
        (b"no picture at all", "not a JPEG"),
        pytest.param(jpeg()[:9000], "cut off", marks=pytest.mark.long),
        (jpeg(64, 64).replace(struct.pack(">HH", 64, 64), struct.pack(">HH", 16_384, 16_384), 1), "too many"),
        pytest.param(b"", "not a JPEG", marks=pytest.mark.long),
    ],
    ids=["garbage", "truncated", "16k", "empty"],
)
async def test_what_is_no_picture_is_counted_and_told_and_ends_nothing(instead: bytes, why: str) -> None:
    async with camera_rig() as rig:
        rig.watch()
        await rig.until_pictures(2)
        rig.robot.instead = instead
        await until(lambda: rig.camera.state == "frozen" and why in rig.camera.reason)
        pid, rig.robot.instead = rig.camera.worker_pid, None
        await rig.until_pictures(2)
        assert (rig.camera.state, rig.camera.reason, rig.camera.restarts) == ("live", "", 0)
        assert rig.camera.worker_pid == pid


@pytest.mark.long
async def test_pictures_that_cannot_be_decoded_do_not_stop_those_who_take_jpeg() -> None:
    broken = bytearray(jpeg())
    broken[400:2000] = os.urandom(1600).replace(b"\xff", b"\x00")
    async with camera_rig() as rig:
        rig.watch(1)
        rig.watch(2, width=200)
        await rig.until_pictures(4)
        rig.robot.instead = bytes(broken)
        await rig.until_pictures(10)
        assert rig.camera.restarts == 0


@pytest.mark.slow
async def test_a_camera_that_sends_nothing_new_is_frozen_within_seconds() -> None:
    async with camera_rig() as rig:
        rig.watch()
        await rig.until_pictures(2)
        rig.robot.is_frozen = True
        await until(lambda: rig.camera.state == "frozen", 3.0)
        rig.robot.is_frozen = False
        await until(lambda: rig.camera.state == "live")


class Recorder:
    """Takes direct pictures."""

    wish, is_person = Wish(Way.H264), False

    def __init__(self) -> None:
        self.pieces: list[Piece] = []

    def take(self, piece: Piece) -> None:
        """See ``Watch``."""
        self.pieces.append(piece)


@pytest.mark.slow
async def test_the_last_picture_of_a_frozen_camera_is_given_to_who_comes_late_and_makes_nothing_live() -> None:
    async with camera_rig() as rig:
        recorder = Recorder()
        rig.camera.join(recorder)
        await until(lambda: recorder.pieces)
        rig.robot.is_frozen = True
        await until(lambda: rig.camera.state == "frozen")
        count, rig.camera.reason = len(recorder.pieces), "what is wrong with it"
        rig.camera.ask_key()
        await until(lambda: len(recorder.pieces) > count)
        assert recorder.pieces[-1].captured_ms == recorder.pieces[count - 1].captured_ms
        assert (rig.camera.state, rig.camera.reason) == ("frozen", "what is wrong with it")


@pytest.mark.slow
async def test_a_robot_that_refuses_is_failed_with_its_own_words_and_tried_again() -> None:
    async with camera_rig() as rig:
        rig.robot.refusal = (503, msgspec.json.encode({"code": "camera_down", "text": "The node perception is off."}))
        rig.watch()
        await until(lambda: rig.camera.state == "failed")
        assert rig.camera.reason == "The node perception is off."
        rig.robot.refusal = None
        await rig.until_pictures(1)
        assert (rig.camera.state, rig.camera.reason) == ("live", "")


@pytest.mark.long
async def test_restart_does_not_wait_for_the_back_off(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(camera_module, "BACKOFF_S", (60.0,))
    async with camera_rig() as rig:
        rig.robot.refusal = (401, b"")
        rig.watch()
        await until(lambda: rig.camera.state == "failed")
        assert "password or token" in rig.camera.reason
        rig.robot.refusal = None
        rig.camera.restart()
        await rig.until_pictures(1)


@pytest.mark.long
async def test_a_robot_that_is_not_connected_is_off_unless_its_pictures_come() -> None:
    async with camera_rig() as rig:
        await rig.tell(is_on=False)
        assert rig.camera.state == "off"
        rig.watch()
        await rig.until_pictures(1)
        assert rig.camera.state == "live", "what is seen counts"
        rig.robot.is_frozen = True
        await until(lambda: rig.camera.state == "off")


@pytest.mark.long
async def test_another_source_is_opened_as_soon_as_it_is_told() -> None:
    async with camera_rig() as rig:
        rig.watch()
        await rig.until_pictures(1)
        other = rig.robot.url.replace("/weeder-01", "/elsewhere")
        await rig.tell(kind=SourceKind.MJPEG, url=f"{other}/stream")
        await until(lambda: rig.robot.asked[-1]["path"] == "/elsewhere/stream")
        await rig.until_pictures(1)


@pytest.mark.slow
async def test_another_source_is_not_opened_for_nobody() -> None:
    async with camera_rig() as rig:
        rig.watch()
        await rig.until_pictures(1)
        rig.drop()
        asked = len(rig.robot.asked)
        await rig.tell(kind=SourceKind.MJPEG, url=rig.robot.url.replace("/weeder-01", "/elsewhere/stream"))
        await until(lambda: rig.robot.open == 0 and rig.camera.worker_pid is None)
        assert rig.camera.state == "idle"
        assert len(rig.robot.asked) == asked


@pytest.mark.long
async def test_a_snapshot_address_is_asked_again_and_again() -> None:
    async with camera_rig() as rig:
        await rig.tell(kind=SourceKind.SNAPSHOT, url=f"{rig.robot.url}/shot.jpg", period_s=0.1)
        rig.watch()
        await rig.until_pictures(3)
        assert len(rig.robot.asked) >= 3


@pytest.mark.slow
async def test_a_camera_that_hangs_and_answers_with_its_last_picture_is_frozen() -> None:
    async with camera_rig() as rig:
        await rig.tell(kind=SourceKind.SNAPSHOT, url=f"{rig.robot.url}/shot.jpg", period_s=0.1)
        rig.watch()
        await rig.until_pictures(3)
        rig.robot.is_hung = True
        await until(lambda: rig.camera.state == "frozen" and "the same picture again" in rig.camera.reason)
        rig.robot.is_hung = False
        await until(lambda: rig.camera.state == "live")


async def test_a_still_looks_for_a_moment_when_nobody_else_does() -> None:
    async with camera_rig() as rig:
        assert await rig.hub.still(rig.camera, None) is None
        piece = await rig.hub.still(rig.camera, 1.0)
        assert piece is not None
        assert piece.data in rig.robot.pictures
        assert len(rig.camera.watches) == 0


async def test_more_cameras_than_allowed_are_refused_in_words_and_recorders_are_no_viewers() -> None:
    async with camera_rig() as rig:
        rig.hub._most_workers = 0
        rig.watch()
        await until(lambda: rig.camera.state == "failed")
        assert rig.camera.reason == "0 cameras run already, which is the most allowed here"
        rings = Rings(rig.clock)
        rings.set([Recording("weeder-01", "front")], rig.hub.cameras)
        assert rig.camera.describe()["viewers"] == 1
        rings.set([], rig.hub.cameras)
        assert len(rig.camera.watches) == 1

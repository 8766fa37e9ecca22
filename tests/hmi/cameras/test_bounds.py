"""What a stream may hold: pictures in pixels, answers in bytes, and which still is the newest."""

from __future__ import annotations

import asyncio
from dataclasses import replace

import av
import httpx
import pytest

from hmi.cameras.addresses import Target
from hmi.cameras.camera import NEWEST_S, Camera
from hmi.cameras.encoders import Decoder, VideoEncoder
from hmi.cameras.hub import STILL_S, Hub
from hmi.cameras.inbox import Inbox
from hmi.cameras.picture_wire import Kind, Piece
from hmi.cameras.pull_http import PullFailed
from hmi.cameras.pull_whep import MAX_ANSWER_BYTES, WhepPull
from hmi.clock import SystemClock
from hmi.domain.camera import CameraInfo, Source, SourceKind
from tests.hmi.cameras.fake_camera import jpeg

SOURCE = Source("weeder-01", CameraInfo("front", "Front", 640, 480), SourceKind.WHEP, "http://192.0.2.1/whep")


def test_h264_of_too_many_pixels_is_not_decoded(monkeypatch: pytest.MonkeyPatch) -> None:
    def unit(width: int) -> bytes:
        frame = av.VideoFrame(width, 240, "yuv420p")
        made = VideoEncoder("libx264", 15).encode(frame, 0.0, is_key=True)
        assert made is not None
        return made[0]

    monkeypatch.setattr("hmi.cameras.encoders.MAX_PIXELS", 320 * 240)
    assert Decoder("h264").decode(unit(320)) is not None
    with pytest.raises(av.FFmpegError):
        Decoder("h264").decode(unit(640))


async def test_an_answer_without_end_is_not_read_to_its_end() -> None:
    sent = 0

    async def endless(_request: httpx.Request) -> httpx.Response:
        async def pieces():  # type: ignore[no-untyped-def]
            nonlocal sent
            while True:
                sent += 1024
                yield b"x" * 1024

        return httpx.Response(201, content=pieces())

    async with httpx.AsyncClient(transport=httpx.MockTransport(endless)) as client, asyncio.timeout(5):
        with pytest.raises(PullFailed, match="not understood"):
            await WhepPull(SOURCE, Inbox())._answer(client, Target(SOURCE.url, "192.0.2.1", "192.0.2.1"), "offer")
    assert sent <= MAX_ANSWER_BYTES + 1024


async def test_a_camera_that_sends_by_itself_is_not_waited_for() -> None:
    hub = Hub(SystemClock(), 1280)
    await hub.set_sources([replace(SOURCE, kind=SourceKind.UPLOAD, url="")])
    camera = hub.cameras[SOURCE.name]
    async with asyncio.timeout(STILL_S / 2):
        assert await hub.still(camera, 1.0) is None
        hub.upload(camera, jpeg(64, 48), 300_000.0)
        assert await hub.still(camera, 1.0) is camera.newest_jpeg
    assert camera.newest_jpeg is not None


async def test_a_large_still_that_nobody_renews_gives_way_to_a_smaller_one() -> None:
    camera = Camera(SOURCE, SystemClock(), 1280)

    def take(captured_ms: float, width: int) -> int:
        camera._take(Piece(Kind.JPEG, b"x", captured_ms, 1, width, 480, wanted_width=width))
        assert camera.newest_jpeg is not None
        return camera.newest_jpeg.width

    assert take(1000.0, 640) == 640
    assert take(1100.0, 320) == 640, "the larger one of about the same time"
    assert take(1000.0 + NEWEST_S * 1000 + 1.0, 320) == 320
    assert take(2100.0, 640) == 640

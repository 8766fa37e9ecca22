"""One page's socket: the newest picture of each stream and never a queue."""

from __future__ import annotations

import json
import struct
from typing import Any

import pytest

from hmi.cameras.hub import Hub
from hmi.cameras.jpeg_header import BadPicture
from hmi.cameras.pages import Page
from hmi.clock import FakeClock
from hmi.domain.camera import CameraInfo, Source, SourceKind
from tests.hmi.cameras.fake_camera import jpeg

PICTURE = jpeg(64, 48)


class Rig:
    """A page and a field camera that sends when told."""

    def __init__(self) -> None:
        self.clock = FakeClock()
        self.hub = Hub(self.clock, 1280)
        self.page = Page(self.hub, self.clock, "viewer")

    async def prepare(self) -> Rig:
        """Let the cameras exist."""
        places = [CameraInfo(name, name, 64, 48, fps=15.0) for name in ("one", "two")]
        await self.hub.set_sources([Source("field", info, SourceKind.UPLOAD) for info in places])
        self.said()
        return self

    def say(self, **frame: Any) -> bool:
        """Send a frame."""
        return self.page.hear(json.dumps(frame))

    def watch(self, n: int = 1, camera: str = "one", way: str = "jpeg", **more: Any) -> None:
        """Begin a stream."""
        assert self.say(k="watch", n=n, robot="field", camera=camera, way=way, **more)

    def shot(self, camera: str = "one", after_s: float = 0.1) -> None:
        """Let a camera send a picture."""
        self.clock.advance(after_s)
        found = self.hub.get("field", camera)
        assert found is not None
        self.hub.upload(found, PICTURE)

    def said(self) -> list[Any]:
        """Return what the page is sent now: dicts, and ``(n, seq)`` of pictures."""
        out: list[Any] = []
        while (item := self.page.next()) is not None:
            if isinstance(item, str):
                out.append(json.loads(item))
            else:
                magic, n, _, width, captured, seq, height, _ = struct.unpack("<4sBBHdIHH", item[:24])
                assert (magic, width, height, item[24:]) == (b"HLC1", 64, 48, PICTURE)
                assert captured == pytest.approx(self.clock.mono_s() * 1000, abs=10_000)
                out.append((n, seq))
        return out

    def pictures(self) -> list[tuple[int, int]]:
        """Return the pictures among what is sent."""
        return [item for item in self.said() if isinstance(item, tuple)]


async def test_hello_names_the_watcher_and_the_state_comes_at_once() -> None:
    rig = Rig()
    hello = json.loads(str(rig.page.next()))
    assert (hello["k"], hello["watcher"], hello["m"]) == ("hello", rig.page.token, 1_000_000.0)
    await rig.prepare()
    rig.watch()
    (state,) = rig.said()
    assert (state["k"], state["n"], state["camera"]["state"]) == ("state", 1, "idle")


async def test_a_page_that_does_not_keep_up_gets_the_newest_picture_only() -> None:
    rig = await Rig().prepare()
    rig.watch()
    rig.said()
    for _ in range(10):
        rig.shot()
    assert rig.pictures() == [(1, 10)]


async def test_streams_take_turns() -> None:
    rig = await Rig().prepare()
    rig.watch(1, "one")
    rig.watch(2, "two")
    rig.said()
    rig.shot("one")
    rig.shot("two")
    rig.shot("one")
    assert sorted(rig.pictures()) == [(1, 2), (2, 1)]


async def test_a_page_that_acknowledges_has_at_most_two_pictures_under_way() -> None:
    rig = await Rig().prepare()
    rig.watch()
    rig.say(k="seen", n=1, seq=0)
    sent: list[tuple[int, int]] = []
    for _ in range(6):
        rig.shot()
        sent += rig.pictures()
    assert sent == [(1, 1), (1, 2)]
    rig.say(k="seen", n=1, seq=1)
    assert rig.pictures() == [(1, 6)], "what is newest now, and nothing in between"


async def test_stills_come_twice_a_second() -> None:
    rig = await Rig().prepare()
    rig.watch(way="still")
    sent = 0
    for _ in range(40):
        rig.shot()
        sent += len(rig.pictures())
    assert 7 <= sent <= 9


async def test_a_dropped_stream_is_silent_and_the_camera_has_no_viewer() -> None:
    rig = await Rig().prepare()
    rig.watch()
    camera = rig.hub.get("field", "one")
    assert camera is not None
    assert camera.describe()["viewers"] == 1
    rig.say(k="drop", n=1)
    rig.said()
    rig.shot()
    assert rig.said() == []
    assert camera.describe()["viewers"] == 0


async def test_what_does_not_exist_is_refused_in_words() -> None:
    rig = await Rig().prepare()
    rig.watch(camera="none")
    assert rig.said() == [{"k": "refused", "n": 1, "code": "unknown_camera", "text": "There is no such camera."}]
    rig.watch(n=65)
    assert rig.said()[0]["code"] == "too_many_streams"


async def test_a_camera_that_is_taken_away_is_said_to_be_gone() -> None:
    rig = await Rig().prepare()
    rig.watch()
    rig.said()
    for camera in await rig.hub.set_sources([]):
        rig.page.forget(camera)
    assert rig.said()[0]["code"] == "unknown_camera"
    assert rig.page.streams == {}


@pytest.mark.parametrize("text", ["", "[]", '{"k":"watch"}', '{"k":"open"}', '{"k":"ping","m":"x"}', "[" * 5000])
def test_what_is_no_frame_is_told_from_one(text: str) -> None:
    assert not Rig().page.hear(text)


async def test_a_page_counts_as_gone_after_a_second_and_a_half_of_silence() -> None:
    rig = await Rig().prepare()
    for _ in range(10):
        rig.clock.advance(1.4)
        assert not rig.page.is_silent
        rig.say(k="ping", m=5.0)
    assert {"k": "pong", "m": 5.0, "at": 1_014_000.0} in rig.said()
    rig.clock.advance(1.6)
    assert rig.page.is_silent


async def test_time_in_which_the_process_itself_stood_still_is_not_silence() -> None:
    rig = await Rig().prepare()
    rig.clock.advance(5.0)
    rig.page.forgive(4.7)
    assert not rig.page.is_silent
    rig.page.forgive(100.0)
    rig.clock.advance(1.6)
    assert rig.page.is_silent


async def test_a_field_camera_is_live_frozen_and_back_by_its_own_period() -> None:
    rig = await Rig().prepare()
    info = CameraInfo("one", "one", 64, 48)
    await rig.hub.set_sources([Source("field", info, SourceKind.UPLOAD, period_s=5.0)])
    camera = rig.hub.get("field", "one")
    assert camera is not None
    assert camera.state == "idle"
    rig.shot()
    assert camera.state == "live"
    rig.clock.advance(14.9)
    assert camera.state == "live"
    rig.clock.advance(0.2)
    assert camera.state == "frozen"
    rig.shot()
    assert camera.state == "live"


async def test_who_comes_between_two_uploads_sees_the_last_one_as_old_as_it_is() -> None:
    rig = await Rig().prepare()
    camera = rig.hub.get("field", "one")
    assert camera is not None
    rig.hub.upload(camera, PICTURE, age_ms=120_000.0)
    assert camera.state == "frozen", "it came now, and is old"
    assert rig.page.hear('{"k":"watch","n":1,"robot":"field","camera":"one","way":"jpeg"}')
    sent = []
    while (item := rig.page.next()) is not None:
        sent += [item] if isinstance(item, bytes) else []
    (shown,) = sent
    assert shown[24:] == PICTURE
    assert struct.unpack("<d", shown[8:16])[0] == pytest.approx(rig.clock.mono_s() * 1000 - 120_000.0)
    rig.hub.upload(camera, PICTURE, age_ms=130_000.0)
    assert rig.page.next() is None, "what was taken before it comes too late"
    for age_ms in (-1.0, float("nan"), float("inf")):
        with pytest.raises(BadPicture):
            rig.hub.upload(camera, PICTURE, age_ms=age_ms)


async def test_an_upload_that_is_no_picture_is_refused() -> None:
    rig = await Rig().prepare()
    camera = rig.hub.get("field", "one")
    assert camera is not None
    with pytest.raises(BadPicture):
        rig.hub.upload(camera, b"<html>")

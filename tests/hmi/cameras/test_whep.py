"""WebRTC by WHEP with aiortc as the viewer: one encoder, many viewers, and nothing that stays behind."""

from __future__ import annotations

import asyncio
import gc

import psutil
import pytest
from aiortc import RTCDtlsTransport, RTCPeerConnection, RTCRtpReceiver, RTCRtpSender

from hmi.cameras import whep as whep_module
from hmi.cameras.demand import Way
from hmi.cameras.whep import WhepRefused, way_of, without_local
from hmi.domain.camera import CameraInfo
from tests.hmi.cameras.rig import CameraRig, camera_rig
from tests.hmi.cameras.waiting import until


@pytest.mark.slow
async def test_a_viewer_sees_the_picture_and_each_is_named_by_its_rtp_time() -> None:
    async with camera_rig() as rig:
        rig.watch(2, "times")
        viewer = await rig.view("H264")
        frames = [await viewer.frame() for _ in range(6)]
        assert (frames[0].width, frames[0].height) == (640, 480)
        await until(lambda: _times(rig))
        rtp, captured, seq = _times(rig)[-1]
        assert seq > 0
        assert 0 <= rig.clock.mono_s() * 1000 - captured < 5000
        steps = [after[0] - before[0] for before, after in zip(_times(rig), _times(rig)[1:], strict=False)]
        assert all(0 < step % 2**32 < 90_000 for step in steps), "90 kHz, growing"
        assert rtp < 2**32
        await viewer.close()


@pytest.mark.slow
async def test_a_small_picture_is_encoded_small_and_a_large_one_large_without_a_new_connection() -> None:
    async with camera_rig(width=1280, height=960) as rig:
        await rig.tell(camera=CameraInfo("front", "Front", 1280, 960))
        rig.watch(2, "times", width=300)
        viewer = await rig.view("H264")
        assert (await viewer.frame()).width == 320
        rig.watch(2, "times", width=640)
        async with asyncio.timeout(5):
            while (await viewer.frame()).width != 640:
                pass
        assert len(rig.whep.sessions) == 1
        await viewer.close()


@pytest.mark.long
async def test_a_viewer_that_knows_only_vp8_gets_vp8() -> None:
    async with camera_rig() as rig:
        viewer = await rig.view("VP8")
        assert (await viewer.frame()).width == 640
        assert rig.whep.sessions[viewer.session_id].way is Way.VP8
        await viewer.close()


async def test_who_comes_late_gets_a_picture_at_once_even_of_a_slow_camera() -> None:
    async with camera_rig(fps=0.1) as rig:
        rig.watch(way="jpeg")
        await rig.until_pictures(1)
        viewer = await rig.view()
        async with asyncio.timeout(1.5):  # the next picture of the camera comes in ten seconds
            while not await viewer.packets():  # noqa: ASYNC110 - another peer's counter
                await asyncio.sleep(0.02)
        await viewer.close()


async def test_sessions_end_with_the_page_they_belong_to() -> None:
    async with camera_rig() as rig:
        viewer = await rig.view()
        await viewer.frame()
        assert rig.camera.describe()["viewers"] == 1
        await rig.whep.end_of(rig.page)
        assert rig.whep.sessions == {}
        assert rig.camera.describe()["viewers"] == 0
        await viewer.close()


async def test_a_viewer_whose_way_does_not_open_is_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(whep_module, "CONNECT_S", 0.3)
    async with camera_rig() as rig:
        peer = RTCPeerConnection()
        peer.addTransceiver("video", direction="recvonly")
        offer = await peer.createOffer()
        await peer.setLocalDescription(offer)
        lonely = "\r\n".join(
            line for line in peer.localDescription.sdp.split("\r\n") if not line.startswith("a=candidate")
        )
        await rig.whep.open(rig.page, rig.camera, lonely)
        assert len(rig.whep.sessions) == 1
        await until(lambda: not rig.whep.sessions)
        await peer.close()


@pytest.mark.parametrize(
    "offer", ["", "v=0", "m=video 9 UDP/TLS/RTP/SAVPF 96\r\na=rtpmap:96 VP8/90000\r\n", "\x00" * 99]
)
async def test_what_is_no_offer_is_refused_and_leaves_nothing(offer: str) -> None:
    async with camera_rig() as rig:
        with pytest.raises(WhepRefused):
            await rig.whep.open(rig.page, rig.camera, offer)
        assert rig.whep.sessions == {}
        assert rig.camera.watches == set()


async def test_no_more_viewers_than_allowed() -> None:
    async with camera_rig() as rig:
        rig.whep._most = 0
        with pytest.raises(WhepRefused) as no:
            await rig.view()
        assert (no.value.status, no.value.code) == (429, "too_many_viewers")


def test_candidates_with_names_only_the_browser_knows_are_taken_out() -> None:
    kept = "a=candidate:1 1 udp 2113937151 192.0.2.7 51000 typ host\r\n"
    gone = "a=candidate:2 1 udp 2113937151 1f4712db-ea17-4bcf-a596-105139dfd8bf.local 51001 typ host\r\n"
    assert without_local(f"v=0\r\n{gone}{kept}{gone}a=mid:0\r\n") == f"v=0\r\n{kept}a=mid:0\r\n"


@pytest.mark.parametrize(
    ("offer", "way"),
    [
        ("a=rtpmap:96 VP8/90000\r\na=rtpmap:97 H264/90000\r\na=fmtp:97 packetization-mode=1\r\n", Way.H264),
        ("a=rtpmap:96 VP8/90000\r\na=rtpmap:97 H264/90000\r\na=fmtp:97 packetization-mode=0\r\n", Way.VP8),
        ("a=rtpmap:96 VP8/90000\r\n", Way.VP8),
    ],
)
def test_h264_is_taken_where_the_viewer_can(offer: str, way: Way) -> None:
    assert way_of(offer) is way


def test_aiortc_has_what_is_used_beyond_its_interface() -> None:
    source = RTCRtpSender._handle_rtcp_packet.__code__.co_names
    assert "_send_keyframe" in source
    assert "_handle_rtp_packet" in RTCDtlsTransport._handle_rtp_data.__code__.co_names
    assert callable(RTCRtpReceiver._send_rtcp_pli)
    assert "_RTCRtpSender__rtp_timestamp" in RTCRtpSender._run_rtp.__code__.co_names


async def _cycles(count: int) -> None:
    async with camera_rig() as rig:
        viewer = await rig.view()
        await viewer.frame()
        gc.collect()
        tasks, files = len(asyncio.all_tasks()), psutil.Process().num_fds()
        for number in range(count):
            other = await rig.view()
            if number % 2:
                await other.frame()
            await rig.whep.sessions[other.session_id].end()
            await other.close()
        await until(lambda: len(asyncio.all_tasks()) <= tasks)
        gc.collect()
        assert len(rig.whep.sessions) == 1
        assert rig.camera.describe()["viewers"] == 1
        assert psutil.Process().num_fds() <= files + 1
        assert sum(isinstance(one, RTCPeerConnection) for one in gc.get_objects()) <= 4
        await viewer.frame()
        await viewer.close()


@pytest.mark.slow
async def test_twelve_viewers_that_come_and_go_leave_nothing_behind() -> None:
    await _cycles(12)


@pytest.mark.long
async def test_two_hundred_viewers_that_come_and_go_leave_nothing_behind() -> None:
    await _cycles(200)


def _times(rig: CameraRig) -> list[list[float]]:
    rig.read()
    return [row for said in rig.said if said["k"] == "times" for row in said["p"]]

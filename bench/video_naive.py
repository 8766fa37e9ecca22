"""The usual way with aiortc: one track through a ``MediaRelay``, and an encoder for each viewer."""

from __future__ import annotations

import asyncio
import fractions
import json
import subprocess
import sys
import time

from aiortc import MediaStreamTrack, RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription
from aiortc.contrib.media import MediaRelay
from aiortc.rtp import RtpPacket
from av import VideoFrame

from hmi.cameras.encoders import Decoder, fitted
from hmi.cameras.pull_whep import take_packets
from tests.hmi.cameras.fake_camera import jpeg

FPS = 15
SETTLE_S = 2.0


class Pictures(MediaStreamTrack):
    """The same pictures as ours, decoded once each, 15 a second."""

    kind = "video"

    def __init__(self) -> None:
        super().__init__()
        self._jpegs = [jpeg(number=number) for number in range(10)]
        self._decoder, self._number, self._began_s = Decoder("mjpeg"), 0, time.monotonic()

    async def recv(self) -> VideoFrame:
        """See ``MediaStreamTrack``."""
        self._number += 1
        await asyncio.sleep(max(0.0, self._began_s + self._number / FPS - time.monotonic()))
        decoded = self._decoder.decode(self._jpegs[self._number % 10])
        assert decoded is not None
        frame = fitted(decoded, 0, "yuv420p")
        frame.pts, frame.time_base = self._number * 90_000 // FPS, fractions.Fraction(1, 90_000)
        return frame


async def measure(viewers: int, seconds: float) -> float:
    """Return the CPU of this process in percent of a core; viewers are in another."""
    arguments = [sys.executable, "-m", "bench.video_naive", str(viewers)]
    clients = await asyncio.create_subprocess_exec(
        *arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, limit=2**20
    )
    assert clients.stdin is not None
    assert clients.stdout is not None
    relay, source = MediaRelay(), Pictures()
    peers = []
    for _ in range(viewers):
        peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        transceiver = peer.addTransceiver(relay.subscribe(source), direction="sendonly")
        known = RTCRtpSender.getCapabilities("video")
        transceiver.setCodecPreferences([one for one in known.codecs if one.mimeType == "video/H264"])
        offer = json.loads(await clients.stdout.readline())
        await peer.setRemoteDescription(RTCSessionDescription(offer, "offer"))
        await peer.setLocalDescription(await peer.createAnswer())
        clients.stdin.write(json.dumps(peer.localDescription.sdp).encode() + b"\n")
        peers.append(peer)
    await asyncio.sleep(SETTLE_S)
    before_s, began_s = time.process_time(), time.monotonic()
    await asyncio.sleep(seconds)
    pct = 100 * (time.process_time() - before_s) / (time.monotonic() - began_s)
    clients.terminate()
    await clients.wait()
    await asyncio.gather(*(peer.close() for peer in peers))
    return pct


async def _view(viewers: int) -> None:
    async def drop(packet: RtpPacket, arrival_time_ms: int) -> None:
        """Count nothing, decode nothing."""

    loop = asyncio.get_running_loop()
    for _ in range(viewers):
        peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        take_packets(peer.addTransceiver("video", direction="recvonly").receiver, drop)
        await peer.setLocalDescription(await peer.createOffer())
        print(json.dumps(peer.localDescription.sdp), flush=True)
        answer = json.loads(await loop.run_in_executor(None, sys.stdin.readline))
        await peer.setRemoteDescription(RTCSessionDescription(answer, "answer"))
    await asyncio.Event().wait()


if __name__ == "__main__":
    asyncio.run(_view(int(sys.argv[1])))

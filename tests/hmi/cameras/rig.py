"""A hub with real workers in front of a real HTTP camera, and a page to look with."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import Any

from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpReceiver, RTCSessionDescription

from hmi.cameras.camera import Camera
from hmi.cameras.hub import Hub
from hmi.cameras.pages import Page
from hmi.cameras.whep import WhepDesk
from hmi.clock import SystemClock
from hmi.domain.camera import CameraInfo, Source, SourceKind
from tests.hmi.cameras.fake_camera import TOKEN, FakeCamera, fake_camera
from tests.hmi.cameras.waiting import until


class CameraRig:
    """What a test holds."""

    def __init__(self, robot: FakeCamera, clock: SystemClock) -> None:
        self.robot, self.clock = robot, clock
        self.hub, self.whep = Hub(clock, 1280), WhepDesk(40)
        self.page = Page(self.hub, clock, "viewer")
        self.source = Source("weeder-01", CameraInfo("front", "Front", 640, 480), SourceKind.ROBOT, robot.url, TOKEN)
        self.pictures: list[bytes] = []
        self.said: list[dict[str, Any]] = []

    @property
    def camera(self) -> Camera:
        """The camera."""
        found = self.hub.get("weeder-01", "front")
        assert found is not None
        return found

    async def tell(self, **changes: Any) -> None:
        """Tell the hub of the source."""
        self.source = replace(self.source, **changes)
        await self.hub.set_sources([self.source])

    def watch(self, n: int = 1, way: str = "jpeg", **more: Any) -> None:
        """Let the page look."""
        frame = {"k": "watch", "n": n, "robot": "weeder-01", "camera": "front", "way": way, **more}
        assert self.page.hear(json.dumps(frame))

    def drop(self, n: int = 1) -> None:
        """Let the page look away."""
        self.page.hear(json.dumps({"k": "drop", "n": n}))

    def read(self) -> None:
        """Take everything the page is sent now."""
        while (item := self.page.next()) is not None:
            if isinstance(item, str):
                self.said.append(json.loads(item))
            else:
                self.pictures.append(item)

    async def until_pictures(self, count: int) -> None:
        """Wait for so many more JPEGs."""
        wanted = len(self.pictures) + count

        def are_there() -> bool:
            self.read()
            return len(self.pictures) >= wanted

        await until(are_there)

    async def view(self, codec: str = "") -> Viewer:
        """Open a WebRTC viewer, who takes only ``codec`` if one is named."""
        return await Viewer.open(self, codec)


class Viewer:
    """A WHEP client by aiortc."""

    def __init__(self, peer: RTCPeerConnection, session_id: str) -> None:
        self.peer, self.session_id = peer, session_id

    @classmethod
    async def open(cls, rig: CameraRig, codec: str) -> Viewer:
        """Offer, and take the answer."""
        peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        transceiver = peer.addTransceiver("video", direction="recvonly")
        known = RTCRtpReceiver.getCapabilities("video")
        assert known is not None
        transceiver.setCodecPreferences([one for one in known.codecs if codec in one.mimeType])
        await peer.setLocalDescription(await peer.createOffer())
        session_id, answer = await rig.whep.open(rig.page, rig.camera, peer.localDescription.sdp)
        await peer.setRemoteDescription(RTCSessionDescription(answer, "answer"))
        return cls(peer, session_id)

    async def frame(self) -> Any:
        """Return the next decoded picture."""
        return await self.peer.getReceivers()[0].track.recv()

    async def packets(self) -> int:
        """Return how many packets of pictures came."""
        report = await self.peer.getReceivers()[0].getStats()
        return sum(one.packetsReceived for one in report.values() if one.type == "inbound-rtp")

    async def close(self) -> None:
        """Leave without a word."""
        await self.peer.close()


@asynccontextmanager
async def camera_rig(**robot: Any) -> AsyncIterator[CameraRig]:
    """Serve a camera and know it."""
    with fake_camera(FakeCamera(**robot)) as served:
        rig = CameraRig(served, SystemClock())
        await rig.tell()
        try:
            yield rig
        finally:
            rig.page.end()
            await rig.whep.end()
            await rig.hub.end()

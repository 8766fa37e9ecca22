"""WebRTC to viewers by WHEP: an offer in, an answer out, packets of the shared encoder after that.

What is used of aiortc beyond its interface, each held by a test: ``RTCRtpSender._send_keyframe`` (asked by the viewer)
and its last RTP timestamp, which names a picture on the viewer's screen.
"""

from __future__ import annotations

import asyncio
import logging
import re
import secrets
from collections.abc import Callable
from typing import Protocol

from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription
from aiortc.rtcrtpparameters import RTCRtpCodecCapability

from hmi.cameras.camera import Camera
from hmi.cameras.demand import Way, Wish
from hmi.cameras.packet_track import PacketTrack, packet_of
from hmi.cameras.picture_wire import Piece
from hmi.domain.camera import SourceKind

log = logging.getLogger(__name__)
MAX_OFFER_BYTES = 32 * 1024
CONNECT_S = 12.0  # a viewer whose way does not open in this time is let go
_LOCAL = re.compile(r"^a=candidate:[^\r\n]*\s\S+\.local\s[^\r\n]*\r?\n", re.MULTILINE)
_CODEC = re.compile(r"^a=rtpmap:\d+\s+(H264|VP8)/90000", re.MULTILINE | re.IGNORECASE)


class WhepRefused(Exception):
    """No stream for this viewer; ``status``, ``code`` and a sentence."""

    def __init__(self, status: int, code: str, text: str) -> None:
        super().__init__(text)
        self.status, self.code, self.text = status, code, text


class TimesSink(Protocol):
    """A page: whose sessions end with it, who is told of each picture that was sent, and how wide it shows them."""

    def sent(self, camera: Camera, rtp: int, piece: Piece) -> None:
        """A picture went out under this RTP timestamp."""
        ...

    def width_of(self, camera: Camera) -> int:
        """Return how wide this page shows a camera, px; 0 if it does not say."""
        ...


class Session:
    """One viewer of one camera."""

    is_person = True

    def __init__(self, page: TimesSink, camera: Camera, way: Way, on_end: Callable[[Session], None]) -> None:
        self.id = secrets.token_urlsafe(18)
        self.page, self.camera = page, camera
        self.way = way
        self._on_end = on_end
        self._origin: int | None = None
        self.track = PacketTrack(self._begin, self._sent, camera.ask_key)
        self.peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self.peer.on("connectionstatechange", self._changed)
        self._ending: asyncio.Task[None] | None = None
        self._limit = asyncio.get_running_loop().call_later(CONNECT_S, self._too_late)

    @property
    def wish(self) -> Wish:
        """See ``Watch``."""
        return Wish(self.way, self.page.width_of(self.camera))

    async def answer(self, offer: str) -> str:
        """Return the answer to an offer; raises ``WhepRefused``."""
        transceiver = self.peer.addTransceiver(self.track, direction="sendonly")
        transceiver.setCodecPreferences(_codecs(self.way))  # before the offer is read, else H.264 goes as VP8
        sender = transceiver.sender
        sender._send_keyframe = self.camera.ask_key  # type: ignore[method-assign]
        try:
            await self.peer.setRemoteDescription(RTCSessionDescription(without_local(offer), "offer"))
            answer = await self.peer.createAnswer()
            assert answer is not None
            await self.peer.setLocalDescription(answer)
        except Exception as error:  # the reader of offers raises whatever it trips over
            raise WhepRefused(422, "bad_offer", "This offer cannot be answered.") from error
        self._sender = sender
        return self.peer.localDescription.sdp

    def take(self, piece: Piece) -> None:
        """See ``Watch``."""
        self.track.put(piece, packet_of(piece))

    def end(self) -> asyncio.Task[None]:
        """Let go of it, once."""
        if self._ending is None:
            self._limit.cancel()
            self.camera.leave(self)
            self._on_end(self)
            self._ending = asyncio.get_running_loop().create_task(self._close(), name=f"whep end {self.id}")
        return self._ending

    async def _close(self) -> None:
        self.track.stop()
        await self.peer.close()

    def _begin(self) -> None:
        """The way is open. An encoder makes a key picture now; a camera's own H.264 is begun where it began."""
        if self.way is Way.H264 and self.camera.source.kind in (SourceKind.RTSP, SourceKind.WHEP):
            self.track.begin_with(self.camera.group)
        self.camera.ask_key()

    def _sent(self, piece: Piece) -> None:
        rtp: int = self._sender._RTCRtpSender__rtp_timestamp  # type: ignore[attr-defined]
        self.page.sent(self.camera, rtp, piece)

    def _changed(self) -> None:
        if self.peer.connectionState == "connected":
            self._limit.cancel()
        elif self.peer.connectionState in ("failed", "closed"):
            self.end()

    def _too_late(self) -> None:
        log.info("a viewer of %s was not reached", self.camera.source.name)
        self.end()


class WhepDesk:
    """All sessions. ``most``: WebRTC viewers at once."""

    def __init__(self, most: int) -> None:
        self._most = most
        self.sessions: dict[str, Session] = {}
        self._endings: set[asyncio.Task[None]] = set()

    async def open(self, page: TimesSink, camera: Camera, offer: str) -> tuple[str, str]:
        """Return id and answer; raises ``WhepRefused``."""
        if len(self.sessions) >= self._most:
            raise WhepRefused(429, "too_many_viewers", f"{self._most} viewers watch already.")
        if camera.source.kind in (SourceKind.UPLOAD, SourceKind.SNAPSHOT):
            raise WhepRefused(409, "no_stream", "This camera sends single pictures.")
        session = Session(page, camera, way_of(offer), self._ended)
        self.sessions[session.id] = session
        camera.join(session)
        try:
            return session.id, await session.answer(offer)
        except BaseException:
            await session.end()
            raise

    async def end_of(self, page: TimesSink) -> None:
        """Let go of all sessions of a page."""
        await asyncio.gather(*(one.end() for one in list(self.sessions.values()) if one.page is page))

    async def end_camera(self, camera: Camera) -> None:
        """Let go of all sessions of a camera that is no more."""
        await asyncio.gather(*(one.end() for one in list(self.sessions.values()) if one.camera is camera))

    async def end(self) -> None:
        """Let go of everybody."""
        await asyncio.gather(*(one.end() for one in list(self.sessions.values())))

    def _ended(self, session: Session) -> None:
        self.sessions.pop(session.id, None)


def way_of(offer: str) -> Way:
    """Return what the viewer can take, H.264 before VP8; raises ``WhepRefused``."""
    offered = {name.upper() for name in _CODEC.findall(offer)}
    if "H264" in offered and "packetization-mode=1" in offer:
        return Way.H264
    if "VP8" in offered:
        return Way.VP8
    raise WhepRefused(409, "no_codec", "This browser takes neither H.264 nor VP8.")


def without_local(offer: str) -> str:
    """Take candidates out whose names nobody here can resolve: each costs a second and more."""
    return _LOCAL.sub("", offer)


def _codecs(way: Way) -> list[RTCRtpCodecCapability]:
    name = "video/H264" if way is Way.H264 else "video/VP8"
    return [one for one in RTCRtpSender.getCapabilities("video").codecs if one.mimeType in (name, "video/rtx")]

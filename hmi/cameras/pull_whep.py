"""Pulls a WebRTC source by WHEP: H.264 is handed on as it comes, without being decoded."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable
from typing import Any

import httpx
from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpReceiver, RTCSessionDescription
from aiortc.rtp import RtpPacket

from hmi.cameras.addresses import Target, target_of
from hmi.cameras.depacketizer import Depacketizer
from hmi.cameras.inbox import Inbox, Unit
from hmi.cameras.pull_http import CONNECT_S, PullFailed, auth_of, reason_of, trust_for
from hmi.clock import mono_s
from hmi.domain.camera import Source

SILENT_S = 5.0
ASK_KEY_S = 0.5
KEY_EVERY_S = 2.0  # many cameras make none unasked: nobody could come late, and no clip would begin
MAX_ANSWER_BYTES = 64 * 1024
OnPacket = Callable[..., Awaitable[None]]


class WhepPull:
    """One WHEP source. ``run`` blocks in a thread of its own until the source fails."""

    codec, can_pass = "h264", True

    def __init__(self, source: Source, inbox: Inbox) -> None:
        self._source, self._inbox = source, inbox
        self._units = Depacketizer()
        self._heard_s = mono_s()
        self._asked_s = self._key_s = 0.0
        self._wants_key = False

    def run(self) -> None:
        """Pull until it fails; raises ``PullFailed``, ``BadAddress`` or ``httpx.HTTPError``."""
        asyncio.run(self._pull())

    def ask_key(self) -> None:
        """Ask with the next packet; called by another thread."""
        self._wants_key = True

    async def _pull(self) -> None:
        target = target_of(self._source.url, self._source.kind, self._source.nets)
        peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        headers = {"Host": target.host, "Accept-Encoding": "identity"}
        if self._source.token:
            headers["Authorization"] = f"Bearer {self._source.token}"
        async with httpx.AsyncClient(
            timeout=CONNECT_S,
            follow_redirects=False,
            trust_env=False,
            verify=trust_for(target.url),
            headers=headers,
            auth=auth_of(self._source),
        ) as client:
            place = ""
            try:
                place = await self._connect(peer, client, target)
                await self._watch(peer)
            finally:
                await peer.close()
                if place:
                    with contextlib.suppress(httpx.HTTPError):
                        await client.delete(place)

    async def _connect(self, peer: RTCPeerConnection, client: httpx.AsyncClient, target: Target) -> str:
        transceiver = peer.addTransceiver("video", direction="recvonly")
        known = RTCRtpReceiver.getCapabilities("video")
        assert known is not None
        transceiver.setCodecPreferences([one for one in known.codecs if one.mimeType == "video/H264"])
        take_packets(transceiver.receiver, self._take)
        await peer.setLocalDescription(await peer.createOffer())
        answer, location = await self._answer(client, target, peer.localDescription.sdp)
        try:
            await peer.setRemoteDescription(RTCSessionDescription(answer, "answer"))
        except Exception as error:  # the reader of answers raises whatever it trips over
            raise PullFailed("the camera's answer is not understood") from error
        self._receiver = transceiver.receiver
        return place_of(target.url, location)

    async def _answer(self, client: httpx.AsyncClient, target: Target, offer: str) -> tuple[str, str]:
        """Return the answer to an offer, and where the session is."""
        data = bytearray()
        async with client.stream(
            "POST",
            target.url,
            content=offer,
            headers={"Content-Type": "application/sdp"},
            extensions={"sni_hostname": target.hostname},
        ) as answer:
            if answer.status_code != 201:
                known = reason_of(answer.status_code)
                raise PullFailed(known or f"the camera answers {answer.status_code} instead of a stream")
            async for piece in answer.aiter_raw():
                data += piece
                if len(data) > MAX_ANSWER_BYTES:
                    raise PullFailed("the camera's answer is not understood")
        return data.decode("utf-8", "replace"), answer.headers.get("location", "")

    async def _watch(self, peer: RTCPeerConnection) -> None:
        self._heard_s = mono_s()
        while True:
            await asyncio.sleep(0.2)
            if peer.connectionState in ("failed", "closed"):
                raise PullFailed("the connection to the camera broke off")
            if mono_s() - self._heard_s > SILENT_S:
                raise PullFailed("the camera sends no pictures")

    async def _take(self, packet: RtpPacket, arrival_time_ms: int) -> None:
        now_s = self._heard_s = mono_s()
        unit = self._units.add(packet)
        if unit is not None:
            self._inbox.put_unit(Unit(unit[0], now_s * 1000, unit[1]))
            if unit[1]:
                self._key_s, self._wants_key = now_s, False
        is_needed = (self._units.needs_key or self._wants_key) and now_s - self._asked_s > ASK_KEY_S
        if is_needed or now_s - max(self._key_s, self._asked_s) > KEY_EVERY_S:
            self._asked_s, self._wants_key = now_s, False
            await self._receiver._send_rtcp_pli(packet.ssrc)


def place_of(url: str, location: str) -> str:
    """Return where a session is ended; empty if none is told, or one that is not at the camera that was judged."""
    try:
        camera = httpx.URL(url)
        place = camera.join(location)
    except (httpx.InvalidURL, ValueError):
        return ""
    is_there = (place.scheme, place.host, place.port) == (camera.scheme, camera.host, camera.port)
    return str(place) if location and is_there and not place.userinfo else ""


def take_packets(receiver: Any, take: OnPacket) -> None:
    """Hand the packets of a receiver to ``take``; aiortc's own way would decode them."""
    receiver._handle_rtp_packet = take

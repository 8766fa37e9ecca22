"""A small RTSP server: H.264 over TCP (interleaved), digest or basic sign-in, any number of viewers."""

from __future__ import annotations

import asyncio
import base64
import random
import ssl
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from aiortc.codecs.h264 import H264Encoder
from aiortc.rtp import RtpPacket

from hmi.cameras.encoders import Decoder, VideoEncoder, fitted
from tests.hmi.cameras.fake_camera import jpeg

USER, PASSWORD = "viewer", "p@ss/word"  # a password of which an address could not be made by pasting
PERIOD_S = 1 / 15


def encoded(count: int = 30) -> list[bytes]:
    """Return access units; the first can be decoded alone."""
    decoder, encoder = Decoder("mjpeg"), VideoEncoder("libx264", 15)
    out = []
    for number in range(count):
        frame = decoder.decode(jpeg(320, 240, number))
        assert frame is not None
        made = encoder.encode(fitted(frame, 0, "yuv420p"), number * 66.7, is_key=number == 0)
        assert made is not None
        out.append(made[0])
    return out


class RtspServer:
    """What the server knows."""

    def __init__(self, *, asks_password: bool = False) -> None:
        self.asks_password = asks_password
        self.units = encoded()
        self.viewers = 0
        self.url = ""
        self.is_silent = False
        self.has_reports = False
        self.waits_s = 0.0  # how long what it sends has been in its send buffer, by its own reports
        self.waits_longer = 0.0  # by this share of the time between two pictures, with each of them
        self.sends_to = ""
        self.heard = 0

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve one connection."""
        playing: asyncio.Task[None] | None = None
        self.heard += 1
        try:
            while True:
                head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1")
                if head.startswith("$"):  # RTCP of the viewer came before its last word
                    return
                method, headers = head.split(" ", 1)[0], _headers(head)
                await self._answer(writer, method, headers)
                if method == "PLAY" and playing is None:
                    playing = asyncio.create_task(self._play(writer))
                if method == "TEARDOWN":
                    return
        except (asyncio.IncompleteReadError, ConnectionError):
            return
        finally:
            if playing is not None:
                playing.cancel()
                await asyncio.gather(playing, return_exceptions=True)
            writer.close()

    async def _answer(self, writer: asyncio.StreamWriter, method: str, headers: dict[str, str]) -> None:
        sequence = headers.get("cseq", "0")
        good = "Basic " + base64.b64encode(f"{USER}:{PASSWORD}".encode()).decode()
        if self.asks_password and method != "OPTIONS" and headers.get("authorization") != good:
            refusal = f'RTSP/1.0 401 Unauthorized\r\nCSeq: {sequence}\r\nWWW-Authenticate: Basic realm="c"\r\n\r\n'
            writer.write(refusal.encode())
            return
        if self.sends_to and method == "DESCRIBE":
            writer.write(f"RTSP/1.0 302 Found\r\nCSeq: {sequence}\r\nLocation: {self.sends_to}\r\n\r\n".encode())
            return
        body, extra = "", ""
        if method == "OPTIONS":
            extra = "Public: OPTIONS, DESCRIBE, SETUP, PLAY, TEARDOWN\r\n"
        elif method == "DESCRIBE":
            body = (
                "v=0\r\no=- 1 1 IN IP4 127.0.0.1\r\ns=camera\r\nt=0 0\r\nm=video 0 RTP/AVP 96\r\nc=IN IP4 0.0.0.0\r\n"
                "a=rtpmap:96 H264/90000\r\na=fmtp:96 packetization-mode=1\r\na=control:track\r\n"
            )
            extra = f"Content-Type: application/sdp\r\nContent-Base: {self.url}/\r\n"
        elif method == "SETUP":
            extra = "Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\nSession: 1\r\n"
        elif method == "PLAY":
            extra = "Session: 1\r\n"
        length = f"Content-Length: {len(body)}\r\n" if body else ""
        writer.write(f"RTSP/1.0 200 OK\r\nCSeq: {sequence}\r\n{extra}{length}\r\n{body}".encode())

    async def _play(self, writer: asyncio.StreamWriter) -> None:
        self.viewers += 1
        sequence, picture, offset = random.randrange(1000), 0, 0
        try:
            while True:
                self.waits_s += self.waits_longer * PERIOD_S
                if self.has_reports:
                    writer.write(_report(time.time() - self.waits_s, offset))
                if not self.is_silent:
                    unit = self.units[picture % len(self.units)]
                    payloads = H264Encoder._packetize(H264Encoder._split_bitstream(unit))
                    for number, payload in enumerate(payloads):
                        packet = RtpPacket(payload_type=96, sequence_number=sequence & 0xFFFF, timestamp=offset)
                        packet.payload, packet.marker, packet.ssrc = payload, int(number == len(payloads) - 1), 7
                        data = packet.serialize()
                        writer.write(b"$\x00" + len(data).to_bytes(2, "big") + data)
                        sequence += 1
                    await writer.drain()
                picture, offset = picture + 1, offset + 6000
                await asyncio.sleep(PERIOD_S)
        finally:
            self.viewers -= 1


@asynccontextmanager
async def rtsp_server(*, asks_password: bool = False, trust: ssl.SSLContext | None = None) -> AsyncIterator[RtspServer]:
    """Serve at ``url`` until left."""
    served = RtspServer(asks_password=asks_password)
    server = await asyncio.start_server(served.serve, "127.0.0.1", 0, ssl=trust)
    served.url = f"rtsp{'s' if trust else ''}://127.0.0.1:{server.sockets[0].getsockname()[1]}/live"
    try:
        yield served
    finally:
        server.close()


def _report(taken_s: float, stamp: int) -> bytes:
    """Return a sender report: what the camera's clock showed at a time stamp."""
    ntp = int((taken_s + 2_208_988_800) * 2**32)
    packet = b"\x80\xc8\x00\x06" + (7).to_bytes(4, "big") + ntp.to_bytes(8, "big") + stamp.to_bytes(4, "big") + bytes(8)
    return b"$\x01" + len(packet).to_bytes(2, "big") + packet


def _headers(head: str) -> dict[str, str]:
    lines = (line.partition(":") for line in head.split("\r\n")[1:])
    return {name.strip().lower(): value.strip() for name, _, value in lines if name}

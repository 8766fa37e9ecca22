"""Between libav and an RTSP camera: libav would follow a redirect to any address, and believes any certificate.

libav is given a door of this machine; what it says goes to the one address that was judged, and nowhere else.
"""

from __future__ import annotations

import asyncio
import re
import ssl
import threading
from types import TracebackType
from urllib.parse import urlsplit, urlunsplit

from hmi.cameras.addresses import SCHEMES, Target
from hmi.cameras.sender_clock import SenderClock
from hmi.clock import mono_s
from hmi.domain.camera import SourceKind

OPEN_S = 6.0
MOST_BEFORE = 256 * 1024  # bytes of words before the first picture
PIECE = 64 * 1024
_ELSEWHERE = re.compile(rb"RTSP/1\S*\s+\+?0*3\d\d")  # as loosely as libav reads it, which leaves out every \r


class RtspGuard:
    """Serves one source while it is entered, from a thread of its own.

    ``why`` says what it could not do, in words; ``clock`` how long the newest picture waited on its way.
    """

    def __init__(self, target: Target) -> None:
        self._target, self._parts = target, urlsplit(target.url)
        self._loop = asyncio.new_event_loop()
        self._server: asyncio.Server | None = None
        self._thread = threading.Thread(target=self._loop.run_forever, name="rtsp guard", daemon=True)
        self.why = ""
        self.clock = SenderClock()

    def __enter__(self) -> RtspGuard:
        self._thread.start()
        serving = asyncio.start_server(self._serve, "127.0.0.1", 0)
        self._server = asyncio.run_coroutine_threadsafe(serving, self._loop).result()
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        asyncio.run_coroutine_threadsafe(self._end(), self._loop).result()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    @property
    def url(self) -> str:
        """What libav opens."""
        assert self._server is not None
        port = self._server.sockets[0].getsockname()[1]
        return urlunsplit(("rtsp", f"127.0.0.1:{port}", self._parts.path, self._parts.query, ""))

    async def _end(self) -> None:
        assert self._server is not None
        self._server.close()
        others = asyncio.all_tasks() - {asyncio.current_task()}
        for one in others:
            one.cancel()
        await asyncio.gather(*others, return_exceptions=True)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            camera = await self._connected()
            if camera is not None:
                await _Relay(self, (reader, writer), camera).run()
        finally:
            writer.close()

    async def _connected(self) -> tuple[asyncio.StreamReader, asyncio.StreamWriter] | None:
        is_tls = self._parts.scheme == "rtsps"
        trust = ssl.create_default_context() if is_tls else None
        port = self._parts.port or SCHEMES[SourceKind.RTSP][self._parts.scheme]
        name = self._target.hostname if is_tls else None
        try:
            async with asyncio.timeout(OPEN_S):
                return await asyncio.open_connection(self._parts.hostname, port, ssl=trust, server_hostname=name)
        except ssl.SSLCertVerificationError:
            self.why = "the camera's certificate is not one that this machine trusts"
        except TimeoutError:
            self.why = "the camera does not answer"
        except OSError:
            self.why = "nothing answers at the camera's address"
        return None


class _Relay:
    """One connection. Until libav asks for pictures the camera's words are read: after that it follows none."""

    def __init__(
        self,
        guard: RtspGuard,
        libav: tuple[asyncio.StreamReader, asyncio.StreamWriter],
        camera: tuple[asyncio.StreamReader, asyncio.StreamWriter],
    ) -> None:
        self._guard, self._libav, self._camera = guard, libav, camera
        self._has_asked = False
        self._words = bytearray()

    async def run(self) -> None:
        """Relay until either side ends, or the camera sends elsewhere."""
        ways = [asyncio.create_task(self._up()), asyncio.create_task(self._down())]
        try:
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for one in ways:
                one.cancel()
            await asyncio.gather(*ways, return_exceptions=True)
            self._camera[1].close()

    async def _up(self) -> None:
        reader, writer = self._libav[0], self._camera[1]
        while data := await reader.read(PIECE):
            self._has_asked = self._has_asked or data.startswith(b"PLAY ")
            writer.write(data)
            await writer.drain()

    async def _down(self) -> None:
        reader, writer = self._camera[0], self._libav[1]
        while data := await reader.read(PIECE):
            if self._has_asked:
                self._guard.clock.feed(data, mono_s() * 1000)
            elif not self._is_harmless(data):
                return
            writer.write(data)
            await writer.drain()

    def _is_harmless(self, data: bytes) -> bool:
        self._words += data.replace(b"\r", b"")
        if _ELSEWHERE.search(self._words):
            self._guard.why = "the camera sends elsewhere, which is not followed"
        elif len(self._words) > MOST_BEFORE:
            self._guard.why = "the camera's answer is not understood"
        else:
            return True
        return False

"""The socket of one page: its streams, the newest picture of each, and the proof that the page lives."""

from __future__ import annotations

import asyncio
import secrets
import struct
from collections import deque
from typing import Any, Literal

import msgspec
from msgspec import Struct

from hmi.cameras.camera import Camera
from hmi.cameras.demand import Way, Wish
from hmi.cameras.hub import Hub
from hmi.cameras.pace import Pace
from hmi.cameras.picture_wire import Piece
from hmi.clock import Clock
from hmi.domain.camera import SourceKind

SILENT_S = 1.5
MOST_STREAMS = 64
MOST_TIMES = 120
STILL_FPS = 2.0
UNDER_WAY = 2  # pictures of a stream a page that acknowledges has not shown yet
HEAD = struct.Struct("<4sBBHdIHH")


class WatchFrame(Struct, frozen=True, tag_field="k", tag="watch"):
    """Begin or change stream ``n``."""

    n: int
    robot: str
    camera: str
    way: Literal["jpeg", "still", "times"]
    width: int = 0
    fps: float = 15.0


class DropFrame(Struct, frozen=True, tag_field="k", tag="drop"):
    """End stream ``n``."""

    n: int


class PingFrame(Struct, frozen=True, tag_field="k", tag="ping"):
    """The page lives."""

    m: float = 0.0


class SeenFrame(Struct, frozen=True, tag_field="k", tag="seen"):
    """Picture ``seq`` of stream ``n`` was drawn."""

    n: int
    seq: int


Frame = WatchFrame | DropFrame | PingFrame | SeenFrame
_decoder: msgspec.json.Decoder[Frame] = msgspec.json.Decoder(Frame)


class Stream:
    """One camera on one page."""

    is_person = True

    def __init__(self, page: Page, frame: WatchFrame, camera: Camera) -> None:
        self._page, self.camera, self.n, self.way = page, camera, frame.n, frame.way
        fps = min(frame.fps, STILL_FPS) if frame.way == "still" else frame.fps
        self.wish = Wish(Way.JPEG, max(0, frame.width), min(30.0, max(0.2, fps)))
        self._pace = Pace(self.wish.fps)
        self._newest: Piece | None = None
        self._under_way: deque[int] | None = None

    def begin(self) -> None:
        """Look, and show what is there already."""
        self.camera.hearers.add(self)
        if self.way == "times":
            return
        self.camera.join(self)
        shown = self.camera.newest_jpeg
        if shown is not None and self.camera.source.kind is SourceKind.UPLOAD:  # the next may come in an hour
            self.take(shown)

    def end(self) -> None:
        """Look away."""
        self.camera.hearers.discard(self)
        self.camera.leave(self)

    def tell(self, camera: Camera) -> None:
        """See ``Hearer``."""
        self._page.say({"k": "state", "n": self.n, "camera": camera.describe()})

    def take(self, piece: Piece) -> None:
        """See ``Watch``: keep the newest, at most so many a second."""
        if self._pace.is_due(self._page.clock.mono_s()):
            self._newest = piece
            self._page.wake()

    def seen(self, seq: int) -> None:
        """The page drew a picture."""
        if self._under_way is None:
            self._under_way = deque()
        while self._under_way and self._under_way[0] <= seq:
            self._under_way.popleft()
        self._page.wake()

    def next(self) -> bytes | None:
        """Return the newest picture if it may be sent now."""
        piece = self._newest
        if piece is None or (self._under_way is not None and len(self._under_way) >= UNDER_WAY):
            return None
        self._newest = None
        if self._under_way is not None:
            self._under_way.append(piece.seq)
        flags = 1 if piece.is_dated else 0
        head = HEAD.pack(b"HLC1", self.n, flags, piece.width, piece.captured_ms, piece.seq, piece.height, 0)
        return head + piece.data


class Page:
    """Everything one page watches."""

    def __init__(self, hub: Hub, clock: Clock, viewer: str) -> None:
        self._hub, self.clock, self.viewer = hub, clock, viewer
        self.token = secrets.token_urlsafe(24)
        self.streams: dict[int, Stream] = {}
        self._texts: deque[str] = deque(maxlen=400)
        self._states: dict[int, str] = {}
        self._times: dict[int, deque[list[float]]] = {}
        self._wake = asyncio.Event()
        self._heard_s = clock.mono_s()
        self._say({"k": "hello", "watcher": self.token, "m": round(self._heard_s * 1000, 1)})

    @property
    def is_silent(self) -> bool:
        """Whether the page is gone without a word."""
        return self.clock.mono_s() - self._heard_s > SILENT_S

    def forgive(self, seconds: float) -> None:
        """Its words may have waited for so long before they could be heard."""
        self._heard_s = min(self._heard_s + seconds, self.clock.mono_s())

    def wake(self) -> None:
        """There is something to send."""
        self._wake.set()

    def hear(self, text: str) -> bool:
        """Take a frame of the page; return whether it was one."""
        try:
            frame = _decoder.decode(text)
        except (msgspec.DecodeError, RecursionError, UnicodeError):
            return False
        self._heard_s = self.clock.mono_s()
        match frame:
            case WatchFrame():
                self._watch(frame)
            case DropFrame():
                self._drop(frame.n)
            case SeenFrame():
                if frame.n in self.streams:
                    self.streams[frame.n].seen(frame.seq)
            case PingFrame():
                self._say({"k": "pong", "m": frame.m, "at": round(self._heard_s * 1000, 1)})
        return True

    def say(self, message: dict[str, Any]) -> None:
        """Say something of a stream; only the newest of each counts."""
        self._states[message["n"]] = msgspec.json.encode(message).decode()
        self.wake()

    def sent(self, camera: Camera, rtp: int, piece: Piece) -> None:
        """See ``TimesSink``."""
        for stream in self.streams.values():
            if stream.camera is camera and stream.way == "times":
                row = [rtp, round(piece.captured_ms, 1), piece.seq]
                self._times.setdefault(stream.n, deque(maxlen=MOST_TIMES)).append(row)
                self.wake()

    def width_of(self, camera: Camera) -> int:
        """See ``TimesSink``."""
        widths = [stream.wish.width for stream in self.streams.values() if stream.camera is camera]
        return 0 if 0 in widths else max(widths, default=0)

    def forget(self, camera: Camera) -> None:
        """A camera is no more."""
        for n in [n for n, stream in self.streams.items() if stream.camera is camera]:
            self._drop(n)
            self._refuse(n, "unknown_camera", "There is no such camera any more.")

    def end(self) -> None:
        """Let go of every stream."""
        for n in list(self.streams):
            self._drop(n)

    async def wait(self) -> None:
        """Wait until there is something to send."""
        await self._wake.wait()
        self._wake.clear()

    def next(self) -> str | bytes | None:
        """Return what to send next: words before pictures, then each stream in turn."""
        if self._texts:
            return self._texts.popleft()
        if self._states:
            return self._states.pop(next(iter(self._states)))
        if self._times:
            n = next(iter(self._times))
            return msgspec.json.encode({"k": "times", "n": n, "p": list(self._times.pop(n))}).decode()
        for n in list(self.streams):
            picture = self.streams[n].next()
            if picture is not None:
                self.streams[n] = self.streams.pop(n)  # to the end of the row
                return picture
        return None

    def _watch(self, frame: WatchFrame) -> None:
        if not 1 <= frame.n <= MOST_STREAMS:
            self._refuse(frame.n, "too_many_streams", f"A page shows at most {MOST_STREAMS} cameras.")
            return
        camera = self._hub.get(frame.robot, frame.camera)
        if camera is None:
            self._drop(frame.n)
            self._refuse(frame.n, "unknown_camera", "There is no such camera.")
            return
        stream = Stream(self, frame, camera)
        stream.begin()  # before the old one ends: the camera runs on
        self._drop(frame.n)
        self.streams[frame.n] = stream
        camera.replan()  # how wide it is wanted counts for its direct pictures too
        stream.tell(camera)

    def _drop(self, n: int) -> None:
        stream = self.streams.pop(n, None)
        self._states.pop(n, None)
        self._times.pop(n, None)
        if stream is not None:
            stream.end()

    def _refuse(self, n: int, code: str, text: str) -> None:
        self._say({"k": "refused", "n": n, "code": code, "text": text})

    def _say(self, message: dict[str, Any]) -> None:
        self._texts.append(msgspec.json.encode(message).decode())
        self.wake()

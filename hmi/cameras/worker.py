"""The process of one camera: pull, decode what must be decoded, encode once, hand over.

It lives as long as its source. Whatever goes wrong ends it, and only it; the camera process starts another.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import socket
import sys
import threading
from typing import Protocol

import av
import httpx
import msgspec
from av.video.frame import VideoFrame

from hmi.cameras.addresses import BadAddress
from hmi.cameras.encoders import Decoder, JpegEncoder, VideoEncoder, fitted
from hmi.cameras.group import Group
from hmi.cameras.inbox import Inbox, Shot, Unit
from hmi.cameras.jpeg_header import size_of
from hmi.cameras.multipart import Refused
from hmi.cameras.pace import Pace
from hmi.cameras.picture_wire import JpegWish, KeyPicture, Kind, News, Piece, Plan, order_decoder
from hmi.cameras.pull_http import HttpPull, PullFailed
from hmi.clock import mono_s
from hmi.domain.camera import Source, SourceKind
from hmi.planning.side_process import limit_memory

NICE = 5
MEMORY_BYTES = 3 * 1024**3  # address space: 0.5 GB with everything loaded, and the frames a decoder may hold
NEWS_S = 1.0
REPEAT_S = 15.0  # an older picture is not sent again for somebody who comes late; its age goes with it
PR_SET_PDEATHSIG = 1
MOST_BETWEEN_KEYS = 300  # more, and who comes late would wait: then it is not passed on but encoded here
BAD_IN_A_ROW = 30  # nothing but garbage: the source is opened anew


class Pull(Protocol):
    """Fills the inbox until the source fails."""

    def run(self) -> None:
        """Block until it fails."""
        ...

    def ask_key(self) -> None:
        """Ask the camera for a picture that can be decoded alone, if it can be asked; from any thread."""
        ...


def run_worker(source_json: bytes, plan_json: bytes, link: socket.socket, mark: str = "") -> None:
    """Serve one source over ``link``; returns when the source fails, ends the process when ``link`` does."""
    _settle()
    source = msgspec.json.decode(source_json, type=Source)
    plan = order_decoder.decode(plan_json)
    assert isinstance(plan, Plan)
    with contextlib.suppress(ConnectionError):  # the camera process let go
        Worker(source, plan, link, mark).run()


def _settle() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    limit_memory(MEMORY_BYTES)
    av.logging.set_level(None)  # its words go nowhere; what matters comes as an error


class Worker:
    """Threads: one pulls, one hears orders, the caller's decodes and encodes; frames never leave it."""

    def __init__(self, source: Source, plan: Plan, link: socket.socket, mark: str = "") -> None:
        self._source, self._link = source, link
        self._plan = plan
        self._inbox = Inbox(mark)
        self._wants_key, self._waits_key = True, False
        self._seq = 0
        self._last: tuple[VideoFrame, float, bool] | None = None
        self._last_item: Shot | Unit | None = None
        self._video: dict[Kind, VideoEncoder] = {}
        self._jpegs: dict[int, JpegEncoder] = {}
        self._paces: dict[JpegWish, Pace] = {}
        self._decoder: Decoder | None = None
        self._group: Group[Unit] = Group(MOST_BETWEEN_KEYS)
        self._is_remade = False
        self._pull: Pull = self._make_pull()

    def run(self) -> None:
        """Work until the source fails."""
        threading.Thread(target=self._hear, name="orders", daemon=True).start()
        threading.Thread(target=self._pulling, name="pull", daemon=True).start()
        told_s, bad = mono_s(), 0
        while True:
            item = self._inbox.take(NEWS_S / 2)
            if item is not None:
                try:
                    self._handle(item)
                    bad = 0
                    self._be_nice()
                except (av.FFmpegError, ValueError) as error:
                    bad += 1
                    self._inbox.refuse(f"it cannot be decoded ({type(error).__name__})")
            self._repeat()
            if bad >= BAD_IN_A_ROW:
                self._inbox.end("nothing it sends can be decoded")
            ended = self._inbox.ended
            if mono_s() - told_s >= NEWS_S or ended is not None:
                told_s = mono_s()
                self._link.sendall(self._news(ended or "").packed())
            if ended is not None:
                return

    def _be_nice(self) -> None:
        """Somebody waits for the first picture; from then on the console and STOP come first."""
        if self._seq == 1:
            with contextlib.suppress(OSError):
                os.nice(NICE)

    def _news(self, ended: str) -> News:
        box = self._inbox
        return News(
            pictures=box.pictures, size=box.size, bad=box.bad, why=box.why, skipped=box.skipped, ended=ended,
            mark=box.mark, waits_key=self._waits_key,
        )  # fmt: skip

    def _make_pull(self) -> Pull:
        if self._source.kind is SourceKind.RTSP:
            from hmi.cameras.pull_rtsp import RtspPull

            return RtspPull(self._source, self._inbox)
        if self._source.kind is SourceKind.WHEP:
            from hmi.cameras.pull_whep import WhepPull

            return WhepPull(self._source, self._inbox)
        return HttpPull(self._source, lambda: self._plan, self._inbox)

    def _pulling(self) -> None:
        try:
            self._pull.run()
            reason = "the camera ended its stream"
        except (PullFailed, BadAddress, Refused) as error:
            reason = str(error)
        except httpx.TimeoutException:
            reason = "the camera does not answer"
        except httpx.ConnectError:
            reason = "nothing answers at the camera's address"
        except httpx.HTTPError:
            reason = "the connection to the camera broke off"
        except (av.HTTPUnauthorizedError, av.HTTPForbiddenError):
            reason = "the camera does not accept the password it was given"
        except av.FFmpegError as error:
            reason = f"the camera cannot be opened: {error.strerror or type(error).__name__}"
        except Exception as error:  # noqa: BLE001 - the thread's end must be told, whatever ended it
            reason = f"the camera cannot be read ({type(error).__name__})"
        self._inbox.end(reason)

    def _hear(self) -> None:
        with contextlib.suppress(OSError), self._link.makefile("rb") as lines:
            for line in lines:
                order = order_decoder.decode(line)
                if isinstance(order, Plan):
                    self._plan = order
                elif isinstance(order, KeyPicture):
                    self._wants_key = True
                    self._pull.ask_key()
                self._inbox.nudge()
        os._exit(0)  # the camera process let go, or is no more

    def _handle(self, item: Shot | Unit) -> None:
        self._seq += 1
        self._last_item = item
        plan = self._plan
        if isinstance(item, Shot):
            self._handle_shot(item, plan)
        else:
            self._handle_unit(item, plan)

    def _handle_shot(self, shot: Shot, plan: Plan) -> None:
        width, height = size_of(shot.data)
        due = self._due(plan.jpegs)
        as_it_came = [one for one in due if not one.width or one.width >= width]
        for one in as_it_came:
            self._send(Kind.JPEG, shot.data, shot.captured_ms, width, height, shot.is_dated, wanted=one.width)
        smaller = [one for one in due if one.width and one.width < width]
        has_video = plan.has_h264 or plan.has_vp8
        if not has_video:
            self._last = None
        if not smaller and not has_video:
            return
        if self._decoder is None:
            self._decoder = Decoder("mjpeg")
        frame = self._decoder.decode(shot.data)
        if frame is not None:
            self._encode(frame, shot.captured_ms, smaller, plan, is_dated=shot.is_dated)

    def _handle_unit(self, unit: Unit, plan: Plan) -> None:
        due = self._due(plan.jpegs)
        if not unit.is_key and self._group.is_full_for(unit):
            self._remake()
        self._group.add(unit)
        self._waits_key = not self._group.row and not self._is_remade
        if self._waits_key:
            self._pull.ask_key()  # nobody could show what comes before it
            return
        if self._can_pass and plan.has_h264:
            info = self._source.camera
            self._send(Kind.H264, unit.data, unit.captured_ms, info.width_px, info.height_px, False, is_key=unit.is_key)
        needs_frames = plan.has_vp8 or bool(plan.jpegs) or (plan.has_h264 and not self._can_pass)
        if not needs_frames and not self._is_remade:
            self._decoder = None  # it begins again with the last key picture
            return
        if self._decoder is None:
            self._decoder = self._decoder_after(self._group.row[:-1])
        frame = self._decoder.decode(unit.data)
        if frame is None:
            return
        self._encode(frame, unit.captured_ms, due, self._to_encode(plan), is_dated=False)

    @property
    def _can_pass(self) -> bool:
        """Whether a camera's own H.264 goes on as it came."""
        return getattr(self._pull, "can_pass", True) and not self._is_remade

    def _remake(self) -> None:
        """Its key pictures are too far apart: from now on every picture is decoded, and encoded for who wants video."""
        if self._is_remade:
            return
        if self._decoder is None:
            self._decoder = self._decoder_after(self._group.row)
        self._is_remade = self._wants_key = True

    def _decoder_after(self, units: list[Unit]) -> Decoder:
        decoder = Decoder(getattr(self._pull, "codec", "h264"))
        for one in units:
            decoder.decode(one.data)
        return decoder

    def _to_encode(self, plan: Plan) -> Plan:
        """Return what of a plan is encoded here: never H.264 beside a camera's own, which goes on as it came."""
        is_own = isinstance(self._last_item, Unit) and self._can_pass
        return msgspec.structs.replace(plan, has_h264=False) if is_own else plan

    def _encode(
        self, frame: VideoFrame, captured_ms: float, jpegs: list[JpegWish], plan: Plan, *, is_dated: bool
    ) -> None:
        if plan.has_h264 or plan.has_vp8:
            small = fitted(frame, plan.video_width, "yuv420p")
            self._last = (small, captured_ms, is_dated)
            key, self._wants_key = self._wants_key, False
            self._video_out(small, captured_ms, plan, is_key=key, is_dated=is_dated)
        for wish in jpegs:
            encoder = self._jpegs.setdefault(wish.width, JpegEncoder())
            scaled = fitted(frame, wish.width, "yuvj420p")
            self._send(
                Kind.JPEG, encoder.encode(scaled), captured_ms, scaled.width, scaled.height, is_dated,
                wanted=wish.width,
            )  # fmt: skip

    def _video_out(self, frame: VideoFrame, captured_ms: float, plan: Plan, *, is_key: bool, is_dated: bool) -> None:
        for kind, codec, is_wanted in (
            (Kind.H264, "libx264", plan.has_h264),
            (Kind.VP8, "libvpx", plan.has_vp8),
        ):
            if not is_wanted:
                self._video.pop(kind, None)
                continue
            encoder = self._video.setdefault(kind, VideoEncoder(codec, self._fps(plan)))
            made = encoder.encode(frame, captured_ms, is_key=is_key)
            if made is not None:
                data, made_key, pts = made
                self._send(kind, data, captured_ms, frame.width, frame.height, is_dated, is_key=made_key, pts=pts)

    def _fps(self, plan: Plan) -> float:
        return min(plan.fps, 1.0 / self._source.expected_period_s)

    def _repeat(self) -> None:
        """Whoever comes between two pictures gets the last one at once."""
        plan = self._to_encode(self._plan)
        if not self._wants_key or not (plan.has_h264 or plan.has_vp8):
            return
        last = self._last or self._decoded(plan)
        if last is None or mono_s() - last[1] / 1000 > REPEAT_S:
            return
        self._last, self._wants_key = last, False
        frame, captured_ms, is_dated = last
        self._video_out(frame, captured_ms, plan, is_key=True, is_dated=is_dated)

    def _decoded(self, plan: Plan) -> tuple[VideoFrame, float, bool] | None:
        """Return the last JPEG as a frame, if nobody needed one before."""
        shot = self._last_item
        if not isinstance(shot, Shot):
            return None
        try:
            frame = Decoder("mjpeg").decode(shot.data)
        except av.FFmpegError:
            return None
        return None if frame is None else (fitted(frame, plan.video_width, "yuv420p"), shot.captured_ms, shot.is_dated)

    def _due(self, wishes: tuple[JpegWish, ...]) -> list[JpegWish]:
        now_s = mono_s()
        return [one for one in wishes if self._paces.setdefault(one, Pace(one.fps)).is_due(now_s)]

    def _send(
        self, kind: Kind, data: bytes, captured_ms: float, width: int, height: int, is_dated: bool,
        *, is_key: bool = True, wanted: int = 0, pts: int | None = None,
    ) -> None:  # fmt: skip
        """Blocks while the camera process is behind: newer pictures then replace older ones in the inbox."""
        at = round(captured_ms * 90) if pts is None else pts
        piece = Piece(kind, data, captured_ms, self._seq, width, height, is_key, is_dated, wanted, at)
        self._link.sendall(piece.packed())
